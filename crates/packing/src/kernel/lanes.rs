//! The inner loops: resting heights and distance sums over padded maps.
//!
//! Maps are padded with [`WALL`], so that a block of lanes can be read from any cell: a placement
//! that leaves the container rests at wall height and never fits, with no branch in the loops. All
//! is `inline(always)`: the caller's dispatch on the processor's features covers the whole loop
//! nest.
#![allow(
    clippy::indexing_slicing,
    reason = "a block is read at most LANES cells past a row's last cell, which PaddedMap allocates; \
              lane loops run over fixed-size arrays"
)]

use crate::kernel::grid::{ABSENT, Units};
use crate::kernel::item::ItemView;
use crate::kernel::layout::{DISTANCE_LEVELS, ROW_LANES};

/// Placements computed at once along y.
pub(crate) const LANES: usize = 32;

/// The height of walls and of everything outside the container.
///
/// Twice [`MAX_UNITS`](crate::kernel::grid::MAX_UNITS) and more; adding a height to it stays in `i16`.
pub(crate) const WALL: Units = 16_384;

/// A map over the container's cells, row-major with rows padded by [`WALL`].
#[derive(Debug, Clone, Default)]
pub(crate) struct PaddedMap {
    nx: usize,
    ny: usize,
    stride: usize,
    cells: Vec<Units>,
}

impl PaddedMap {
    pub(crate) fn new(nx: usize, ny: usize) -> Self {
        let stride = ny.next_multiple_of(LANES) + LANES;
        // The last row's blocks may reach past its end by the padding of one more row.
        Self {
            nx,
            ny,
            stride,
            cells: vec![WALL; (nx + 1) * stride],
        }
    }

    #[inline(always)]
    pub(crate) fn index(&self, x: usize, y: usize) -> usize {
        x * self.stride + y
    }

    pub(crate) fn row(&self, x: usize) -> &[Units] {
        &self.cells[x * self.stride..x * self.stride + self.ny]
    }

    pub(crate) fn row_mut(&mut self, x: usize) -> &mut [Units] {
        &mut self.cells[x * self.stride..x * self.stride + self.ny]
    }

    pub(crate) fn size(&self) -> (usize, usize) {
        (self.nx, self.ny)
    }
}

/// Resting heights of the [`LANES`] placements whose footprints start at cell index `base` and
/// after it along y: `k = max(0, max over footprint cells of (container - item bottom))`.
#[inline(always)]
pub(crate) fn resting_heights(
    container: &PaddedMap,
    base: usize,
    view: &ItemView,
) -> [Units; LANES] {
    let mut heights = [0; LANES];
    for cell in &view.layout.cells {
        let start = base + usize::from(cell.x) * container.stride + usize::from(cell.y);
        let below: &[Units; LANES] = lanes(&container.cells, start);
        for lane in 0..LANES {
            heights[lane] = heights[lane].max(below[lane] - cell.bottom);
        }
    }
    heights
}

/// Offsets of a view's blocks in a container's map, from the footprint's first cell.
#[derive(Debug, Clone, Default)]
pub(crate) struct BlockOffsets {
    /// Increasing.
    offsets: Vec<u32>,
    /// Cells from the first to the end of the last block.
    span: usize,
}

impl BlockOffsets {
    pub(crate) fn bytes(&self) -> usize {
        self.offsets.capacity() * size_of::<u32>()
    }

    pub(crate) fn update(&mut self, container: &PaddedMap, view: &ItemView) {
        let stride = container.stride as u32;
        let blocks = view.layout.blocks.iter();
        self.offsets.clear();
        self.offsets
            .extend(blocks.map(|block| u32::from(block.x) * stride + u32::from(block.y)));
        self.span = self.offsets.last().map_or(0, |last| *last as usize) + ROW_LANES;
    }
}

/// Single placements computed at once.
pub(crate) const TOGETHER: usize = 4;

/// Resting heights of the placements of a view that start at the cells `bases`, with its `blocks`.
#[inline(always)]
pub(crate) fn resting_heights_at(
    container: &PaddedMap,
    bases: [usize; TOGETHER],
    view: &ItemView,
    blocks: &BlockOffsets,
) -> [Units; TOGETHER] {
    // Windows of one length, so that one check per block covers all; and one array each, as an
    // array of arrays would go through memory at every block.
    let [first, second, third, fourth] =
        bases.map(|base| &container.cells[base..base + blocks.span]);
    let mut heights = [0; ROW_LANES];
    let mut heights_of_second = [0; ROW_LANES];
    let mut heights_of_third = [0; ROW_LANES];
    let mut heights_of_fourth = [0; ROW_LANES];
    for (offset, bottom) in blocks.offsets.iter().zip(&view.layout.bottoms) {
        let offset = *offset as usize;
        raise(&mut heights, lanes(first, offset), bottom);
        raise(&mut heights_of_second, lanes(second, offset), bottom);
        raise(&mut heights_of_third, lanes(third, offset), bottom);
        raise(&mut heights_of_fourth, lanes(fourth, offset), bottom);
    }
    let highest = |heights: [Units; ROW_LANES]| heights.into_iter().fold(0, Units::max);
    [
        highest(heights),
        highest(heights_of_second),
        highest(heights_of_third),
        highest(heights_of_fourth),
    ]
}

/// Raises a block's resting heights to where its lower surface meets what is below.
#[inline(always)]
fn raise(
    heights: &mut [Units; ROW_LANES],
    below: &[Units; ROW_LANES],
    bottom: &[Units; ROW_LANES],
) {
    for lane in 0..ROW_LANES {
        heights[lane] = heights[lane].max(below[lane] - bottom[lane]);
    }
}

/// `d V` of SDFM: the sum of `D` over the item's voxels, at cell `base` resting at `height`.
///
/// A voxel at height `z` has `D = 1 + #{d : z >= H_d}`, so a column from `z0` to `z1` adds its
/// length and, for each level, `clamp(z1 - H_d, 0, z1 - z0)`.
#[inline(always)]
pub(crate) fn distance_sum(
    levels: &[PaddedMap; DISTANCE_LEVELS],
    base: usize,
    view: &ItemView,
    height: Units,
) -> u64 {
    let layout = &view.layout;
    let stride = levels[0].stride;
    let mut total = view.voxel_count();
    let mut sums = [0; ROW_LANES];
    let mut pending = 0;
    for (block, columns) in layout.blocks.iter().zip(&layout.columns) {
        if pending >= layout.blocks_per_flush {
            total += flush(&mut sums);
            pending = 0;
        }
        pending += 1;
        let start = base + usize::from(block.x) * stride + usize::from(block.y);
        for level in levels {
            let thresholds: &[Units; ROW_LANES] = lanes(&level.cells, start);
            for lane in 0..ROW_LANES {
                let above = height + columns.top[lane] - thresholds[lane];
                sums[lane] += above.max(0).min(columns.thickness[lane]);
            }
        }
    }
    total + flush(&mut sums)
}

#[inline(always)]
fn flush(sums: &mut [Units; ROW_LANES]) -> u64 {
    let total = sums.iter().map(|sum| u64::from(*sum as u16)).sum();
    *sums = [0; ROW_LANES];
    total
}

#[inline(always)]
fn lanes<const N: usize>(cells: &[Units], start: usize) -> &[Units; N] {
    match cells[start..start + N].first_chunk() {
        Some(chunk) => chunk,
        None => &[WALL; N],
    }
}

/// `s` of HM: the sum over the footprint's bounding rectangle of the heightmap after placing, in
/// units.
#[inline(always)]
pub(crate) fn columns_after(
    container: &PaddedMap,
    base: usize,
    view: &ItemView,
    height: Units,
) -> i64 {
    let mut total = 0;
    for x in 0..view.nx() {
        let start = base + x * container.stride;
        let below = &container.cells[start..start + view.ny()];
        let row = x * view.ny();
        let tops = &view.top()[row..row + view.ny()];
        let bottoms = &view.bottom()[row..row + view.ny()];
        let row_sum: i32 = below
            .iter()
            .zip(tops)
            .zip(bottoms)
            .map(|((below, top), bottom)| {
                i32::from(if *bottom == ABSENT {
                    *below
                } else {
                    height + top
                })
            })
            .sum();
        total += i64::from(row_sum);
    }
    total
}

/// `a` of MTA: faces of an item's voxels that touch content, walls or floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Contact {
    pub(crate) floor_faces: u64,
    pub(crate) side_faces: u64,
}

/// Faces of the item's voxels that touch content, walls or floor.
///
/// Beside a column only content reaches above the item's own lower surface there, so no face
/// between two of the item's own voxels is counted.
pub(crate) fn contact(
    container: &PaddedMap,
    placement: (usize, usize),
    view: &ItemView,
    height: Units,
) -> Contact {
    let mut contact = Contact::default();
    let (nx, ny) = container.size();
    let beside = |x: usize, y: usize, dx: isize, dy: isize| {
        let (x, y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
        if x < nx && y < ny {
            container.cells[x * container.stride + y]
        } else {
            WALL
        }
    };
    for (index, (top, bottom)) in view.top().iter().zip(view.bottom()).enumerate() {
        if *bottom == ABSENT {
            continue;
        }
        let (x, y) = (
            placement.0 + index / view.ny(),
            placement.1 + index % view.ny(),
        );
        let (lowest, highest) = (height + bottom, height + top);
        contact.floor_faces += u64::from(beside(x, y, 0, 0) == lowest);
        for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
            let covered = beside(x, y, dx, dy).min(highest) - lowest;
            contact.side_faces += covered.max(0) as u64;
        }
    }
    contact
}
