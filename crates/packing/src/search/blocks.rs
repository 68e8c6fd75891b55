//! Branch and bound over blocks of placements: finds what an exhaustive search finds without looking everywhere.
//!
//! A block is a square of `2^e` placements a side, named by its first corner. Under its placements the container is at
//! least as high as the least cell of the window of `2^e` cells that starts at each cell under the first corner's. So
//! the resting height of the first corner on the container's windowed minimum is a bound for the whole block; likewise
//! its distances to content on the windowed maximum of the distance levels. Both come from the loops that evaluate
//! single placements. The blocks with the least bound are cut in four, down to single placements.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use pulp::{Arch, Simd, WithSimd};

use super::{Pending, ViewState};
use crate::distance::DistanceLevels;
use crate::grid::{Grid, Units};
use crate::item::ItemView;
use crate::kernel::{
    BlockOffsets, DISTANCE_LEVELS, PaddedMap, TOGETHER, distance_sum, resting_heights_at,
};
use crate::objective::{Heuristic, Objective};
use crate::step::{Candidate, PlacementCounts};
use crate::windows::widen;

/// The largest blocks are this share of the container's longer side: larger ones are always cut, of smaller ones there
/// are many.
const LARGEST_SHARE: usize = 8;

/// The blocks of a ranking that are not cut yet; the memory is kept from one to the next.
#[derive(Debug)]
pub(super) struct BlockSearch {
    arch: Arch,
    /// The container's least heights in windows of `2^(entry + 1)` cells a side.
    lowest: Vec<PaddedMap>,
    /// The distance levels' greatest heights in the same windows; none where the objective knows no distance.
    distance: Vec<[PaddedMap; DISTANCE_LEVELS]>,
    row: Vec<Units>,
    /// The largest blocks have `2^exponents` placements a side.
    exponents: usize,
    /// By index of the search's view.
    offsets: Vec<BlockOffsets>,
    open: BinaryHeap<Block>,
}

/// A block of placements of a view, none of which has a value below its bound.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Block {
    bound: f64,
    /// None of its placements has a lesser sum of distances.
    distance_sum: u64,
    view: u32,
    x: u16,
    y: u16,
    /// None rests lower.
    height: Units,
    /// `e`.
    exponent: u8,
    /// Whether the sum is of this block, not of one it was cut from.
    is_measured: bool,
}

// The heap gives the least bound first, and of equal ones the smallest block.
impl Eq for Block {}
impl Ord for Block {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |block: &Self| (block.exponent, block.view, block.x, block.y);
        other
            .bound
            .total_cmp(&self.bound)
            .then_with(|| key(other).cmp(&key(self)))
    }
}
impl PartialOrd for Block {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// What a ranking is over.
#[derive(Clone, Copy)]
pub(super) struct Ranking<'a> {
    pub(super) objective: &'a Objective,
    pub(super) container: &'a PaddedMap,
    pub(super) views: &'a [ViewState],
    pub(super) candidates: &'a [Candidate],
}

impl<'a> Ranking<'a> {
    fn view(&self, index: usize) -> Option<(&'a ViewState, &'a ItemView)> {
        let state = self.views.get(index)?;
        let held = self.candidates.get(state.candidate)?;
        Some((state, held.item.views().get(state.yaw)?))
    }
}

impl BlockSearch {
    /// For objectives whose bounds tell placements apart; others must look everywhere.
    pub(super) fn new(grid: &Grid, heuristic: Heuristic) -> Option<Self> {
        let map = || PaddedMap::new(grid.nx(), grid.ny());
        let largest = grid.nx().max(grid.ny()) / LARGEST_SHARE;
        let exponents = largest.checked_ilog2().unwrap_or(0) as usize;
        let of_distance = match heuristic {
            Heuristic::Sdfm => exponents,
            Heuristic::Dbl | Heuristic::Hm => 0,
            Heuristic::Mta | Heuristic::FirstFit | Heuristic::Random => return None,
        };
        Some(Self {
            arch: Arch::new(),
            lowest: (0..exponents).map(|_| map()).collect(),
            distance: (0..of_distance)
                .map(|_| std::array::from_fn(|_| map()))
                .collect(),
            row: vec![0; grid.ny()],
            exponents,
            offsets: Vec::new(),
            open: BinaryHeap::new(),
        })
    }

    /// Makes the windows of a container current.
    pub(super) fn update(&mut self, container: &PaddedMap, distance: Option<&DistanceLevels>) {
        self.arch.dispatch(UpdateWindows {
            lowest: &mut self.lowest,
            greatest: &mut self.distance,
            container,
            distance,
            row: &mut self.row,
        });
    }

    pub(super) fn clear(&mut self) {
        self.open.clear();
    }

    /// The least bound of any placement that is left.
    pub(super) fn bound(&self) -> Option<f64> {
        self.open.peek().map(|block| block.bound)
    }

    /// Enters all placements of a view of the ranking; returns how many are known to fit already, which are those of
    /// blocks that cannot be cut.
    pub(super) fn enter(&mut self, ranking: Ranking<'_>, index: usize) -> u64 {
        let Some((_, view)) = ranking.view(index) else {
            return 0;
        };
        if self.offsets.len() <= index {
            self.offsets.resize_with(index + 1, BlockOffsets::default);
        }
        if let Some(offsets) = self.offsets.get_mut(index) {
            offsets.update(ranking.container, view);
        }
        self.arch.dispatch(Enter {
            blocks: self,
            ranking,
            index,
        })
    }

    /// Cuts blocks until a single placement comes up, or the rest has bounds above `until`. Counts what fits.
    pub(super) fn expand(
        &mut self,
        ranking: Ranking<'_>,
        until: f64,
        counts: &mut [PlacementCounts],
        pending: &mut Vec<Pending>,
    ) {
        self.arch.dispatch(Expand {
            blocks: self,
            ranking,
            until,
            counts,
            pending,
        });
    }

    /// Adds blocks of one size and view, those of them that hold a placement below the rim; returns how many.
    #[inline(always)]
    fn add(&mut self, ranking: Ranking<'_>, of: Block, corners: [(usize, usize); TOGETHER]) -> u64 {
        let view_index = of.view as usize;
        let Some((state, view)) = ranking.view(view_index) else {
            return 0;
        };
        let container = ranking.container;
        let map = match of.exponent.checked_sub(1) {
            None => Some(container),
            Some(wider) => self.lowest.get(usize::from(wider)),
        };
        let (Some(map), Some(offsets)) = (map, self.offsets.get(view_index)) else {
            return 0;
        };
        let (nx, ny) = container.size();
        let (placed_x, placed_y) = ((nx + 1) - view.nx(), (ny + 1) - view.ny());
        let bases = corners.map(|(x, y)| {
            // One that is beyond the last placement is computed for nothing at the block's own corner.
            if x < placed_x && y < placed_y {
                x * map.stride() + y
            } else {
                usize::from(of.x) * map.stride() + usize::from(of.y)
            }
        });
        let heights = resting_heights_at(map, bases, view, offsets);
        let mut added = 0;
        for ((x, y), height) in corners.into_iter().zip(heights) {
            if x >= placed_x || y >= placed_y || height > state.limit {
                continue;
            }
            added += 1;
            let (x, y) = (x as u16, y as u16);
            let block = Block {
                x,
                y,
                height,
                is_measured: false,
                ..of
            };
            self.open
                .push(block.bounded(ranking.objective, state, view));
        }
        added
    }
}

impl Block {
    /// The block with the bound that follows from what is known of it.
    #[inline(always)]
    fn bounded(self, objective: &Objective, state: &ViewState, view: &ItemView) -> Self {
        let at = (usize::from(self.x), usize::from(self.y));
        let bound = objective.block_bound(view, &state.terms, at, self.height, self.distance_sum);
        Self { bound, ..self }
    }
}

/// Recomputes the windows.
struct UpdateWindows<'a> {
    lowest: &'a mut [PaddedMap],
    greatest: &'a mut [[PaddedMap; DISTANCE_LEVELS]],
    container: &'a PaddedMap,
    distance: Option<&'a DistanceLevels>,
    row: &'a mut [Units],
}

impl WithSimd for UpdateWindows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self {
            lowest,
            greatest,
            container,
            distance,
            row,
        } = self;
        let mut finer = container;
        for (exponent, wider) in lowest.iter_mut().enumerate() {
            widen(finer, 1 << exponent, Units::min, wider, row);
            finer = wider;
        }
        let Some(distance) = distance else { return };
        let mut finer = distance.levels();
        for (exponent, wider) in greatest.iter_mut().enumerate() {
            for (finer, wider) in finer.iter().zip(wider.iter_mut()) {
                widen(finer, 1 << exponent, Units::max, wider, row);
            }
            finer = wider;
        }
    }
}

/// Enters a view's largest blocks.
struct Enter<'a> {
    blocks: &'a mut BlockSearch,
    ranking: Ranking<'a>,
    index: usize,
}

impl WithSimd for Enter<'_> {
    type Output = u64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> u64 {
        let Self {
            blocks,
            ranking,
            index,
        } = self;
        let Some((_, view)) = ranking.view(index) else {
            return 0;
        };
        let (nx, ny) = ranking.container.size();
        if view.nx() > nx || view.ny() > ny {
            return 0;
        }
        let mut added = 0;
        let side = 1 << blocks.exponents;
        for x in (0..=nx - view.nx()).step_by(side) {
            for y in (0..=ny - view.ny()).step_by(side * TOGETHER) {
                let of = Block {
                    bound: 0.0,
                    // A voxel is a step away from content at least.
                    distance_sum: view.voxel_count(),
                    view: index as u32,
                    x: x as u16,
                    y: y as u16,
                    height: 0,
                    exponent: blocks.exponents as u8,
                    is_measured: false,
                };
                let corners = std::array::from_fn(|corner| (x, y + corner * side));
                added += blocks.add(ranking, of, corners);
            }
        }
        if blocks.exponents == 0 { added } else { 0 }
    }
}

/// Cuts blocks.
struct Expand<'a> {
    blocks: &'a mut BlockSearch,
    ranking: Ranking<'a>,
    until: f64,
    counts: &'a mut [PlacementCounts],
    pending: &'a mut Vec<Pending>,
}

impl WithSimd for Expand<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self {
            blocks,
            ranking,
            until,
            counts,
            pending,
        } = self;
        while let Some(block) = blocks.open.peek().copied() {
            if block.bound > until {
                return;
            }
            let view_index = block.view as usize;
            let Some((state, view)) = ranking.view(view_index) else {
                blocks.open.pop();
                continue;
            };
            let (x, y) = (usize::from(block.x), usize::from(block.y));
            let Some(finer) = block.exponent.checked_sub(1) else {
                blocks.open.pop();
                pending.push(Pending {
                    view: view_index,
                    x,
                    y,
                    height: block.height,
                    value: 0.0,
                });
                return;
            };
            if !block.is_measured
                && let Some(levels) = blocks.distance.get(usize::from(finer))
            {
                let base = x * ranking.container.stride() + y;
                let measured = Block {
                    distance_sum: distance_sum(levels, base, view, block.height),
                    is_measured: true,
                    ..block
                };
                let measured = measured.bounded(ranking.objective, state, view);
                // The heap moves it back to where its new bound belongs.
                if let Some(mut first) = blocks.open.peek_mut() {
                    *first = measured;
                }
                continue;
            }
            blocks.open.pop();
            let side = 1 << finer;
            let of = Block {
                exponent: finer,
                ..block
            };
            let corners = [(x, y), (x, y + side), (x + side, y), (x + side, y + side)];
            let added = blocks.add(ranking, of, corners);
            if finer == 0
                && let Some(counts) = counts.get_mut(state.candidate)
            {
                counts.fitting += added;
            }
        }
    }
}
