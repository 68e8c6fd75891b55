//! Coarse to fine: proposals made on a coarser grid, for the heuristic to decide among on the fine one.
//!
//! [`CoarseGrid`] says how two grids relate, and [`CoarseToFine`] lets a proposer of the coarse grid propose for the
//! fine one: a network, or the heuristic itself ([`ProposeBest`](crate::search::ProposeBest)).

mod grid;
mod items;
mod pooling;
mod proposer;

pub use grid::{CoarseGrid, CoarseGridError, Coarsening};
pub(crate) use items::CoarseItems;
pub use proposer::CoarseToFine;
