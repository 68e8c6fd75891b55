//! Heights over a support, and numbers that do not depend on the yaw.

use nalgebra::{Point2, Point3, Vector2};
use ppnpack_catalogue::mesh::{Bounds, Mesh};
use ppnpack_catalogue::raster::{Raster, rasterise};

/// Edge of a cell, in metres.
pub(crate) const CELL_M: f64 = 0.003;

/// Maximum number of cells along a side; larger things are cut off.
const MAX_CELLS: f64 = 400.0;

/// Stands for a cell without material.
const NOTHING: f32 = 0.0;

/// The upper surface over a support plane in cells, from the plane, in metres.
#[derive(Debug, Clone)]
pub(crate) struct UpperSurface {
    cells: Raster,
    /// Row-major; 0 where there is nothing above the least height.
    heights_m: Vec<f32>,
}

/// Numbers of a surface that do not depend on its yaw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outline {
    /// The middle of the covered cells.
    pub(crate) centre: Point2<f64>,
    /// The height that 2 % of the cells exceed.
    pub(crate) height_m: f64,
    /// The mean height of covered cells.
    pub(crate) mean_height_m: f64,
    /// The square root of the covered area.
    pub(crate) width_m: f64,
    /// Standard deviations of the covered cells along the longer and the shorter principal axis.
    pub(crate) spreads_m: [f64; 2],
    /// The mean of heights times the distance from the middle, over the mean height: how far out
    /// the material is.
    pub(crate) reach_m: f64,
}

impl UpperSurface {
    fn empty(lowest: Point2<f64>, highest: Point2<f64>) -> Self {
        let cells =
            |from: f64, to: f64| ((to - from) / CELL_M).ceil().clamp(1.0, MAX_CELLS) as usize;
        let (nx, ny) = (cells(lowest.x, highest.x), cells(lowest.y, highest.y));
        Self {
            cells: Raster {
                origin: lowest,
                pitch_m: CELL_M,
                nx,
                ny,
            },
            heights_m: vec![NOTHING; nx * ny],
        }
    }

    /// Gives the surface of a mesh that stands on the plane; what is below `least_height_m` is left
    /// out.
    pub(crate) fn of_mesh(mesh: &Mesh, least_height_m: f64) -> Option<Self> {
        let bounds = mesh.bounds()?;
        let mut surface = Self::empty(bounds.lowest.xy(), bounds.highest.xy());
        let cells = surface.cells;
        for corners in mesh.corners() {
            rasterise(&corners, &cells, |x, y, _, highest_m| {
                surface.raise(x, y, highest_m, least_height_m);
            });
        }
        Some(surface)
    }

    /// Gives the surface of points over the plane.
    pub(crate) fn of_points(points: &[Point3<f64>], least_height_m: f64) -> Option<Self> {
        let bounds = Bounds::of(points)?;
        let lowest = bounds.lowest.xy();
        let mut surface = Self::empty(lowest, bounds.highest.xy());
        for point in points {
            let offset = (point.xy() - lowest) / CELL_M;
            // Casts saturate.
            let (x, y) = (offset.x as usize, offset.y as usize);
            let Raster { nx, ny, .. } = surface.cells;
            if x <= nx && y <= ny {
                let (x, y) = (x.min(nx - 1), y.min(ny - 1));
                surface.raise(x, y, point.z, least_height_m);
            }
        }
        Some(surface)
    }

    fn raise(&mut self, x: usize, y: usize, height_m: f64, least_height_m: f64) {
        if height_m >= least_height_m
            && let Some(cell) = self.heights_m.get_mut(x * self.cells.ny + y)
        {
            *cell = cell.max(height_m as f32);
        }
    }

    /// Gives the height at a place, in metres; 0 where there is nothing.
    #[inline]
    pub(crate) fn at(&self, place: &Point2<f64>) -> f32 {
        let offset = (place - self.cells.origin) / CELL_M;
        let (x, y) = (offset.x as usize, offset.y as usize);
        let is_before = offset.x < 0.0 || offset.y < 0.0;
        if is_before || x >= self.cells.nx || y >= self.cells.ny {
            return NOTHING;
        }
        let height_m = self.heights_m.get(x * self.cells.ny + y);
        height_m.copied().unwrap_or(NOTHING)
    }

    /// Gives the middles and heights of covered cells, in metres.
    pub(crate) fn covered(&self) -> impl Iterator<Item = (Point2<f64>, f32)> + '_ {
        let cells = self.heights_m.iter().enumerate();
        let covered = cells.filter(|(_, height_m)| **height_m > NOTHING);
        covered.map(|(index, height_m)| {
            let (x, y) = (index / self.cells.ny, index % self.cells.ny);
            let middle = Vector2::new(x as f64 + 0.5, y as f64 + 0.5) * CELL_M;
            (self.cells.origin + middle, *height_m)
        })
    }

    /// Gives the numbers that do not depend on the yaw; `None` where nothing is covered.
    pub(crate) fn outline(&self) -> Option<Outline> {
        let mut heights_m: Vec<f32> = Vec::new();
        let mut sum = Vector2::zeros();
        for (place, height_m) in self.covered() {
            heights_m.push(height_m);
            sum += place.coords;
        }
        let count = heights_m.len() as f64;
        if heights_m.is_empty() {
            return None;
        }
        let centre = Point2::from(sum / count);
        let (mut xx, mut xy, mut yy, mut reach) = (0.0, 0.0, 0.0, 0.0);
        for (place, height_m) in self.covered() {
            let offset = place - centre;
            xx += offset.x * offset.x;
            xy += offset.x * offset.y;
            yy += offset.y * offset.y;
            reach += f64::from(height_m) * offset.norm();
        }
        let middle = (xx + yy) / 2.0;
        let apart = ((xx - yy) / 2.0).hypot(xy);
        let spread = |moment: f64| (moment.max(0.0) / count).sqrt();
        let total_m: f64 = heights_m.iter().copied().map(f64::from).sum();
        let rank = (heights_m.len() * 98 / 100).min(heights_m.len() - 1);
        let (_, height_m, _) = heights_m.select_nth_unstable_by(rank, f32::total_cmp);
        Some(Outline {
            centre,
            height_m: f64::from(*height_m),
            mean_height_m: total_m / count,
            width_m: count.sqrt() * CELL_M,
            spreads_m: [spread(middle + apart), spread(middle - apart)],
            reach_m: reach / total_m,
        })
    }
}

impl Outline {
    /// Gives the difference of two outlines: the sum of the squares of their numbers' differences,
    /// in units of the sensor's uncertainty.
    pub(crate) fn difference(&self, other: &Self) -> f64 {
        let [long, short] = self.spreads_m;
        let [other_long, other_short] = other.spreads_m;
        let terms = [
            (self.height_m - other.height_m, 0.0025),
            (self.mean_height_m - other.mean_height_m, 0.004),
            (self.width_m - other.width_m, 0.004),
            (long - other_long, 0.0025),
            (short - other_short, 0.0025),
            (self.reach_m - other.reach_m, 0.003),
        ];
        let squares = terms.map(|(difference_m, deviation_m)| (difference_m / deviation_m).powi(2));
        squares.iter().sum()
    }
}
