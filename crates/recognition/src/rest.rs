//! Poses at rest.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use ppnpack_catalogue::object::Model;

use crate::object::LibraryObject;

/// Gives the least turn that lays an object, turned like this, in a resting pose; z is up. `None`
/// beyond `most_rad` of each.
pub(crate) fn turn_to_rest(
    model: &Model,
    rotation: &UnitQuaternion<f64>,
    most_rad: f64,
) -> Option<UnitQuaternion<f64>> {
    let down = -Vector3::z();
    let leaning = model.resting_poses.iter().map(|pose| {
        let direction = rotation * (pose.rotation.inverse() * down);
        (direction.angle(&down), direction)
    });
    let (_, direction) = leaning.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let turn = UnitQuaternion::rotation_between(&direction, &down)?;
    (turn.angle() <= most_rad).then_some(turn)
}

/// Turns a pose as little as possible so that the object rests on the support; `None` where it
/// leans more than `most_rad` from each resting pose.
pub(crate) fn laid_at_rest(
    object: &LibraryObject,
    support_from_item: &Isometry3<f64>,
    most_rad: f64,
) -> Option<Isometry3<f64>> {
    let turn = turn_to_rest(&object.model, &support_from_item.rotation, most_rad)?;
    let centre = support_from_item * object.centre_m;
    let turned = Isometry3::rotation_wrt_point(turn, centre) * support_from_item;
    let rotation = turned.rotation.to_rotation_matrix();
    let vertices = object.model.mesh.vertices.iter();
    let heights_m = vertices.map(|vertex| (rotation * vertex).z);
    let lowest_m = heights_m.fold(f64::INFINITY, f64::min);
    let lift_m = -lowest_m - turned.translation.vector.z;
    Some(Translation3::new(0.0, 0.0, lift_m) * turned)
}
