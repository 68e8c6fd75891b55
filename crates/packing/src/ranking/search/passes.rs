//! Passes over the resting heights of whole views.

use super::open::{Extent, NO_HEIGHT, Node};
use super::proposed::ProposedView;
use crate::kernel::grid::Units;
use crate::kernel::resting::RestingMap;

#[derive(Clone, Copy)]
pub(super) enum Placements<'a> {
    All(&'a RestingMap),
    Proposed(&'a ProposedView),
}

impl Placements<'_> {
    pub(super) fn count(self) -> u64 {
        match self {
            Self::All(map) => map.count(),
            Self::Proposed(proposed) => proposed.corners.len() as u64,
        }
    }

    /// Counts those that rest at `limit` or lower; gives the least resting height of any.
    #[inline(always)]
    pub(super) fn summarise(self, limit: Units) -> (u64, Units) {
        match self {
            Self::All(map) => summarise(map, limit),
            Self::Proposed(proposed) => proposed.summarise(limit),
        }
    }

    /// Collects those of a level; gives the next greater resting height of the view.
    #[inline(always)]
    pub(super) fn collect(self, level: Node, placements: &mut Vec<Node>) -> Units {
        match self {
            Self::All(map) => collect(map, level, placements),
            Self::Proposed(proposed) => proposed.collect(level, placements),
        }
    }
}

#[inline(always)]
fn summarise(map: &RestingMap, limit: Units) -> (u64, Units) {
    let (mut fitting, mut lowest) = (0, NO_HEIGHT);
    for row in map.rows() {
        let mut row_fitting = 0_u16;
        for height in row {
            row_fitting += u16::from(*height <= limit);
            lowest = lowest.min(*height);
        }
        fitting += u64::from(row_fitting);
    }
    (fitting, lowest)
}

#[inline(always)]
fn collect(map: &RestingMap, level: Node, placements: &mut Vec<Node>) -> Units {
    let mut next = NO_HEIGHT;
    for (x, row) in map.rows().enumerate() {
        let mut found = false;
        for other in row {
            found |= *other == level.height;
            let is_above = *other > level.height;
            next = next.min(if is_above { *other } else { NO_HEIGHT });
        }
        if found {
            let of_level = row.iter().enumerate();
            let of_level = of_level.filter(|(_, other)| **other == level.height);
            placements.extend(of_level.map(|(y, _)| Node {
                x: x as u16,
                y: y as u16,
                extent: Extent::PLACEMENT,
                ..level
            }));
        }
    }
    next
}
