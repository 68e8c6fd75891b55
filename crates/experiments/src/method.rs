//! The method that experiments vary.

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::options::Simulated;
use ppnpack_cli::simulation::empty_cell;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::method::{Method, ProposalSource, Stability};
use ppnpack_physics::packing_cell::SimulatedPackingCell;

/// SDF minimisation over all items of the buffer together.
pub(crate) fn sdfm(
    proposals: ProposalSource,
    stability: Stability,
    buffer: usize,
    seed: u64,
) -> Method {
    Method {
        proposals,
        stability,
        buffer,
        seed,
        ..Method::published()
    }
}

/// The empty cell that a method without simulated tries packs in: the fine surface is scanned where its stability test reads it.
pub(crate) fn cell_for(
    method: &Method,
    catalogue: &Catalogue,
    grid: &Grid,
    simulated: &Simulated,
) -> Outcome<SimulatedPackingCell> {
    let cell = empty_cell(catalogue, grid, simulated)?;
    Ok(match method.stability.reads_surface() {
        true => cell,
        false => cell.without_surface(),
    })
}
