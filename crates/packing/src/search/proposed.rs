//! The views of which only some placements are proposed: work in proportion to the proposals, not to the container.

use pulp::{Arch, Simd, WithSimd};

use super::{Level, NO_HEIGHT, Pending, Summary};
use crate::grid::{Grid, Units};
use crate::item::{Item, ItemView};
use crate::kernel::{BlockOffsets, PaddedMap, TOGETHER, resting_heights_at};
use crate::placement::Placement;

/// The proposed placements of one view, in the order of the proposals, each once.
#[derive(Debug, Clone, Default)]
pub(super) struct ProposedView {
    corners: Vec<Corner>,
    heights: Vec<Units>,
}

#[derive(Debug, Clone, Copy)]
struct Corner {
    x: u16,
    y: u16,
}

/// The proposed placements of all views of a ranking; the memory is kept from one to the next.
#[derive(Debug)]
pub(super) struct ProposedViews {
    arch: Arch,
    views: Vec<ProposedView>,
    used: usize,
    /// Per cell of the container: the last view that had a placement there, which tells repeated proposals.
    seen: Vec<u32>,
    stamp: u32,
    blocks: BlockOffsets,
}

impl ProposedViews {
    pub(super) fn new(grid: &Grid) -> Self {
        Self {
            arch: Arch::new(),
            views: Vec::new(),
            used: 0,
            seen: vec![0; grid.nx() * grid.ny()],
            stamp: 0,
            blocks: BlockOffsets::default(),
        }
    }

    pub(super) fn clear(&mut self) {
        self.used = 0;
    }

    pub(super) fn get(&self, index: usize) -> Option<&ProposedView> {
        self.views.get(index)
    }

    /// Adds the views of an item with the resting heights of its proposals; returns the index of the first.
    pub(super) fn add(
        &mut self,
        container: &PaddedMap,
        item: &Item,
        proposals: &[Placement],
    ) -> usize {
        let first = self.used;
        self.used += item.views().len();
        if self.views.len() < self.used {
            self.views.resize_with(self.used, ProposedView::default);
        }
        let views = self.views.get_mut(first..self.used).unwrap_or(&mut []);
        for view in views.iter_mut() {
            view.corners.clear();
            view.heights.clear();
        }
        for Placement { yaw, x, y } in proposals {
            if let (Some(view), Ok(x), Ok(y)) =
                (views.get_mut(*yaw), u16::try_from(*x), u16::try_from(*y))
            {
                view.corners.push(Corner { x, y });
            }
        }
        for (proposed, view) in views.iter_mut().zip(item.views()) {
            if self.stamp == u32::MAX {
                self.seen.fill(0);
                self.stamp = 0;
            }
            self.stamp += 1;
            self.arch.dispatch(Lower {
                container,
                view,
                proposed,
                seen: &mut self.seen,
                stamp: self.stamp,
                blocks: &mut self.blocks,
            });
        }
        first
    }
}

/// Drops what leaves the container or comes twice, and computes the resting heights of the rest.
struct Lower<'a> {
    container: &'a PaddedMap,
    view: &'a ItemView,
    proposed: &'a mut ProposedView,
    seen: &'a mut [u32],
    stamp: u32,
    blocks: &'a mut BlockOffsets,
}

impl WithSimd for Lower<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self {
            container,
            view,
            proposed: ProposedView { corners, heights },
            seen,
            stamp,
            blocks,
        } = self;
        let (nx, ny) = container.size();
        corners.retain(|corner| {
            let (x, y) = (usize::from(corner.x), usize::from(corner.y));
            if x + view.nx() > nx || y + view.ny() > ny {
                return false;
            }
            seen.get_mut(x * ny + y)
                .is_some_and(|seen| std::mem::replace(seen, stamp) != stamp)
        });
        if corners.is_empty() {
            return;
        }
        blocks.update(container, view);
        // A loop, as the closure of an iterator would not be compiled for the processor's features.
        heights.reserve(corners.len());
        for together in corners.chunks(TOGETHER) {
            // Short of placements, the last one is computed more than once.
            let mut bases = [0; TOGETHER];
            let last = together.last().copied().unwrap_or(Corner { x: 0, y: 0 });
            let filled = together.iter().copied().chain(std::iter::repeat(last));
            for (base, corner) in bases.iter_mut().zip(filled) {
                *base = usize::from(corner.x) * container.stride() + usize::from(corner.y);
            }
            let found = resting_heights_at(container, bases, view, blocks);
            heights.extend(found.iter().take(together.len()));
        }
    }
}

impl ProposedView {
    /// Counts what is proposed.
    pub(super) fn summary(&self, limit: Units) -> Summary {
        let fitting = self.heights.iter().filter(|height| **height <= limit);
        let fitting = fitting.count() as u64;
        let lowest = self.heights.iter().copied().min();
        Summary {
            proposed: self.heights.len() as u64,
            fitting,
            lowest: lowest.filter(|_| fitting > 0),
        }
    }

    /// Collects the placements of a level; gives the next greater resting height that fits.
    pub(super) fn collect(
        &self,
        level: Level,
        limit: Units,
        pending: &mut Vec<Pending>,
    ) -> Option<Units> {
        let mut next = NO_HEIGHT;
        for (height, corner) in self.heights.iter().zip(&self.corners) {
            if *height == level.height {
                pending.push(Pending {
                    view: level.view,
                    x: usize::from(corner.x),
                    y: usize::from(corner.y),
                    height: *height,
                    value: 0.0,
                });
            } else if *height > level.height {
                next = next.min(*height);
            }
        }
        (next <= limit).then_some(next)
    }
}
