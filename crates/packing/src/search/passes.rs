//! Passes over resting maps, each compiled for the processor's features.

use pulp::{Simd, WithSimd};

use super::{Level, NOT_PROPOSED, Pending};
use crate::distance::DistanceLevels;
use crate::grid::Units;
use crate::heightmap::Heightmap;
use crate::item::ItemView;
use crate::kernel::{PaddedMap, resting_height};
use crate::placement::Placement;
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

/// Computes the resting heights of a view's proposed placements.
pub(super) struct FillProposed<'a> {
    pub(super) container: &'a PaddedMap,
    pub(super) view: &'a ItemView,
    pub(super) yaw: usize,
    pub(super) placements: &'a [Placement],
    pub(super) map: &'a mut RestingMap,
}

impl WithSimd for FillProposed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self {
            container,
            view,
            yaw,
            placements,
            map,
        } = self;
        for Placement { x, y, .. } in placements.iter().filter(|placement| placement.yaw == yaw) {
            if *x < map.nx && *y < map.ny {
                let base = x * container.stride() + y;
                map.set(*x, *y, resting_height(container, base, view));
            }
        }
    }
}

/// What a map holds.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Summary {
    pub(super) proposed: u64,
    pub(super) fitting: u64,
    pub(super) lowest: Option<Units>,
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
        let (mut proposed, mut fitting, mut lowest) = (0, 0, NOT_PROPOSED);
        for row in map.rows() {
            let row = row.get(..map.ny).unwrap_or(&[]);
            let (mut row_proposed, mut row_fitting) = (0_u16, 0_u16);
            for height in row {
                row_proposed += u16::from(*height != NOT_PROPOSED);
                row_fitting += u16::from(*height <= limit);
                lowest = lowest.min(*height);
            }
            proposed += u64::from(row_proposed);
            fitting += u64::from(row_fitting);
        }
        Summary {
            proposed,
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
        let mut next = NOT_PROPOSED;
        for (x, row) in map.rows().enumerate() {
            let row = row.get(..map.ny).unwrap_or(&[]);
            let mut found = false;
            for other in row {
                found |= *other == height;
                next = next.min(if *other > height {
                    *other
                } else {
                    NOT_PROPOSED
                });
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
