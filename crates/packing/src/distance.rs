//! The truncated distance `D` to a container's content, in closed form.

use crate::grid::{Grid, Units};
use crate::heightmap::Heightmap;
use crate::kernel::{DISTANCE_LEVELS, PaddedMap, WALL};

/// One step of the truncated distance, in metres: the paper measures in centimetres.
pub const DISTANCE_STEP_M: f64 = 0.01;

/// `D` is truncated to this many steps.
pub const DISTANCE_TRUNCATION: usize = DISTANCE_LEVELS + 1;

/// Cells and units within `step` steps of a distance: what a level dilates by and lifts by.
pub(crate) fn level_reach(grid: &Grid, step: usize) -> (usize, Units) {
    let resolution = grid.resolution();
    let reach_m = DISTANCE_STEP_M * step as f64;
    (
        resolution.cells_within(reach_m),
        resolution.units_below(reach_m),
    )
}

/// The heights from which on a voxel is further than 1, 2, ... steps from content, walls and floor.
///
/// The scene below the heightmap is full, so the voxels within `d` steps of content are those below
/// `H_d` = the heightmap dilated by `d` steps (walls infinite), plus `d` steps. `D` of a voxel at height `z` is
/// `1 + #{d : z >= H_d}`, truncated to [`DISTANCE_TRUNCATION`].
#[derive(Debug, Clone)]
pub(crate) struct DistanceLevels {
    reach: [(usize, Units); DISTANCE_LEVELS],
    levels: [PaddedMap; DISTANCE_LEVELS],
    along_y: PaddedMap,
}

impl DistanceLevels {
    pub(crate) fn new(grid: &Grid) -> Self {
        let map = || PaddedMap::new(grid.nx(), grid.ny());
        Self {
            reach: std::array::from_fn(|level| level_reach(grid, level + 1)),
            levels: std::array::from_fn(|_| map()),
            along_y: map(),
        }
    }

    pub(crate) fn levels(&self) -> &[PaddedMap; DISTANCE_LEVELS] {
        &self.levels
    }

    /// Recomputes all levels for a heightmap of the grid's size.
    #[inline(always)]
    pub(crate) fn update(&mut self, heightmap: &Heightmap) {
        for (level, (radius, lift)) in self.levels.iter_mut().zip(self.reach) {
            dilate(heightmap, radius, lift, &mut self.along_y, level);
        }
    }
}

/// `out` = the heightmap dilated by a square of `radius` cells, plus `lift`; [`WALL`] within `radius` of a wall.
#[inline(always)]
fn dilate(
    heightmap: &Heightmap,
    radius: usize,
    lift: Units,
    along_y: &mut PaddedMap,
    out: &mut PaddedMap,
) {
    let (nx, ny) = (heightmap.nx(), heightmap.ny());
    let inner_y = radius..ny.saturating_sub(radius).max(radius);
    for x in 0..nx {
        let heights = heightmap.row(x);
        let row = along_y.row_mut(x);
        row.fill(WALL);
        let Some(inner) = row.get_mut(inner_y.clone()) else {
            continue;
        };
        inner.fill(0);
        for window in heights.windows(inner.len().max(1)).take(2 * radius + 1) {
            raise(inner, window, 0);
        }
    }
    for x in 0..nx {
        let row = out.row_mut(x);
        if x < radius || x + radius >= nx {
            row.fill(WALL);
            continue;
        }
        row.fill(0);
        for other in x - radius..=x + radius {
            raise(row, along_y.row(other), lift);
        }
    }
}

#[inline(always)]
fn raise(row: &mut [Units], heights: &[Units], lift: Units) {
    for (cell, height) in row.iter_mut().zip(heights) {
        *cell = (*cell).max(height + lift).min(WALL);
    }
}
