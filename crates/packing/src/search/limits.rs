//! Limits of a ranking: time and memory.

use std::time::Instant;

use super::open::Node;
use crate::grid::{Grid, Units};
use crate::item::ItemView;
use crate::layout::DISTANCE_LEVELS;
use crate::objective::Heuristic;

/// Cells of footprints between two looks at the clock: some tens of microseconds.
const CELLS_BETWEEN_LOOKS: usize = 1 << 16;

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

/// Says when the time of a step is over, without looking at the clock for each little work.
#[derive(Debug, Clone)]
pub(crate) struct Clock {
    deadline: Option<Instant>,
    cells: usize,
    is_over: bool,
}

impl Clock {
    pub(crate) fn new(deadline: Option<Instant>) -> Self {
        Self {
            deadline,
            cells: CELLS_BETWEEN_LOOKS,
            is_over: false,
        }
    }

    /// Whether the time is over before work on so many cells begins. The first call looks.
    #[inline(always)]
    pub(crate) fn is_over_before(&mut self, cells: usize) -> bool {
        self.cells += cells;
        if self.cells >= CELLS_BETWEEN_LOOKS {
            self.look();
        }
        self.is_over
    }

    #[cold]
    fn look(&mut self) {
        self.cells = 0;
        self.is_over |= self
            .deadline
            .is_some_and(|deadline| Instant::now() >= deadline);
    }
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
