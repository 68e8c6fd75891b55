//! Figures of a scene from which its value is computed: of the surface, and of the items that wait.
//!
//! All are shares, so that they mean the same in other containers: of the rim, the floor, the
//! volume. Items give the centimetres.

use crate::kernel::grid::{Grid, Units};
use crate::kernel::heightmap::Heightmap;
use crate::kernel::item::ItemView;
use crate::kernel::placement::RestingPlacement;
use crate::ranking::step::{Candidate, StepInput};

/// Surfaces are looked at in squares of this side, in metres, each as high as its highest cell.
const SQUARE_M: f64 = 0.01;

/// Shares of the squares that lie below the heights which are figures.
const QUANTILES: [f64; 5] = [0.1, 0.25, 0.5, 0.75, 0.9];

/// Levels, in shares of the rim: how much of the floor lies below each.
const LEVELS: [f32; 8] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

/// Levels, in shares of the rim: the largest rectangle below each.
const RECTANGLE_LEVELS: [f32; 9] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

/// Sides of windows in squares: items of these sizes stand on the highest square below.
const WINDOWS: [usize; 6] = [2, 4, 6, 8, 12, 16];

/// An item of 30 % of the rim fits where the surface is lower than this.
const ROOM_BELOW: f32 = 0.7;

/// How many figures there are of a surface.
const OF_SURFACE: usize =
    3 + QUANTILES.len() + 2 + LEVELS.len() + RECTANGLE_LEVELS.len() + 5 * WINDOWS.len() + 1;
/// How many of them are of the items that wait; they come last.
pub const FIGURES_OF_ITEMS: usize = 6;

/// How many figures there are.
pub const FIGURES: usize = OF_SURFACE + FIGURES_OF_ITEMS;

/// The surface of a container in squares, in shares of the rim.
#[derive(Debug, Clone, PartialEq)]
pub struct Squares {
    nx: usize,
    ny: usize,
    /// Cells along the side of a square.
    cells: usize,
    rim: f32,
    /// Row-major; cut off at the rim.
    heights: Vec<f32>,
}

impl Squares {
    /// The surface that a heightmap shows. Cells beyond the last whole square count to that.
    pub fn of(grid: &Grid, heightmap: &Heightmap) -> Self {
        let cells = (SQUARE_M / grid.resolution().cell_m()).round().max(1.0) as usize;
        let count = |side: usize| (side / cells).max(1);
        let (nx, ny) = (count(grid.nx()), count(grid.ny()));
        let mut squares = Self {
            nx,
            ny,
            cells,
            rim: f32::from(grid.rim()).max(1.0),
            heights: vec![0.0; nx * ny],
        };
        for x in 0..heightmap.nx() {
            for (y, height) in heightmap.row(x).iter().enumerate() {
                squares.raise(x, y, *height);
            }
        }
        squares
    }

    /// The same surface with an item on it.
    #[must_use]
    pub fn with(&self, view: &ItemView, at: &RestingPlacement) -> Self {
        let mut with = self.clone();
        for (x, y, _, top) in view.cells() {
            with.raise(
                at.placement.x + x,
                at.placement.y + y,
                at.resting_height + top,
            );
        }
        with
    }

    fn raise(&mut self, x: usize, y: usize, height: Units) {
        let (x, y) = (
            (x / self.cells).min(self.nx - 1),
            (y / self.cells).min(self.ny - 1),
        );
        let height = (f32::from(height) / self.rim).min(1.0);
        if let Some(square) = self.heights.get_mut(x * self.ny + y) {
            *square = square.max(height);
        }
    }

    fn row(&self, x: usize) -> &[f32] {
        self.heights
            .get(x * self.ny..(x + 1) * self.ny)
            .unwrap_or(&[])
    }
}

/// The figures of a scene after a placement: the surface with the item on it, and what else waits.
pub fn figures(input: &StepInput<'_>, after: &Squares, chosen: usize) -> Vec<f64> {
    let mut figures = Vec::with_capacity(FIGURES);
    heights(after, &mut figures);
    unevenness(after, &mut figures);
    let count = after.heights.len() as f32;
    let below = |level: f32| {
        let below = after.heights.iter().filter(|height| **height <= level);
        below.count() as f32 / count
    };
    figures.extend(LEVELS.map(|level| f64::from(below(level))));
    let rectangle =
        |level: f32| largest_rectangle(after, level) as f64 / after.heights.len() as f64;
    figures.extend(RECTANGLE_LEVELS.map(rectangle));
    windows(after, &mut figures);
    figures.push(walls(after));
    waiting(input, chosen, &mut figures);
    figures
}

/// Mean, deviation, maximum and quantiles.
fn heights(squares: &Squares, figures: &mut Vec<f64>) {
    let mut sorted = squares.heights.clone();
    sorted.sort_unstable_by(f32::total_cmp);
    let (mean, square) = moments(&sorted);
    let deviation = (square - mean * mean).max(0.0).sqrt();
    let quantile = |share: f64| {
        let index = (share * sorted.len() as f64) as usize;
        f64::from(sorted.get(index).copied().unwrap_or(1.0))
    };
    figures.extend([mean, deviation, quantile(1.0 - f64::EPSILON)]);
    figures.extend(QUANTILES.map(quantile));
}

/// The means of some heights and of their squares.
fn moments(heights: &[f32]) -> (f64, f64) {
    let count = heights.len().max(1) as f64;
    let sums = heights.iter().fold((0.0, 0.0), |(sum, squares), height| {
        let height = f64::from(*height);
        (sum + height, squares + height * height)
    });
    (sums.0 / count, sums.1 / count)
}

/// The steps between neighbours, and the mean square of the room above.
fn unevenness(squares: &Squares, figures: &mut Vec<f64>) {
    let mut steps = 0.0;
    for x in 0..squares.nx {
        let row = squares.row(x);
        let along = row.windows(2).map(|pair| match pair {
            [a, b] => (a - b).abs(),
            _ => 0.0,
        });
        let across = row.iter().zip(squares.row(x + 1));
        steps += along.sum::<f32>() + across.map(|(a, b)| (a - b).abs()).sum::<f32>();
    }
    let room = squares.heights.iter();
    let room: f32 = room.map(|height| (1.0 - height) * (1.0 - height)).sum();
    let count = squares.heights.len() as f32;
    figures.extend([f64::from(steps / count), f64::from(room / count)]);
}

/// The squares of the largest rectangle that is nowhere above a level.
///
/// Source: the largest rectangle under a histogram, of each row's free squares above it, by a
/// stack.
fn largest_rectangle(squares: &Squares, level: f32) -> usize {
    let mut free = vec![0_usize; squares.ny];
    let mut open: Vec<(usize, usize)> = Vec::new();
    let mut largest = 0;
    for x in 0..squares.nx {
        open.clear();
        for (free, height) in free.iter_mut().zip(squares.row(x)) {
            *free = if *height <= level { *free + 1 } else { 0 };
        }
        for (y, depth) in free.iter().copied().chain([0]).enumerate() {
            let mut start = y;
            while let Some((from, open_depth)) = open.pop_if(|(_, open)| *open >= depth) {
                largest = largest.max(open_depth * (y - from));
                start = from;
            }
            open.push((start, depth));
        }
    }
    largest
}

/// Adds of greatest heights within windows: mean, minimum, range, mean room, mean square of the
/// room.
fn windows(squares: &Squares, figures: &mut Vec<f64>) {
    let mut within = squares.clone();
    let mut side = 1;
    for wanted in WINDOWS {
        let wanted = wanted.min(squares.nx).min(squares.ny);
        // Windows of the last side, moved by up to that, cover the wanted ones.
        while side < wanted {
            let further = (wanted - side).min(side);
            within = widened(&within, further);
            side += further;
        }
        let heights = &within.heights;
        let count = heights.len().max(1) as f32;
        let lowest = heights.iter().copied().fold(1.0, f32::min);
        let highest = heights.iter().copied().fold(0.0, f32::max);
        let sum =
            |of: fn(f32) -> f32| heights.iter().map(|height| of(*height)).sum::<f32>() / count;
        figures.extend(
            [
                sum(|height| height),
                lowest,
                highest - lowest,
                sum(|height| (ROOM_BELOW - height).max(0.0)),
                sum(|height| (1.0 - height) * (1.0 - height)),
            ]
            .map(f64::from),
        );
    }
}

/// The greatest heights within windows that are wider by so many squares, from narrower ones.
fn widened(narrow: &Squares, by: usize) -> Squares {
    let (nx, ny) = (narrow.nx - by, narrow.ny - by);
    let mut heights = Vec::with_capacity(nx * ny);
    for x in 0..nx {
        let (first, last) = (narrow.row(x), narrow.row(x + by));
        let further = first.iter().skip(by).zip(last.iter().skip(by));
        let corners = first.iter().zip(last).zip(further);
        let greatest = corners.map(|((a, b), (c, d))| a.max(*b).max(c.max(*d)));
        heights.extend(greatest);
    }
    Squares {
        nx,
        ny,
        heights,
        ..*narrow
    }
}

fn walls(squares: &Squares) -> f64 {
    let last_row = squares.row(squares.nx - 1);
    let ends = (0..squares.nx).flat_map(|x| {
        let row = squares.row(x);
        [row.first(), row.last()]
    });
    let along = squares.row(0).iter().chain(last_row);
    let heights: Vec<f32> = along.chain(ends.flatten()).copied().collect();
    moments(&heights).0
}

/// Adds of the items that still wait: sums of volumes, of boxes and of heights, the greatest height
/// and volume, and their number in tens.
fn waiting(input: &StepInput<'_>, chosen: usize, figures: &mut Vec<f64>) {
    let resolution = input.grid.resolution();
    let container_m3 = input.grid.container().volume_m3();
    let voxel_m3 = resolution.cell_m() * resolution.cell_m() * resolution.height_unit_m();
    let arrival = |held: &Candidate| held.arrival;
    let taken = input.candidates.get(chosen).map(arrival);
    let mut last = None;
    let mut sums = [0.0_f64; FIGURES_OF_ITEMS];
    let [volumes, boxes, heights, highest, largest, count] = &mut sums;
    for held in input.candidates {
        let is_other_pose = last.replace(held.arrival) == Some(held.arrival);
        if is_other_pose || taken == Some(held.arrival) {
            continue;
        }
        let volume = held.item.mesh_volume_m3() / container_m3;
        let height = held.item.views().first().map_or(0, ItemView::height);
        let height = f64::from(height) / f64::from(input.grid.rim()).max(1.0);
        *volumes += volume;
        *boxes += held.item.box_voxel_count() as f64 * voxel_m3 / container_m3;
        *heights += height;
        *highest = highest.max(height);
        *largest = largest.max(volume);
        *count += 0.1;
    }
    figures.extend(sums);
}
