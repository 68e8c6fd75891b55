//! Coarse to fine: proposals made on a coarser grid, among which the heuristic decides on the fine.
//!
//! [`CoarseGrid`] relates two grids; by [`CoarseToFine`] a coarse network proposes for the fine
//! one.

mod grid;
mod pooling;
mod proposer;

pub use grid::{CoarseGrid, CoarseGridError, Coarsening};
pub use proposer::CoarseToFine;
