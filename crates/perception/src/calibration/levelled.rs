//! A cloud seen along the vertical.

use nalgebra::{
    Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
};

/// Points in a level frame at the sensor: z up, x along the sensor's x axis seen from above. All
/// lie below the sensor.
#[derive(Debug, Clone)]
pub(super) struct Levelled {
    pub(super) levelled_from_sensor: Isometry3<f64>,
    pub(super) points_m: Vec<Point3<f64>>,
}

impl Levelled {
    pub(super) fn new(points_m: &[Point3<f64>], up: &Unit<Vector3<f64>>) -> Self {
        // Where the sensor's x axis is upright itself, its y axis takes its place.
        let is_upright = up.x.abs() >= 0.9;
        let sensor_x = if is_upright {
            Vector3::y()
        } else {
            Vector3::x()
        };
        let y = up.cross(&sensor_x).normalize();
        let x = y.cross(up);
        let rows = Matrix3::from_rows(&[x.transpose(), y.transpose(), up.transpose()]);
        let rotation = Rotation3::from_matrix_unchecked(rows);
        let points_m = points_m.iter().map(|point| rotation * point);
        let below = points_m.filter(|point| point.z < -0.02);
        Self {
            levelled_from_sensor: Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_rotation_matrix(&rotation),
            ),
            points_m: below.collect(),
        }
    }
}
