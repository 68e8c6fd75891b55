//! Which objects take part: those that the arm can hold as they come to lie on the tray.

use std::sync::Arc;

use nalgebra::{Isometry3, UnitQuaternion};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::grid::Resolution;
use ppnpack_recognition::posed::posed_item;
use ppnpack_robot::station::ArmStation;

/// The least chance that an object which takes part comes to lie in a way that the arm can hold.
const LEAST_CHANCE: f64 = 0.8;

/// The objects of a catalogue that take part, by index; all of them where there is no arm.
pub(super) fn objects(catalogue: &Catalogue, station: Option<&ArmStation>) -> Vec<usize> {
    let Some(station) = station else {
        return (0..catalogue.len()).collect();
    };
    let objects = catalogue.objects.iter().enumerate();
    objects
        .filter(|(_, object)| chance(&object.model, &catalogue.resolution, station) >= LEAST_CHANCE)
        .map(|(index, _)| index)
        .collect()
}

/// The chance that an object comes to rest in a pose in which the arm can hold it.
fn chance(model: &Arc<Model>, resolution: &Resolution, station: &ArmStation) -> f64 {
    let held = model.resting_poses.iter().filter(|pose| {
        let standing = Isometry3::from_parts(nalgebra::Translation3::identity(), pose.rotation);
        posed_item(model, &standing, resolution).is_ok_and(|posed| {
            let frame: &UnitQuaternion<f64> = &posed.heightmap_from_item;
            station.hold(&posed.item, &model.turned(frame));
            station.lift(&posed.item, resolution).is_ok()
        })
    });
    let all: f64 = model
        .resting_poses
        .iter()
        .map(|pose| pose.probability)
        .sum();
    let held: f64 = held.map(|pose| pose.probability).sum();
    held / all.max(f64::MIN_POSITIVE)
}
