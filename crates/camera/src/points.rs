//! Organised images of points.

use nalgebra::{Isometry3, Point3};

/// What a depth camera publishes: a point per pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct PointImage {
    width: usize,
    points_m: Vec<Point3<f32>>,
}

impl PointImage {
    pub(crate) fn new(width: usize, points_m: Vec<Point3<f32>>) -> Self {
        Self { width, points_m }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.points_m.len() / self.width.max(1)
    }

    /// The points in the camera frame in metres, row by row; NaN in all three coordinates where nothing was measured.
    pub fn points_m(&self) -> &[Point3<f32>] {
        &self.points_m
    }

    /// The points that were measured, in the world, in metres.
    pub fn in_world_m(
        &self,
        world_from_camera: &Isometry3<f64>,
    ) -> impl Iterator<Item = Point3<f64>> + '_ {
        let rotation = world_from_camera.rotation.to_rotation_matrix();
        let translation = world_from_camera.translation.vector;
        let measured = self.points_m.iter().filter(|point| !point.z.is_nan());
        measured.map(move |point| rotation * point.cast::<f64>() + translation)
    }
}

/// The point of a pixel without a measurement.
pub(crate) fn hole() -> Point3<f32> {
    Point3::new(f32::NAN, f32::NAN, f32::NAN)
}
