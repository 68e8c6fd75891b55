//! Samples of a surface by their places.

use nalgebra::Point2;
use ppnpack_packing::kernel::grid::Grid;

use crate::settings::MapperSettings;

/// The samples of a grid's surface, numbered row by row, seen from above.
///
/// A container that is no multiple of the cell has a strip beside the grid, which is in no sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Raster {
    pub(crate) nx: usize,
    pub(crate) ny: usize,
    samples_per_m: f64,
    /// Distance along x and y of what a point stands for.
    radius_m: f64,
    /// The first and the last sample along x and y that lie wholly beyond the margin at both walls;
    /// the middle one where there are none.
    inner: [(usize, usize); 2],
}

impl Raster {
    pub(crate) fn new(grid: &Grid, settings: &MapperSettings) -> Self {
        let per_cell = grid.resolution().samples_per_cell();
        let (nx, ny) = (grid.nx() * per_cell, grid.ny() * per_cell);
        let samples_per_m = 1.0 / grid.resolution().surface_pitch_m();
        let (container, margin_m) = (grid.container(), settings.wall_margin_m);
        let inner = |(count, side_m): (usize, f64)| {
            let middle = count / 2;
            let first = (margin_m * samples_per_m - 1e-6).ceil() as usize;
            let end = ((side_m - margin_m) * samples_per_m + 1e-6) as usize;
            let last = end.min(count).saturating_sub(1);
            (first.min(middle), last.max(middle))
        };
        Self {
            nx,
            ny,
            samples_per_m,
            radius_m: settings.point_radius_m,
            inner: [(nx, container.x_m), (ny, container.y_m)].map(inner),
        }
    }

    /// Gives the sample that a place with positive coordinates is in.
    pub(crate) fn sample_at(&self, x_m: f64, y_m: f64) -> Option<usize> {
        let [x, y] = [x_m, y_m].map(|side_m| (side_m * self.samples_per_m) as usize);
        (x < self.nx && y < self.ny).then_some(x * self.ny + y)
    }

    pub(crate) fn middle(&self, sample: usize) -> Point2<f64> {
        let (x, y) = (sample / self.ny, sample % self.ny);
        Point2::new(x as f64 + 0.5, y as f64 + 0.5) / self.samples_per_m
    }

    /// Gives the nearest sample that lies beyond the margin at all walls.
    pub(crate) fn beyond_margin(&self, sample: usize) -> usize {
        let [(first_x, last_x), (first_y, last_y)] = self.inner;
        let (x, y) = (sample / self.ny, sample % self.ny);
        x.clamp(first_x, last_x) * self.ny + y.clamp(first_y, last_y)
    }

    /// Gives the samples of the square that reaches so many samples around one.
    pub(crate) fn samples_within(self, sample: usize, reach: usize) -> impl Iterator<Item = usize> {
        let around = |at: usize, count| at.saturating_sub(reach)..(at + reach + 1).min(count);
        let ys = around(sample % self.ny, self.ny);
        let xs = around(sample / self.ny, self.nx);
        xs.flat_map(move |x| ys.clone().map(move |y| x * self.ny + y))
    }

    /// Gives the samples that a point at this place stands for.
    pub(crate) fn samples_near(self, x_m: f64, y_m: f64) -> impl Iterator<Item = usize> {
        // Casts saturate: what lies before the first sample belongs to it.
        let first = |side_m: f64| ((side_m - self.radius_m) * self.samples_per_m) as usize;
        let end = |side_m: f64| ((side_m + self.radius_m) * self.samples_per_m) as usize + 1;
        let xs = first(x_m)..end(x_m).min(self.nx);
        let ys = first(y_m)..end(y_m).min(self.ny);
        xs.flat_map(move |x| ys.clone().map(move |y| x * self.ny + y))
    }
}
