//! What the container holds at the end of a run.

use std::sync::Arc;

use ppnpack_physics::cell::SimulatedCell;

use super::World;
use super::run::Done;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::stack::report::contents;

/// Measures it: by the bodies themselves, not by what the camera sees of them.
pub(super) fn measure(done: &mut Done, world: &World<'_>) -> Outcome {
    let contents = contents(&done.state, world.catalogue).or_run()?;
    let mut cell = SimulatedCell::new(world.settings.simulated.clone()).or_run()?;
    let bodies: Vec<_> = contents
        .iter()
        .map(|(_, body)| (Arc::clone(&body.model), body.container_from_item))
        .collect();
    cell.lay_down(&bodies).or_run()?;
    let surface = cell.scan_surface(world.grid).or_run()?;
    let highest_m = surface.heights_m().iter().copied().fold(0.0, f32::max);
    let container = world.grid.container();
    let below_m3 = container.x_m * container.y_m * f64::from(highest_m);
    let inside = contents.iter().filter(|(_, body)| body.inside);
    let record = &mut done.record;
    record.volume_m3 = inside.map(|(_, body)| body.model.volume_m3).sum();
    record.compactness = if below_m3 > 0.0 {
        record.volume_m3 / below_m3
    } else {
        0.0
    };
    record.deepest_overlap_m = cell.deepest_overlap_m();
    Ok(())
}
