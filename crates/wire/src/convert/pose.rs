//! Poses and vectors.

use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};

use crate::error::{WireError, needed};
use crate::limits::{checked, coordinate_m};
use crate::v1;

/// Maximum difference of a quaternion's norm from 1.
const NORM_TOLERANCE: f64 = 1e-3;

/// Maximum difference of a unit quaternion's norm from 1, by rounding: it is kept bit for bit.
const ROUNDING: f64 = 1e-9;

/// Reads the pose that a field holds.
///
/// # Errors
/// [`WireError`] where it is missing, has a coordinate that is not possible, or is no rotation.
pub fn read_required(
    field: &'static str,
    message: Option<&v1::Pose>,
) -> Result<Isometry3<f64>, WireError> {
    let pose = needed(field, message)?;
    let missing = |part: &str| WireError::invalid(field, format_args!("it has no {part}"));
    let position = pose.position.as_ref().ok_or_else(|| missing("position"))?;
    let orientation = pose.orientation.as_ref();
    let orientation = orientation.ok_or_else(|| missing("orientation"))?;
    Ok(Isometry3::from_parts(
        Translation3::from(read_vector(field, position)?),
        read_rotation(field, orientation)?,
    ))
}

/// Reads a vector in metres that a field holds.
pub(super) fn read_vector(
    field: &'static str,
    vector: &v1::Vector3,
) -> Result<Vector3<f64>, WireError> {
    Ok(Vector3::new(
        coordinate_m(field, vector.x_m)?,
        coordinate_m(field, vector.y_m)?,
        coordinate_m(field, vector.z_m)?,
    ))
}

fn read_rotation(
    field: &'static str,
    rotation: &v1::Quaternion,
) -> Result<UnitQuaternion<f64>, WireError> {
    let v1::Quaternion { x, y, z, w } = *rotation;
    let quaternion = Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    let is_one = |tolerance: f64| (norm - 1.0).abs() <= tolerance;
    let found = format_args!("the quaternion's norm is {norm}");
    checked(field, found, is_one(NORM_TOLERANCE), "1 is needed")?;
    Ok(if is_one(ROUNDING) {
        Unit::new_unchecked(quaternion)
    } else {
        Unit::new_normalize(quaternion)
    })
}

/// Writes a pose.
pub fn write(pose: &Isometry3<f64>) -> v1::Pose {
    let rotation = pose.rotation.coords;
    v1::Pose {
        position: Some(write_vector(&pose.translation.vector)),
        orientation: Some(v1::Quaternion {
            x: rotation.x,
            y: rotation.y,
            z: rotation.z,
            w: rotation.w,
        }),
    }
}

pub(super) fn write_vector(vector: &Vector3<f64>) -> v1::Vector3 {
    v1::Vector3 {
        x_m: vector.x,
        y_m: vector.y,
        z_m: vector.z,
    }
}
