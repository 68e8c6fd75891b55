//! Coarse to fine: proposals made on a coarser grid, for the heuristic to decide among on the fine
//! one.
//!
//! [`CoarseGrid`] says how two grids relate, and [`CoarseToFine`] lets a network of the coarse grid
//! propose for the fine one.

mod grid;
mod pooling;
mod proposer;

pub use grid::{CoarseGrid, CoarseGridError, Coarsening};
pub use proposer::CoarseToFine;
