//! An item's view laid out for the inner loops.
#![allow(
    clippy::indexing_slicing,
    reason = "a cell's lane is below ROW_LANES, as its block reaches it"
)]

use crate::kernel::grid::{ABSENT, Units};

/// Footprint cells summed at once along y.
pub(crate) const ROW_LANES: usize = 16;

/// Distances are truncated one step beyond this many levels.
pub(crate) const DISTANCE_LEVELS: usize = 4;

/// Stands for a missing lower surface in padded rows: a height on which nothing can rest.
const NOTHING_BELOW: Units = 32_000;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cell {
    pub(crate) x: u16,
    pub(crate) y: u16,
    pub(crate) bottom: Units,
}

/// The first of up to [`ROW_LANES`] footprint cells along y; it has material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Block {
    pub(crate) x: u16,
    pub(crate) y: u16,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BlockColumns {
    /// Upper surface (0 where absent).
    pub(crate) top: [Units; ROW_LANES],
    /// Upper minus lower surface (0 where absent).
    pub(crate) thickness: [Units; ROW_LANES],
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ViewLayout {
    /// For many placements at once: the cells with material.
    pub(crate) cells: Vec<Cell>,
    /// For single placements: the same cells, gathered along y.
    pub(crate) blocks: Vec<Block>,
    /// Per block the lower surface ([`NOTHING_BELOW`] where absent), which resting heights need.
    pub(crate) bottoms: Vec<[Units; ROW_LANES]>,
    pub(crate) columns: Vec<BlockColumns>,
    /// Blocks whose clamped sums are sure to fit an `i16` lane together.
    pub(crate) blocks_per_flush: usize,
}

impl ViewLayout {
    pub(crate) fn new(ny: usize, top: &[Units], bottom: &[Units]) -> Self {
        let mut layout = Self {
            cells: Vec::new(),
            blocks: Vec::new(),
            bottoms: Vec::new(),
            columns: Vec::new(),
            blocks_per_flush: 1,
        };
        let mut thickest = 1;
        for (index, (top, bottom)) in top.iter().zip(bottom).enumerate() {
            if *bottom == ABSENT {
                continue;
            }
            let (x, y) = ((index / ny) as u16, (index % ny) as u16);
            let (top, bottom, thickness) = (*top, *bottom, top - bottom);
            layout.cells.push(Cell { x, y, bottom });
            let reaches = |block: &Block| block.x == x && y < block.y + ROW_LANES as u16;
            if !layout.blocks.last().is_some_and(reaches) {
                layout.blocks.push(Block { x, y });
                layout.bottoms.push([NOTHING_BELOW; ROW_LANES]);
                layout.columns.push(BlockColumns {
                    top: [0; ROW_LANES],
                    thickness: [0; ROW_LANES],
                });
            }
            if let (Some(block), Some(bottoms), Some(columns)) = (
                layout.blocks.last(),
                layout.bottoms.last_mut(),
                layout.columns.last_mut(),
            ) {
                let lane = usize::from(y - block.y);
                bottoms[lane] = bottom;
                columns.top[lane] = top;
                columns.thickness[lane] = thickness;
            }
            thickest = thickest.max(thickness);
        }
        let per_block = DISTANCE_LEVELS * thickest as usize;
        layout.blocks_per_flush = (Units::MAX as usize / per_block).max(1);
        layout
    }
}
