//! An episode in the simulated cell.

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::episode::{Episode, Observer, Play, play};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::plan::Planner;
use ppnpack_physics::packing_cell::SimulatedPackingCell;

use crate::failure::{OrInput, OrRun, Outcome};
use crate::options::Simulated;
use crate::sequence::Sequence;

/// An empty simulated cell for the objects of a catalogue.
///
/// # Errors
/// Which setting is impossible.
pub fn empty_cell(
    catalogue: &Catalogue,
    grid: &Grid,
    simulated: &Simulated,
) -> Outcome<SimulatedPackingCell> {
    let settings = simulated.cell.clone();
    let cell = SimulatedPackingCell::new(settings, grid, catalogue, simulated.scan).or_input()?;
    match &simulated.camera {
        Some(camera) => cell.with_cameras(camera).or_input(),
        None => Ok(cell),
    }
}

/// Packs a sequence; gives the episode and the cell as it was left.
///
/// # Errors
/// What ended the episode.
pub fn simulate(
    catalogue: &Catalogue,
    grid: &Grid,
    sequence: &Sequence,
    mut cell: SimulatedPackingCell,
    planner: &mut Planner,
    how: Play,
    observer: &mut dyn Observer,
) -> Outcome<(Episode, SimulatedPackingCell)> {
    let items = sequence.candidates(catalogue);
    let episode = play(grid, planner, &mut cell, items, how, observer).or_run()?;
    Ok((episode, cell))
}
