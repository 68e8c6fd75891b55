//! The truncated distance `D` to a container's content, in closed form.

use crate::kernel::grid::{Grid, Units};
use crate::kernel::heightmap::Heightmap;
use crate::kernel::lanes::{PaddedMap, WALL};
use crate::kernel::layout::DISTANCE_LEVELS;

/// One step of the truncated distance, in metres: the paper measures in centimetres.
pub const DISTANCE_STEP_M: f64 = 0.01;

/// `D` is truncated to this many steps.
pub const DISTANCE_TRUNCATION: usize = DISTANCE_LEVELS + 1;

/// Rows that are dilated along y at once: enough for a loop to pay, few enough for the cache.
const BAND_ROWS: usize = 16;

/// The heights from which on a voxel is further than 1, 2, ... steps from content, walls and floor:
/// `D`, the truncated distance of SDF-Pack (Pan et al., 2023).
///
/// The scene below the heightmap is full, so the voxels within `d` steps of content are those below
/// `H_d` = the heightmap dilated by `d` steps (walls infinite), plus `d` steps. `D` of a voxel at
/// height `z` is `1 + #{d : z >= H_d}`, truncated to [`DISTANCE_TRUNCATION`].
#[derive(Debug, Clone)]
pub(crate) struct DistanceLevels {
    /// Cells that a level is dilated by, and units that it is lifted by.
    reach: [(usize, Units); DISTANCE_LEVELS],
    pub(crate) levels: [PaddedMap; DISTANCE_LEVELS],
    dilation: Dilation,
}

impl DistanceLevels {
    pub(crate) fn new(grid: &Grid) -> Self {
        let reach = |level| {
            let reach_m = DISTANCE_STEP_M * (level + 1) as f64;
            let resolution = grid.resolution();
            (
                resolution.cells_within(reach_m),
                resolution.units_below(reach_m),
            )
        };
        Self {
            reach: std::array::from_fn(reach),
            levels: std::array::from_fn(|_| PaddedMap::new(grid.nx(), grid.ny())),
            dilation: Dilation::new(grid.nx(), grid.ny()),
        }
    }

    /// Recomputes all levels for a heightmap of the grid's size.
    #[inline(always)]
    pub(crate) fn update(&mut self, heightmap: &Heightmap) {
        // Squares add up, so each level is a small dilation of the one before.
        let dilation = &mut self.dilation;
        dilation.heights.copy_from_slice(heightmap.heights());
        let mut dilated = 0;
        for (level, (radius, lift)) in self.levels.iter_mut().zip(self.reach) {
            dilation.dilate(radius - dilated);
            dilated = radius;
            dilation.write(radius, lift, level);
        }
    }
}

#[derive(Debug, Clone)]
struct Dilation {
    nx: usize,
    ny: usize,
    /// Right where all squares so far lie within the container; else 0 to the greatest height.
    heights: Vec<Units>,
    band: Vec<Units>,
}

impl Dilation {
    fn new(nx: usize, ny: usize) -> Self {
        Self {
            nx,
            ny,
            heights: vec![0; nx * ny],
            band: vec![0; BAND_ROWS.min(nx) * ny],
        }
    }

    /// Dilates by a square of `radius` cells around each cell.
    #[inline(always)]
    fn dilate(&mut self, radius: usize) {
        let window = 2 * radius + 1;
        if window > self.nx || window > self.ny {
            return;
        }
        let Self {
            ny, heights, band, ..
        } = self;
        // Windows that reach into the next row are among those that leave the container.
        for rows in heights.chunks_mut(band.len()) {
            let copy = band.get_mut(..rows.len()).unwrap_or(&mut []);
            for step in doubling(window) {
                copy.copy_from_slice(rows);
                raise(rows, copy.get(step..).unwrap_or(&[]));
            }
            // The maximum of the window that starts at a cell belongs to the cell in its middle.
            rows.copy_within(..rows.len() - radius, radius);
        }
        for step in doubling(window) {
            let mut rest = heights.as_mut_slice();
            while rest.len() > step * *ny {
                let (first, others) = rest.split_at_mut(*ny);
                let further = others.get((step - 1) * *ny..step * *ny);
                raise(first, further.unwrap_or(&[]));
                rest = others;
            }
        }
        let (cells, shift) = (heights.len(), radius * *ny);
        heights.copy_within(..cells - shift, shift);
    }

    /// Writes a level: the heights plus `lift`, and [`WALL`] within `radius` of a wall.
    #[inline(always)]
    fn write(&self, radius: usize, lift: Units, level: &mut PaddedMap) {
        let inner_y = radius..self.ny.saturating_sub(radius).max(radius);
        for (x, heights) in self.heights.chunks_exact(self.ny).enumerate() {
            let row = level.row_mut(x);
            row.fill(WALL);
            if x < radius || x + radius >= self.nx {
                continue;
            }
            let inner = row.get_mut(inner_y.clone()).unwrap_or(&mut []);
            let heights = heights.get(inner_y.clone()).unwrap_or(&[]);
            for (cell, height) in inner.iter_mut().zip(heights) {
                *cell = (height + lift).min(WALL);
            }
        }
    }
}

/// The offsets at which a running maximum joins itself to span a window: 1, 2, 4, ..., the rest.
fn doubling(window: usize) -> impl Iterator<Item = usize> {
    let mut spanned = 1;
    std::iter::from_fn(move || {
        let step = spanned.min(window - spanned);
        spanned += step;
        (step > 0).then_some(step)
    })
}

#[inline(always)]
fn raise(row: &mut [Units], heights: &[Units]) {
    for (cell, height) in row.iter_mut().zip(heights) {
        *cell = (*cell).max(*height);
    }
}
