//! Passes over resting maps, each compiled for the processor's features.

use pulp::{Simd, WithSimd};

use super::{Level, NO_HEIGHT, Pending, Summary};
use crate::distance::DistanceLevels;
use crate::grid::Units;
use crate::heightmap::Heightmap;
use crate::resting_maps::RestingMap;

/// Recomputes the distance levels of a container.
pub(super) struct UpdateDistance<'a> {
    pub(super) distance: &'a mut DistanceLevels,
    pub(super) heightmap: &'a Heightmap,
}

impl WithSimd for UpdateDistance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.distance.update(self.heightmap);
    }
}

/// Counts what a map holds.
pub(super) struct Summarise<'a> {
    pub(super) map: &'a RestingMap,
    pub(super) limit: Units,
}

impl WithSimd for Summarise<'_> {
    type Output = Summary;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Summary {
        let Self { map, limit } = self;
        let (mut fitting, mut lowest) = (0, NO_HEIGHT);
        for row in map.rows() {
            let row = row.get(..map.ny).unwrap_or(&[]);
            let mut row_fitting = 0_u16;
            for height in row {
                row_fitting += u16::from(*height <= limit);
                lowest = lowest.min(*height);
            }
            fitting += u64::from(row_fitting);
        }
        Summary {
            proposed: (map.nx * map.ny) as u64,
            fitting,
            lowest: (fitting > 0).then_some(lowest),
        }
    }
}

/// Collects the placements of a level; gives the next greater resting height of its view that fits.
pub(super) struct Collect<'a> {
    pub(super) map: &'a RestingMap,
    pub(super) level: Level,
    pub(super) limit: Units,
    pub(super) pending: &'a mut Vec<Pending>,
}

impl WithSimd for Collect<'_> {
    type Output = Option<Units>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<Units> {
        let Self {
            map,
            level: Level { view, height, .. },
            limit,
            pending,
        } = self;
        let mut next = NO_HEIGHT;
        for (x, row) in map.rows().enumerate() {
            let row = row.get(..map.ny).unwrap_or(&[]);
            let mut found = false;
            for other in row {
                found |= *other == height;
                next = next.min(if *other > height { *other } else { NO_HEIGHT });
            }
            if found {
                let of_level = row
                    .iter()
                    .enumerate()
                    .filter(|(_, other)| **other == height);
                pending.extend(of_level.map(|(y, _)| Pending {
                    view,
                    x,
                    y,
                    height,
                    value: 0.0,
                }));
            }
        }
        (next <= limit).then_some(next)
    }
}
