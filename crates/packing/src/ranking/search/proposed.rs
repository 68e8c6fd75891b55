//! Views of which some placements are proposed: work in proportion to these, not to the container.

use pulp::{Simd, WithSimd};

use super::open::{Extent, NO_HEIGHT, Node};
use crate::kernel::grid::{Grid, Units};
use crate::kernel::item::{Item, ItemView};
use crate::kernel::lanes::{BlockOffsets, PaddedMap, TOGETHER, resting_heights_at};
use crate::kernel::placement::Placement;

/// The proposed placements of one view, in the order of the proposals, each once.
#[derive(Debug, Clone, Default)]
pub(super) struct ProposedView {
    pub(super) corners: Vec<(u16, u16)>,
    heights: Vec<Units>,
}

/// The proposed placements of a ranking; the memory is kept from one to the next.
#[derive(Debug)]
pub(super) struct Proposed {
    nx: usize,
    ny: usize,
    pub(super) views: Vec<ProposedView>,
    /// Per cell: the last view with a placement there, which tells repeated proposals.
    seen: Vec<u64>,
    stamp: u64,
}

impl Proposed {
    pub(super) fn new(grid: &Grid) -> Self {
        Self {
            nx: grid.nx(),
            ny: grid.ny(),
            views: Vec::new(),
            seen: vec![0; grid.nx() * grid.ny()],
            stamp: 0,
        }
    }

    /// Takes the placements of an item whose first view has this index, without those that leave
    /// the container and those that come again. Their resting heights are not known yet.
    pub(super) fn take(&mut self, first: usize, item: &Item, proposals: &[Placement]) {
        let end = first + item.views().len();
        if self.views.len() < end {
            self.views.resize_with(end, ProposedView::default);
        }
        let views = self.views.get_mut(first..end).unwrap_or(&mut []);
        for view in views.iter_mut() {
            view.corners.clear();
            view.heights.clear();
        }
        for Placement { yaw, x, y } in proposals {
            if let (Some(view), Ok(x), Ok(y)) =
                (views.get_mut(*yaw), u16::try_from(*x), u16::try_from(*y))
            {
                view.corners.push((x, y));
            }
        }
        let Self { nx, ny, seen, .. } = self;
        for (proposed, view) in views.iter_mut().zip(item.views()) {
            self.stamp += 1;
            proposed.corners.retain(|(x, y)| {
                let (x, y) = (usize::from(*x), usize::from(*y));
                if x + view.nx() > *nx || y + view.ny() > *ny {
                    return false;
                }
                seen.get_mut(x * *ny + y)
                    .is_some_and(|seen| std::mem::replace(seen, self.stamp) != self.stamp)
            });
        }
    }
}

impl ProposedView {
    /// Counts the placements that rest at `limit` or lower; gives the least resting height of any.
    pub(super) fn summarise(&self, limit: Units) -> (u64, Units) {
        let fitting = self.heights.iter().filter(|height| **height <= limit);
        let lowest = self.heights.iter().copied().min();
        (fitting.count() as u64, lowest.unwrap_or(NO_HEIGHT))
    }

    /// Collects the placements of a level; gives the next greater resting height.
    pub(super) fn collect(&self, level: Node, placements: &mut Vec<Node>) -> Units {
        let mut next = NO_HEIGHT;
        for (height, (x, y)) in self.heights.iter().zip(&self.corners) {
            if *height == level.height {
                placements.push(Node {
                    x: *x,
                    y: *y,
                    extent: Extent::PLACEMENT,
                    ..level
                });
            } else if *height > level.height {
                next = next.min(*height);
            }
        }
        next
    }
}

/// Computes the resting heights of a view's proposed placements.
pub(super) struct Lower<'a> {
    pub(super) container: &'a PaddedMap,
    pub(super) view: &'a ItemView,
    pub(super) proposed: &'a mut ProposedView,
    pub(super) offsets: &'a BlockOffsets,
}

impl WithSimd for Lower<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self {
            container,
            view,
            proposed: ProposedView { corners, heights },
            offsets,
        } = self;
        // A loop, as the closure of an iterator would not be compiled for the processor's features.
        heights.reserve(corners.len());
        for together in corners.chunks(TOGETHER) {
            // Short of placements, the last one is computed more than once.
            let mut bases = [0; TOGETHER];
            let last = together.last().copied().unwrap_or((0, 0));
            let filled = together.iter().copied().chain(std::iter::repeat(last));
            for (place, (x, y)) in bases.iter_mut().zip(filled) {
                *place = container.index(usize::from(x), usize::from(y));
            }
            let found = resting_heights_at(container, bases, view, offsets);
            heights.extend(found.iter().take(together.len()));
        }
    }
}
