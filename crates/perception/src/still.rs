//! Several clouds of a scene that does not move.
//!
//! Together they show more than single ones, with less noise; comparing them tells whether
//! something moves.

use std::collections::VecDeque;

use ppnpack_numbers::{settings, within};
use ppnpack_packing::kernel::grid::Grid;

use crate::layers::{NO_POINT, by_cell, is_known, neighbours};

/// Maximum number of clouds that are kept.
const MAX_CLOUDS: usize = 16;

/// Minimum difference of a sample's heights that are of different things, in standard deviations of
/// the noise.
const SAME_DEVIATIONS: f64 = 3.0;

settings! {
    /// Settings by which a scene is still.
    pub struct StillSettings with validate as "still." {
        /// Number of the latest clouds that must agree, and make the heightmap together: 1 to 16.
        /// With 1, each is by itself.
        pub clouds: usize = 1 => within("1 to 16", 1.0..=MAX_CLOUDS as f64),
        /// Something moved in a cell higher or lower than itself and its neighbours were by more
        /// than this, in metres.
        pub height_m: f64 = 0.01 => within("0 to 1 m", 0.0..=1.0),
        /// A scene is still where what moved covers at most this, in m²: steep edges show higher in
        /// one cloud than in another, in the more cells the finer the grid is.
        pub most_m2: f64 = 2e-4 => within("0 to 1 m²", 0.0..=1.0),
    }
}

/// The latest clouds of a scene, as heights of samples.
#[derive(Debug, Clone)]
pub(crate) struct History {
    settings: StillSettings,
    same_m: f32,
    /// Maximum number of cells in which something moves.
    most_cells: usize,
    /// Cells along y.
    ny: usize,
    per_cell: usize,
    frames: VecDeque<Frame>,
}

/// One cloud.
#[derive(Debug, Clone)]
struct Frame {
    samples_m: Vec<f32>,
    /// The highest sample of each cell.
    cells_m: Vec<f32>,
}

/// The latest cloud compared with those before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stillness {
    pub(crate) moved_cells: usize,
    pub(crate) clouds: usize,
    pub(crate) needed: usize,
}

impl Stillness {
    pub(crate) fn is_still(self) -> bool {
        self.clouds >= self.needed
    }
}

impl History {
    /// Makes a history for the samples of a grid, and noise of `noise_m`.
    pub(crate) fn new(grid: &Grid, noise_m: f64, settings: StillSettings) -> Self {
        let resolution = grid.resolution();
        let cells = settings.most_m2 / resolution.cell_m().powi(2);
        Self {
            most_cells: (cells + 1e-6) as usize,
            settings,
            same_m: (SAME_DEVIATIONS * noise_m) as f32,
            ny: grid.ny(),
            per_cell: resolution.samples_per_cell(),
            frames: VecDeque::new(),
        }
    }

    /// Forgets all clouds.
    pub(crate) fn clear(&mut self) {
        self.frames.clear();
    }

    /// Takes the samples of a cloud, and makes them those of all clouds since something moved. That
    /// is told by the cells as they were [before](Self::cells_of) any sample was taken for hidden.
    pub(crate) fn blend(&mut self, samples_m: &mut [f32], cells_m: Vec<f32>) -> Stillness {
        let needed = self.settings.clouds;
        if needed <= 1 {
            return Stillness {
                moved_cells: 0,
                clouds: 1,
                needed: 1,
            };
        }
        let frame = Frame {
            samples_m: samples_m.to_vec(),
            cells_m,
        };
        // The oldest: what creeps has moved farthest since.
        let oldest = self.frames.front();
        let moved_cells = oldest.map_or(0, |oldest| self.moved(&oldest.cells_m, &frame.cells_m));
        if moved_cells > self.most_cells {
            self.frames.clear();
        }
        self.frames.push_back(frame);
        if self.frames.len() > needed {
            self.frames.pop_front();
        }
        self.blend_frames(samples_m);
        Stillness {
            moved_cells,
            clouds: self.frames.len(),
            needed,
        }
    }

    /// Gives the highest sample of each cell.
    pub(crate) fn cells_of(&self, samples_m: &[f32]) -> Vec<f32> {
        let mut cells_m = vec![NO_POINT; samples_m.len() / (self.per_cell * self.per_cell)];
        for (cell, row) in by_cell(samples_m, self.per_cell, self.ny) {
            if let Some(cell_m) = cells_m.get_mut(cell) {
                *cell_m = row.iter().copied().fold(*cell_m, f32::max);
            }
        }
        cells_m
    }

    /// Counts the cells in which something came or went. What stays may show one cell farther in
    /// one cloud than in another.
    fn moved(&self, before_m: &[f32], after_m: &[f32]) -> usize {
        let limit_m = self.settings.height_m as f32;
        let rose =
            |from_m: f32, to_m: f32| is_known(from_m) && is_known(to_m) && to_m > from_m + limit_m;
        let own = |cells_m: &[f32], cell| cells_m.get(cell).copied().unwrap_or(NO_POINT);
        let highest = |cells_m: &[f32], cell| {
            let around = neighbours(cell, cells_m.len(), self.ny);
            let around_m = around.map(|near| own(cells_m, near));
            around_m.fold(NO_POINT, f32::max)
        };
        let moved = |cell: &usize| {
            rose(highest(before_m, *cell), own(after_m, *cell))
                || rose(highest(after_m, *cell), own(before_m, *cell))
        };
        (0..after_m.len()).filter(moved).count()
    }

    fn blend_frames(&self, samples_m: &mut [f32]) {
        for (index, sample_m) in samples_m.iter_mut().enumerate() {
            let (mut count, mut sum_m) = (0.0, 0.0);
            let (mut lowest_m, mut highest_m) = (f32::MAX, NO_POINT);
            for frame in &self.frames {
                let height_m = frame.samples_m.get(index).copied().unwrap_or(NO_POINT);
                if is_known(height_m) {
                    count += 1.0;
                    sum_m += height_m;
                    lowest_m = lowest_m.min(height_m);
                    highest_m = highest_m.max(height_m);
                }
            }
            // An edge that shows in some of the clouds is there.
            let is_same = count > 0.0 && highest_m - lowest_m <= self.same_m;
            *sample_m = if is_same { sum_m / count } else { highest_m };
        }
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::kernel::grid::{ContainerSize, Resolution, Yaws};

    use super::*;

    #[test]
    fn what_may_move_is_as_large_on_a_fine_grid_as_on_a_coarse_one() {
        for (cell_m, most_cells) in [(0.01, 2), (0.0025, 32)] {
            let yaws = Yaws::half_turn(1).unwrap();
            let resolution = Resolution::new(cell_m, 0.002, yaws).unwrap();
            let grid = Grid::new(ContainerSize::REFERENCE, resolution).unwrap();
            let settings = StillSettings {
                clouds: 3,
                ..StillSettings::default()
            };
            let mut history = History::new(&grid, 0.001, settings);
            let per_cell = grid.resolution().samples_per_cell();
            let mut see = |raised: usize| {
                let cells = grid.nx() * grid.ny();
                let mut samples_m = vec![0.1; cells * per_cell * per_cell];
                let spaced = samples_m.iter_mut().step_by(3 * per_cell);
                spaced.take(raised).for_each(|sample_m| *sample_m += 0.02);
                let cells_m = history.cells_of(&samples_m);
                let stillness = history.blend(&mut samples_m, cells_m);
                (stillness.moved_cells, stillness.clouds)
            };
            assert_eq!(see(0), (0, 1));
            assert_eq!(see(most_cells), (most_cells, 2), "{cell_m} m");
            assert_eq!(see(most_cells + 1), (most_cells + 1, 1), "{cell_m} m");
        }
    }
}
