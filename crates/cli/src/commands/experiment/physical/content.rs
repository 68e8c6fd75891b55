//! What the container holds at the end of a run.

use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::grid::Grid;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::settings::CellSettings;
use ppnpack_wire::convert::pose;
use ppnpack_wire::v1;

use super::run::Done;
use crate::failure::{OrRun, Outcome};

/// A body in the container.
pub(super) struct Content {
    pub(super) model: Arc<Model>,
    pub(super) container_from_object: Isometry3<f64>,
    pub(super) is_inside: bool,
}

/// What a cell holds.
pub(super) fn of(state: &v1::CellState, catalogue: &Catalogue) -> Vec<Content> {
    let content = |body: &v1::Body| {
        let (_, object) = catalogue.find(&body.object)?;
        let pose = pose::read_required("pose", body.container_from_item.as_ref()).ok()?;
        Some(Content {
            model: Arc::clone(&object.model),
            container_from_object: pose,
            is_inside: body.is_inside,
        })
    };
    state.bodies.iter().filter_map(content).collect()
}

/// Measures it: by the bodies themselves, not by what the camera sees of them.
pub(super) fn measure(
    done: &mut Done,
    catalogue: &Catalogue,
    simulated: &CellSettings,
    grid: &Grid,
) -> Outcome {
    let contents = of(&done.state, catalogue);
    let mut cell = SimulatedCell::new(simulated.clone()).or_run()?;
    let bodies: Vec<_> = contents
        .iter()
        .map(|body| (Arc::clone(&body.model), body.container_from_object))
        .collect();
    cell.lay_down(&bodies).or_run()?;
    let surface = cell.scan_surface(grid).or_run()?;
    let highest_m = surface.heights_m().iter().copied().fold(0.0, f32::max);
    let container = grid.container();
    let below_m3 = container.x_m * container.y_m * f64::from(highest_m);
    let inside = contents.iter().filter(|body| body.is_inside);
    let record = &mut done.record;
    record.volume_m3 = inside.map(|body| body.model.volume_m3).sum();
    record.compactness = if below_m3 > 0.0 {
        record.volume_m3 / below_m3
    } else {
        0.0
    };
    record.deepest_overlap_m = cell.deepest_overlap_m();
    Ok(())
}
