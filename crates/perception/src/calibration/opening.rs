//! The container's opening: the highest level whose points enclose a hole with something deep in
//! it.

use nalgebra::{Point2, Point3};

use super::error::CalibrationError;
use super::levelled::Levelled;
use super::mask::Mask;
use super::plane::median;
use super::settings::CalibrationSettings;

/// Maximum distance of a container from the middle of the cloud, in metres.
const REACH_M: f64 = 1.6;

/// Difference in height of points of a rim, in metres, while up is not exact.
const LEVEL_M: f64 = 0.004;

/// Number of slices above and below a level's own in which its points lie.
const SLICES_BESIDE: usize = 1;

/// Edge of the squares by which the distance of points is measured, in metres.
const DENSITY_SQUARE_M: f64 = 0.01;

/// Maximum distance of points that show a rim, in metres.
const WIDEST_SPACING_M: f64 = 0.007;

/// Minimum area of an opening, in square metres.
const LEAST_AREA_M2: f64 = 0.005;

/// Minimum share of a hole's cells that is deep, of those that are seen.
const LEAST_DEEP_SHARE: f64 = 0.5;

/// Minimum share of the opening's area by which another one is another container.
const OTHER_SHARE: f64 = 0.5;

/// Maximum ratio of a hole's area and that of the known size.
const AREA_FACTOR: f64 = 1.35;

/// The opening of a container.
#[derive(Debug, Clone)]
pub(super) struct Opening {
    /// The height of the rim, in metres; below the sensor, so negative.
    pub(super) rim_m: f64,
    /// The height of the floor, in metres.
    pub(super) floor_m: f64,
    /// The middles of the cells of the hole.
    pub(super) cells_m: Vec<Point2<f64>>,
    /// The edge of a cell, in metres.
    pub(super) pitch_m: f64,
    /// The distance of neighbouring points, in metres.
    pub(super) spacing_m: f64,
    /// How far the walls are taken to lean outwards, per metre of height.
    pub(super) lean: f64,
}

struct Hole {
    level_m: f64,
    cells: Vec<(usize, usize)>,
}

pub(super) fn find(
    levelled: &Levelled,
    settings: &CalibrationSettings,
) -> Result<Opening, CalibrationError> {
    let map = Map::new(levelled)?;
    let mut holes = map.holes(settings.least_depth_m);
    if let Some(size) = settings.size {
        let known_m2 = size.x_m * size.y_m;
        holes.retain(|hole| {
            let area_m2 = map.area_m2(&hole.cells);
            (known_m2 / AREA_FACTOR..=known_m2 * AREA_FACTOR).contains(&area_m2)
        });
    }
    holes.sort_by_key(|hole| std::cmp::Reverse(hole.cells.len()));
    let mut holes = holes.into_iter();
    let largest = holes.next().ok_or_else(CalibrationError::no_rim)?;
    if let Some(other) = holes.next()
        && other.cells.len() as f64 > OTHER_SHARE * largest.cells.len() as f64
    {
        return Err(CalibrationError::new(
            "more than one container is seen: leave one in view, or give the size of the one that is meant",
        ));
    }
    map.opening(levelled, &largest, settings.least_depth_m)
}

/// The cloud from above, in square cells.
struct Map {
    corner: Point2<f64>,
    spacing_m: f64,
    pitch_m: f64,
    /// Cells along each side.
    side: usize,
    /// Per cell the height of its lowest point; infinite where there is none.
    lowest_m: Vec<f64>,
    /// Slices of equal height from the lowest up, with the cells that have points in them.
    slices: Vec<Vec<(u32, u32)>>,
    bottom_m: f64,
}

impl Map {
    fn new(levelled: &Levelled) -> Result<Self, CalibrationError> {
        let points_m = &levelled.points_m;
        let middle = |side: fn(&Point3<f64>) -> f64| {
            median(&mut points_m.iter().map(side).collect::<Vec<_>>())
        };
        let (x, y) = (middle(|point| point.x), middle(|point| point.y));
        let corner = Point2::new(x - REACH_M, y - REACH_M);
        let spacing_m = spacing_m(points_m, &corner)?;
        let pitch_m = (1.5 * spacing_m).clamp(0.003, 0.012);
        let cells = (2.0 * REACH_M / pitch_m) as usize + 1;
        let mut map = Self {
            corner,
            spacing_m,
            pitch_m,
            side: cells,
            lowest_m: vec![f64::INFINITY; cells * cells],
            slices: Vec::new(),
            bottom_m: 0.0,
        };
        map.fill(points_m);
        Ok(map)
    }

    fn fill(&mut self, points_m: &[Point3<f64>]) {
        let inside = |point: &&Point3<f64>| self.cell(&point.xy()).is_some();
        let heights = points_m.iter().filter(inside).map(|point| point.z);
        self.bottom_m = heights.fold(0.0, f64::min);
        let slices = (-self.bottom_m / LEVEL_M) as usize + 1;
        self.slices = vec![Vec::new(); slices];
        for point in points_m {
            let Some((x, y)) = self.cell(&point.xy()) else {
                continue;
            };
            let slice = ((point.z - self.bottom_m) / LEVEL_M) as usize;
            if let Some(slice) = self.slices.get_mut(slice) {
                slice.push((x as u32, y as u32));
            }
            if let Some(lowest_m) = self.lowest_m.get_mut(x * self.side + y) {
                *lowest_m = lowest_m.min(point.z);
            }
        }
    }

    fn cell(&self, place: &Point2<f64>) -> Option<(usize, usize)> {
        let cell = (place - self.corner) / self.pitch_m;
        let sides = 0.0..self.side as f64;
        let is_inside = sides.contains(&cell.x) && sides.contains(&cell.y);
        is_inside.then_some((cell.x as usize, cell.y as usize))
    }

    fn middle(&self, (x, y): (usize, usize)) -> Point2<f64> {
        let place = nalgebra::Vector2::new(x as f64 + 0.5, y as f64 + 0.5);
        self.corner + place * self.pitch_m
    }

    fn area_m2(&self, cells: &[(usize, usize)]) -> f64 {
        cells.len() as f64 * self.pitch_m.powi(2)
    }

    /// Finds the holes with something deep in them, from above, each only where it is highest.
    fn holes(&self, least_depth_m: f64) -> Vec<Hole> {
        // A rim around the smallest opening has at least so many points.
        let least_points = (4.0 * LEAST_AREA_M2.sqrt() / self.pitch_m / 2.0) as usize;
        let mut found: Vec<Hole> = Vec::new();
        for slice in (0..self.slices.len()).rev() {
            let from = slice.saturating_sub(SLICES_BESIDE);
            let slices = self
                .slices
                .iter()
                .take(slice + SLICES_BESIDE + 1)
                .skip(from);
            let cells = || slices.clone().flatten().copied();
            if cells().count() < least_points {
                continue;
            }
            let level_m = self.bottom_m + (slice as f64 + 0.5) * LEVEL_M;
            for cells in enclosed(cells) {
                let hole = Hole { level_m, cells };
                if self.is_deep(&hole, least_depth_m)
                    && !found.iter().any(|higher| higher.has(&hole))
                {
                    found.push(hole);
                }
            }
        }
        found
    }

    fn is_deep(&self, hole: &Hole, least_depth_m: f64) -> bool {
        if self.area_m2(&hole.cells) < LEAST_AREA_M2 {
            return false;
        }
        let (mut seen, mut deep) = (0, 0);
        for (x, y) in &hole.cells {
            let lowest_m = self.lowest_m.get(x * self.side + y).copied();
            let lowest_m = lowest_m.unwrap_or(f64::INFINITY);
            seen += usize::from(lowest_m.is_finite());
            deep += usize::from(lowest_m < hole.level_m - least_depth_m);
        }
        deep as f64 >= LEAST_DEEP_SHARE * seen as f64
            && self.area_m2(&hole.cells) * 0.2 < deep as f64 * self.pitch_m.powi(2)
    }

    /// Gives the opening of a hole: the heights of its rim and its floor.
    fn opening(
        &self,
        levelled: &Levelled,
        hole: &Hole,
        least_depth_m: f64,
    ) -> Result<Opening, CalibrationError> {
        let mut inside = Mask::new(self.side, self.side);
        for (x, y) in &hole.cells {
            inside.set(*x, *y);
        }
        // The hole lost a cell on each side to the grown rim; the rim's points begin there.
        let around = inside.grown().grown().grown().grown();
        let (mut rim_m, mut deep_m) = (Vec::new(), Vec::new());
        for point in &levelled.points_m {
            let Some((x, y)) = self.cell(&point.xy()) else {
                continue;
            };
            if inside.get(x, y) {
                if point.z < hole.level_m - least_depth_m {
                    deep_m.push(point.z);
                }
            } else if around.get(x, y) && (point.z - hole.level_m).abs() <= 3.0 * LEVEL_M {
                rim_m.push(point.z);
            }
        }
        let floor_m = densest_m(&mut deep_m).ok_or_else(|| CalibrationError::no_floor(0.0))?;
        let rim_m = densest_m(&mut rim_m).ok_or_else(CalibrationError::no_rim)?;
        Ok(Opening {
            rim_m,
            floor_m,
            cells_m: hole.cells.iter().map(|cell| self.middle(*cell)).collect(),
            pitch_m: self.pitch_m,
            spacing_m: self.spacing_m,
            lean: 0.0,
        })
    }
}

impl Hole {
    /// Says whether the middle of another lies in this one: it is the same container, farther down.
    fn has(&self, other: &Self) -> bool {
        let count = other.cells.len().max(1);
        let sum = |(x, y): (usize, usize), cell: &(usize, usize)| (x + cell.0, y + cell.1);
        let (x, y) = other.cells.iter().fold((0, 0), sum);
        self.cells.contains(&(x / count, y / count))
    }
}

/// Finds the holes that cells enclose, gaps of up to two cells closed.
fn enclosed<I: Iterator<Item = (u32, u32)>>(cells: impl Fn() -> I) -> Vec<Vec<(usize, usize)>> {
    let most = cells().fold((0, 0), |most, (x, y)| (x.max(most.0), y.max(most.1)));
    let least = cells().fold(most, |least, (x, y)| (x.min(least.0), y.min(least.1)));
    // A way leads around the marks.
    const MARGIN: u32 = 2;
    let side = |least: u32, most: u32| (most - least + 1 + 2 * MARGIN) as usize;
    let mut mask = Mask::new(side(least.0, most.0), side(least.1, most.1));
    for (x, y) in cells() {
        let [x, y] = [x - least.0, y - least.1].map(|at| (at + MARGIN) as usize);
        mask.set(x, y);
    }
    let mut holes = mask.grown().holes();
    for (x, y) in holes.iter_mut().flatten() {
        *x = (*x + least.0 as usize).saturating_sub(MARGIN as usize);
        *y = (*y + least.1 as usize).saturating_sub(MARGIN as usize);
    }
    holes
}

/// Gives the distance of neighbouring points on level surfaces, in metres.
fn spacing_m(points_m: &[Point3<f64>], corner: &Point2<f64>) -> Result<f64, CalibrationError> {
    let squares = (2.0 * REACH_M / DENSITY_SQUARE_M) as usize + 1;
    let mut counts = vec![0_u32; squares * squares];
    for point in points_m {
        let square = (point.xy() - corner) / DENSITY_SQUARE_M;
        if square.x >= 0.0 && square.y >= 0.0 && square.y < squares as f64 {
            let index = square.x as usize * squares + square.y as usize;
            if let Some(count) = counts.get_mut(index) {
                *count += 1;
            }
        }
    }
    let occupied = counts.iter().filter(|count| **count > 0);
    let mut occupied: Vec<f64> = occupied.map(|count| f64::from(*count)).collect();
    let spacing_m = DENSITY_SQUARE_M / median(&mut occupied).max(1e-6).sqrt();
    if spacing_m > WIDEST_SPACING_M {
        return Err(CalibrationError::new(format_args!(
            "points are {spacing_m:.4} m apart where 0.007 m is too coarse to see a rim"
        )));
    }
    Ok(spacing_m)
}

/// Gives the mean of the heights about the level where they are densest; `None` of no heights.
fn densest_m(heights_m: &mut [f64]) -> Option<f64> {
    heights_m.sort_by(f64::total_cmp);
    let mut best: (usize, &[f64]) = (0, &[]);
    for (first, lowest_m) in heights_m.iter().enumerate() {
        let end = heights_m.partition_point(|height_m| *height_m <= lowest_m + LEVEL_M);
        if end - first > best.0 {
            best = (end - first, heights_m.get(first..end).unwrap_or(&[]));
        }
    }
    let (count, heights_m) = best;
    (count > 0).then(|| heights_m.iter().sum::<f64>() / count as f64)
}
