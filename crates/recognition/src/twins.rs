//! Objects that only colour tells apart.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::library::LibraryObject;
use crate::symmetry::{SameSurface, mean_distance_m};

/// Another object with the same surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Twin {
    /// Its index in the library.
    pub object: usize,
    /// The twin's item frame from that of the object it is a twin of, such that their surfaces coincide.
    pub twin_from_item: Isometry3<f64>,
}

/// The greatest ratio of volumes of twins.
const MAX_VOLUME_RATIO: f64 = 1.25;

/// Outlines of twins differ by less than this.
const MAX_OUTLINE_DIFFERENCE: f64 = 40.0;

/// Yaws at which a pose of one is compared with a pose of the other.
const YAWS: u32 = 24;

/// The twins of an object.
pub(crate) fn twins(objects: &[LibraryObject], index: usize, same: &SameSurface) -> Vec<Twin> {
    let Some(object) = objects.get(index) else {
        return Vec::new();
    };
    let others = objects
        .iter()
        .enumerate()
        .filter(|(other, _)| *other != index);
    others
        .filter_map(|(other, candidate)| {
            let twin_from_item = coincidence(object, candidate, same)?;
            Some(Twin {
                object: other,
                twin_from_item,
            })
        })
        .collect()
}

/// The transform that brings an object's surface onto another's, both ways; `None` where they differ.
fn coincidence(
    object: &LibraryObject,
    other: &LibraryObject,
    same: &SameSurface,
) -> Option<Isometry3<f64>> {
    let (volume, other_volume) = (object.model.volume_m3, other.model.volume_m3);
    if volume.max(other_volume) > MAX_VOLUME_RATIO * volume.min(other_volume) {
        return None;
    }
    let pose = object.poses.first()?;
    let like = other
        .poses
        .iter()
        .filter(|candidate| pose.outline.difference(&candidate.outline) <= MAX_OUTLINE_DIFFERENCE);
    let guesses = like.flat_map(|candidate| {
        (0..YAWS).map(|step| {
            let angle = std::f64::consts::TAU * f64::from(step) / f64::from(YAWS);
            let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
            candidate.support_from_item.inverse() * yaw * pose.support_from_item
        })
    });
    // Of all that fit, the closest: objects that are nearly symmetric fit in several ways.
    guesses
        .filter_map(|guess| same.fitted(&other.nearest, &object.points, &guess))
        .filter(|found| same.holds(&object.nearest, &other.points, &found.inverse()))
        .map(|found| {
            (
                mean_distance_m(&other.nearest, &object.points, &found),
                found,
            )
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, found)| found)
}
