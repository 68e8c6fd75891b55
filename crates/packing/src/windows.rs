//! Extremes of a map over the windows that start at each of its cells.

use crate::grid::Units;
use crate::kernel::PaddedMap;

/// From the extremes over windows of `side` cells a side those over windows of twice as many; windows that would reach
/// beyond the map's border end there. `choose` gives the greater of two heights, or the lesser; `row` is room for a row.
#[inline(always)]
pub(crate) fn widen(
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
        let out = wider.row_mut(x);
        out.copy_from_slice(row);
        for (cell, further) in out.iter_mut().zip(row.iter().skip(side)) {
            *cell = choose(*cell, *further);
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
