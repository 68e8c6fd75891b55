//! Objects that only colour tells apart.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::object::{LibraryObject, Twin};
use crate::samples::yaws_rad;
use crate::symmetry::{SameSurface, mean_distance_m};

/// Maximum ratio of the volumes of twins.
const MOST_VOLUME_RATIO: f64 = 1.25;
/// Maximum difference of their outlines in a resting pose.
const MOST_OUTLINE_DIFFERENCE: f64 = 40.0;
/// Number of yaws at which a pose of one is compared with a pose of the other.
const YAWS: usize = 24;

/// Finds the twins of an object among all.
pub(crate) fn twins(
    objects: &[LibraryObject],
    object: &LibraryObject,
    same: &SameSurface,
) -> Vec<Twin> {
    let others = objects.iter().enumerate();
    let others = others.filter(|(_, other)| !std::ptr::eq(*other, object));
    let twins = others.filter_map(|(index, other)| {
        Some(Twin {
            object: index,
            twin_from_item: coincidence(object, other, same)?,
        })
    });
    twins.collect()
}

/// Finds the transform that brings an object's surface onto another's, both ways; `None` where they
/// differ.
fn coincidence(
    object: &LibraryObject,
    other: &LibraryObject,
    same: &SameSurface,
) -> Option<Isometry3<f64>> {
    let (volume, other_volume) = (object.model.volume_m3, other.model.volume_m3);
    if volume.max(other_volume) > MOST_VOLUME_RATIO * volume.min(other_volume) {
        return None;
    }
    let pose = object.poses.first()?;
    let like = other
        .poses
        .iter()
        .filter(|candidate| pose.outline.difference(&candidate.outline) <= MOST_OUTLINE_DIFFERENCE);
    let guesses = like.flat_map(|candidate| {
        yaws_rad(YAWS).map(|yaw_rad| {
            let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
            candidate.support_from_item.inverse() * yaw * pose.support_from_item
        })
    });
    let mean_m = |found: &Isometry3<f64>| mean_distance_m(&other.nearest, &object.points, found);
    // Of all that fit, the closest: objects that are nearly symmetric fit in several ways.
    guesses
        .filter_map(|guess| same.fitted(&other.nearest, &object.points, &guess))
        .filter(|found| same.holds(&object.nearest, &other.points, &found.inverse()))
        .map(|found| (mean_m(&found), found))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, found)| found)
}
