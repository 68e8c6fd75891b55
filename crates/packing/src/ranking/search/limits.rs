//! Limits of a ranking: time and memory.

use super::open::Node;
use crate::kernel::grid::{Grid, Units};
use crate::kernel::item::ItemView;
use crate::kernel::layout::DISTANCE_LEVELS;
use crate::kernel::objective::Heuristic;

/// Note on a ranking whose time is over.
pub(super) const CUT: &str = "the time limit left placements unranked";

/// A search needs more memory than it may take.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the search needs more than the {limit_bytes} bytes that it may take: with fewer candidates, fewer yaws or larger cells it \
     needs less"
)]
pub struct TooMuchMemory {
    /// Limit, in bytes.
    pub limit_bytes: usize,
}

pub(super) fn nodes_bytes(count: usize) -> usize {
    count.saturating_mul(size_of::<Node>())
}

fn map_bytes(grid: &Grid) -> usize {
    let cells = grid.nx() * grid.ny();
    cells * size_of::<Units>()
}

/// Bytes of the maps of the container that a search keeps, whatever is ranked.
pub(super) fn container_bytes(grid: &Grid, heuristic: Heuristic, windows: usize) -> usize {
    let levels = match heuristic {
        Heuristic::Sdfm => DISTANCE_LEVELS,
        _ => 0,
    };
    // The container's own and one that is dilated; and per cell, which view had a placement there.
    let own = (2 + levels) * map_bytes(grid) + grid.nx() * grid.ny() * size_of::<u64>();
    own + windows * (1 + levels) * map_bytes(grid)
}

/// Bytes that a view takes at first; `is_whole` where every resting height is computed.
pub(super) fn view_bytes(grid: &Grid, view: &ItemView, is_whole: bool) -> usize {
    if is_whole {
        map_bytes(grid)
    } else {
        view.layout.blocks.len() * size_of::<u32>()
    }
}
