//! The open list of the best-first search.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::kernel::grid::Units;

/// Above every resting height.
pub(super) const NO_HEIGHT: Units = Units::MAX;

/// Nodes still to be opened or returned, the least bound first.
pub(super) type OpenList = BinaryHeap<Node>;

/// Placements of one view, none of which has a value below the bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node {
    /// The value itself, where that is known.
    pub(super) bound: f64,
    /// None of the placements has a lesser sum of distances.
    pub(super) distance_sum: u64,
    /// Index of the ranking's view.
    pub(super) view: u32,
    pub(super) x: u16,
    pub(super) y: u16,
    /// None of the placements rests lower.
    pub(super) height: Units,
    pub(super) extent: Extent,
    /// Whether the sum of distances is of this block, not of one it was cut from.
    pub(super) is_measured: bool,
}

/// Placements that a node stands for, in the order in which those of one bound come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Extent {
    /// A square of `2^exponent` placements a side, single placements among them.
    Block { exponent: u8 },
    /// All of the view with this resting height, wherever they are.
    Level,
    /// A placement whose value is known. The last, so that it comes up only once no bound can hide
    /// a lesser value or an earlier placement of the same value.
    Valued,
}

impl Extent {
    /// A single placement.
    pub(super) const PLACEMENT: Self = Self::Block { exponent: 0 };
}

// The heap gives its greatest first: the order is reversed.
impl Eq for Node {}
impl Ord for Node {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |node: &Self| (node.extent, node.view, node.x, node.y);
        other
            .bound
            .total_cmp(&self.bound)
            .then_with(|| key(other).cmp(&key(self)))
    }
}
impl PartialOrd for Node {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
