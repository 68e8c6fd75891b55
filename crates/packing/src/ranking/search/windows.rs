//! Extremes of a container's maps over square windows, which bound what blocks can reach.
//!
//! Under a block, a square of `2^e` placements a side named by its first corner, the container is
//! at least as high as the least cell of the window of `2^e` cells at each cell under that corner.
//! So the first corner's resting height on the windowed minimum bounds the block; likewise its
//! distances on the windowed maximum of the levels. Both come from the loops of single placements.

use crate::kernel::distance::DistanceLevels;
use crate::kernel::grid::{Grid, Units};
use crate::kernel::lanes::PaddedMap;
use crate::kernel::layout::DISTANCE_LEVELS;
use crate::kernel::objective::Heuristic;

/// Largest blocks as a share of the longer side: larger ones are always cut, of smaller are many.
const LARGEST_SHARE: usize = 8;

#[derive(Debug)]
pub(super) struct Windows {
    /// The largest blocks have `2^largest_exponent` placements a side.
    pub(super) largest_exponent: u8,
    /// The container's least heights in windows of `2^(entry + 1)` cells a side.
    lowest: Vec<PaddedMap>,
    /// The distance levels' greatest heights in these windows, where the objective knows distance.
    distance: Vec<[PaddedMap; DISTANCE_LEVELS]>,
    row: Vec<Units>,
}

impl Windows {
    /// For objectives whose bounds tell placements apart; others must look everywhere.
    pub(super) fn new(grid: &Grid, heuristic: Heuristic) -> Option<Self> {
        let map = || PaddedMap::new(grid.nx(), grid.ny());
        let exponents = Self::exponents(grid);
        let of_distance = match heuristic {
            Heuristic::Sdfm => exponents,
            Heuristic::Dbl | Heuristic::Hm => 0,
            Heuristic::Mta | Heuristic::FirstFit | Heuristic::Random => return None,
        };
        Some(Self {
            largest_exponent: exponents as u8,
            lowest: (0..exponents).map(|_| map()).collect(),
            distance: (0..of_distance)
                .map(|_| std::array::from_fn(|_| map()))
                .collect(),
            row: vec![0; grid.ny()],
        })
    }

    /// In how many sizes there are blocks of more than one placement.
    pub(super) fn exponents(grid: &Grid) -> usize {
        let largest = grid.nx().max(grid.ny()) / LARGEST_SHARE;
        largest.checked_ilog2().unwrap_or(0) as usize
    }

    /// The container's least heights in the windows of blocks of more than one placement.
    #[inline(always)]
    pub(super) fn lowest(&self, exponent: u8) -> Option<&PaddedMap> {
        self.lowest.get(usize::from(exponent).checked_sub(1)?)
    }

    /// The distance levels' greatest heights in the same windows.
    #[inline(always)]
    pub(super) fn distance(&self, exponent: u8) -> Option<&[PaddedMap; DISTANCE_LEVELS]> {
        self.distance.get(usize::from(exponent).checked_sub(1)?)
    }

    #[inline(always)]
    pub(super) fn update(&mut self, container: &PaddedMap, distance: Option<&DistanceLevels>) {
        let mut finer = container;
        for (exponent, wider) in self.lowest.iter_mut().enumerate() {
            widen(finer, 1 << exponent, Units::min, wider, &mut self.row);
            finer = wider;
        }
        let Some(distance) = distance else { return };
        let mut finer = &distance.levels;
        for (exponent, wider) in self.distance.iter_mut().enumerate() {
            for (finer, wider) in finer.iter().zip(wider.iter_mut()) {
                widen(finer, 1 << exponent, Units::max, wider, &mut self.row);
            }
            finer = wider;
        }
    }
}

/// Gives the extremes over windows of twice `side` cells, which end at the map's border, from those
/// over `side`. `choose` gives the greater of two heights, or the lesser; `row` is room for a row.
#[inline(always)]
fn widen(
    finer: &PaddedMap,
    side: usize,
    choose: impl Fn(Units, Units) -> Units,
    wider: &mut PaddedMap,
    row: &mut [Units],
) {
    let (nx, _) = finer.size();
    for x in 0..nx {
        let further = if x + side < nx { x + side } else { x };
        let pairs = finer.row(x).iter().zip(finer.row(further));
        for (cell, (a, b)) in row.iter_mut().zip(pairs) {
            *cell = choose(*a, *b);
        }
        let (_, further) = row.split_at(side.min(row.len()));
        let out = wider.row_mut(x);
        for (cell, (near, far)) in out.iter_mut().zip(row.iter().zip(further)) {
            *cell = choose(*near, *far);
        }
        let border = further.len()..;
        if let (Some(out), Some(row)) = (out.get_mut(border.clone()), row.get(border)) {
            out.copy_from_slice(row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_hold_their_greatest_and_least_cells() {
        let (nx, ny) = (13, 37);
        let mut map = PaddedMap::new(nx, ny);
        for x in 0..nx {
            for (y, cell) in map.row_mut(x).iter_mut().enumerate() {
                *cell = ((x * 71 + y * 29) % 101) as Units;
            }
        }
        let mut row = vec![0; ny];
        let (mut least, mut greatest) = (map.clone(), map.clone());
        for side in [1, 2, 4, 8, 16] {
            let mut wider = PaddedMap::new(nx, ny);
            widen(&least, side, Units::min, &mut wider, &mut row);
            least = wider.clone();
            widen(&greatest, side, Units::max, &mut wider, &mut row);
            greatest = wider;
            for x in 0..nx {
                for y in 0..ny {
                    let window = (x..nx.min(x + 2 * side)).flat_map(|x| {
                        let row = map.row(x).get(y..ny.min(y + 2 * side)).unwrap_or(&[]);
                        row.iter().copied()
                    });
                    let expected = (window.clone().min(), window.max());
                    let found = (least.row(x).get(y), greatest.row(x).get(y));
                    assert_eq!((found.0.copied(), found.1.copied()), expected);
                }
            }
        }
    }
}
