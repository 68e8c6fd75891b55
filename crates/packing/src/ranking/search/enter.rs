//! Entry of placements into the open list.

use pulp::{Simd, WithSimd};

use super::open::{Extent, Node};
use super::passes::Placements;
use super::prepared::{Ranking, ViewState};
use crate::kernel::item::ItemView;
use crate::kernel::lanes::{TOGETHER, resting_heights_at};

/// Enters a view of the ranking; gives the numbers of its proposals and of those known to fit.
pub(super) struct Enter<'a> {
    pub(super) ranking: Ranking<'a>,
    pub(super) fresh: &'a mut Vec<Node>,
    pub(super) index: usize,
}

impl WithSimd for Enter<'_> {
    type Output = (u64, u64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        let Some((state, _, view)) = self.ranking.view(self.index) else {
            return (0, 0);
        };
        let all = Node {
            bound: 0.0,
            // A voxel is a step away from content at least.
            distance_sum: view.voxel_count(),
            view: self.index as u32,
            x: 0,
            y: 0,
            height: 0,
            extent: Extent::PLACEMENT,
            is_measured: false,
        };
        match self.ranking.placements(self.index) {
            Some(placements) => self.levels(all, placements, state, view),
            None => self.blocks(all, view),
        }
    }
}

impl Enter<'_> {
    #[inline(always)]
    fn levels(
        self,
        all: Node,
        placements: Placements<'_>,
        state: &ViewState,
        view: &ItemView,
    ) -> (u64, u64) {
        let (fitting, height) = placements.summarise(state.limit);
        if fitting > 0 {
            let level = Node {
                height,
                extent: Extent::Level,
                ..all
            };
            self.fresh.push(self.ranking.bounded(level, state, view));
        }
        (placements.count(), fitting)
    }

    #[inline(always)]
    fn blocks(self, all: Node, view: &ItemView) -> (u64, u64) {
        let prepared = self.ranking.prepared;
        let windows = prepared.windows.as_ref();
        let exponent = windows.map_or(0, |windows| windows.largest_exponent);
        let side = 1 << exponent;
        let (placed_x, placed_y) = view.corners(prepared.resting.container.size());
        let known = self.fresh.len();
        for x in (0..placed_x).step_by(side) {
            for y in (0..placed_y).step_by(side * TOGETHER) {
                let of = Node {
                    extent: Extent::Block { exponent },
                    ..all
                };
                let corners = std::array::from_fn(|corner| (x, y + corner * side));
                add(self.ranking, of, corners, self.fresh);
            }
        }
        let added = self.fresh.len() - known;
        let fitting = if exponent == 0 { added } else { 0 };
        ((placed_x * placed_y) as u64, fitting as u64)
    }
}

/// Adds blocks of one size and view, those of them that hold a placement below the rim.
#[inline(always)]
pub(super) fn add(
    ranking: Ranking<'_>,
    of: Node,
    corners: [(usize, usize); TOGETHER],
    fresh: &mut Vec<Node>,
) {
    let prepared = ranking.prepared;
    let Some((state, _, view)) = ranking.view(of.view as usize) else {
        return;
    };
    let container = &prepared.resting.container;
    let map = match (of.extent, &prepared.windows) {
        (Extent::Block { exponent: 0 }, _) => Some(container),
        (Extent::Block { exponent }, Some(windows)) => windows.lowest(exponent),
        _ => None,
    };
    let (Some(map), Some(offsets)) = (map, prepared.offsets.get(of.view as usize)) else {
        return;
    };
    let (placed_x, placed_y) = view.corners(container.size());
    let bases = corners.map(|(x, y)| {
        // One that is beyond the last placement is computed for nothing at the node's own corner.
        if x < placed_x && y < placed_y {
            map.index(x, y)
        } else {
            map.index(usize::from(of.x), usize::from(of.y))
        }
    });
    let heights = resting_heights_at(map, bases, view, offsets);
    for ((x, y), height) in corners.into_iter().zip(heights) {
        if x >= placed_x || y >= placed_y || height > state.limit {
            continue;
        }
        let (x, y) = (x as u16, y as u16);
        let node = Node {
            x,
            y,
            height,
            is_measured: false,
            ..of
        };
        fresh.push(ranking.bounded(node, state, view));
    }
}
