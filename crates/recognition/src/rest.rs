//! Poses at rest.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::library::LibraryObject;

/// A pose that leans more than this from every resting pose stays as it is, in radians.
const GREATEST_LEAN_RAD: f64 = 0.2;

/// A pose turned as little as possible so that the object rests on the support; `None` where no resting pose is near.
pub(crate) fn laid_at_rest(
    object: &LibraryObject,
    support_from_item: &Isometry3<f64>,
) -> Option<Isometry3<f64>> {
    let down = -Vector3::z();
    let leaning = object.model.resting_poses.iter().map(|pose| {
        let direction = support_from_item.rotation * (pose.rotation.inverse() * down);
        (direction.angle(&down), direction)
    });
    let (lean_rad, direction) = leaning.min_by(|a, b| a.0.total_cmp(&b.0))?;
    if lean_rad > GREATEST_LEAN_RAD {
        return None;
    }
    let turn = UnitQuaternion::rotation_between(&direction, &down)?;
    let centre = support_from_item * object.centre_m;
    let turned = Isometry3::rotation_wrt_point(turn, centre) * support_from_item;
    let rotation = turned.rotation.to_rotation_matrix();
    let vertices = object.model.mesh.vertices.iter();
    let lowest_m = vertices
        .map(|vertex| (rotation * vertex).z)
        .fold(f64::INFINITY, f64::min);
    let lift_m = -lowest_m - turned.translation.vector.z;
    Some(Translation3::new(0.0, 0.0, lift_m) * turned)
}
