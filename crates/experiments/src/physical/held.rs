//! Objects that take part: they fit into the container, and the arm can hold them on the tray.

use std::sync::Arc;

use nalgebra::{Isometry3, Translation3};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::ranking::proposals::possible_count_below_rim;
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_recognition::posed::posed_item;
use ppnpack_robot::station::ArmStation;

/// The least chance that an object which takes part comes to lie in such a way.
const LEAST_CHANCE: f64 = 0.8;

/// The objects of a catalogue that take part, by index; without an arm all that fit.
pub(super) fn objects(
    catalogue: &Catalogue,
    grid: &Grid,
    station: Option<&ArmStation>,
) -> Vec<usize> {
    let objects = catalogue.objects.iter().enumerate();
    objects
        .filter(|(_, object)| chance(&object.model, grid, station) >= LEAST_CHANCE)
        .map(|(index, _)| index)
        .collect()
}

/// The chance that an object comes to rest in a pose in which it can be packed.
fn chance(model: &Model, grid: &Grid, station: Option<&ArmStation>) -> f64 {
    let resolution = grid.resolution();
    let poses = model.resting_poses.iter();
    let possible = poses.clone().filter(|pose| {
        let standing = Isometry3::from_parts(Translation3::identity(), pose.rotation);
        let Ok(posed) = posed_item(model, &standing, resolution) else {
            return false;
        };
        let item = Arc::new(posed.item);
        let is_held = station.is_none_or(|station| {
            let model = Arc::new(model.turned(&posed.heightmap_from_item));
            let candidate = Candidate::new(0, Arc::clone(&item)).with_model(model);
            station.check().lift(&candidate, resolution).is_ok()
        });
        is_held && possible_count_below_rim(grid, &item) > 0
    });
    let all: f64 = poses.map(|pose| pose.probability).sum();
    let possible: f64 = possible.map(|pose| pose.probability).sum();
    possible / all.max(f64::MIN_POSITIVE)
}
