//! Slow, plain references for the fast kernels: voxels and brute force, as the definitions are written.
//!
//! For tests, and for whoever wants to check the engine. Nothing else uses them.

use nalgebra::Point2;

use crate::distance::{DISTANCE_STEP_M, DISTANCE_TRUNCATION};
use crate::grid::{Grid, Units};
use crate::heightmap::Heightmap;
use crate::item::{ABSENT, ItemView};
use crate::objective::{Heuristic, Weights};
use crate::placement::Placement;

/// Slack when a distance is rounded up to a whole step.
const ROUNDING_SLACK: f64 = 1e-6;

/// An item's footprint cells in the container: cell indices, lower and upper surface, in units.
fn columns(
    view: &ItemView,
    at: Placement,
    height: Units,
) -> impl Iterator<Item = (usize, usize, i32, i32)> {
    let height = i32::from(height);
    let cells = view.top().iter().zip(view.bottom()).enumerate();
    cells
        .filter(|(_, (_, bottom))| **bottom != ABSENT)
        .map(move |(index, (top, bottom))| {
            let (x, y) = (at.x + index / view.ny(), at.y + index % view.ny());
            (x, y, height + i32::from(*bottom), height + i32::from(*top))
        })
}

/// The content's height at a cell that may lie outside, where the wall is.
fn content(heightmap: &Heightmap, x: i64, y: i64) -> i32 {
    let inside = usize::try_from(x).ok().zip(usize::try_from(y).ok());
    inside
        .and_then(|(x, y)| heightmap.get(x, y))
        .map_or(i32::MAX, i32::from)
}

/// Resting height: the lowest from which the item can be lifted straight up without touching content.
///
/// `None` where the footprint leaves the container.
pub fn resting_height(heightmap: &Heightmap, view: &ItemView, at: Placement) -> Option<Units> {
    if at.x + view.nx() > heightmap.nx() || at.y + view.ny() > heightmap.ny() {
        return None;
    }
    (0..=heightmap.max()).find(|height| {
        columns(view, at, *height)
            .all(|(x, y, lowest, _)| lowest >= content(heightmap, x as i64, y as i64))
    })
}

/// `D` of the voxel above cell `(x, y)` whose lower face is at `z` units: the Chebyshev distance to the nearest voxel
/// of content, wall or floor, in steps, rounded up and truncated.
pub fn distance(grid: &Grid, heightmap: &Heightmap, x: usize, y: usize, z: i32) -> u32 {
    let (cell_m, unit_m) = (
        grid.resolution().cell_m(),
        grid.resolution().height_unit_m(),
    );
    let reach = (DISTANCE_STEP_M * DISTANCE_TRUNCATION as f64 / cell_m).ceil() as i64 + 1;
    let mut nearest = DISTANCE_TRUNCATION as u32;
    for dx in -reach..=reach {
        for dy in -reach..=reach {
            let height = content(heightmap, x as i64 + dx, y as i64 + dy);
            // The nearest voxel of that column: beside this one, or the content's uppermost, one below its height.
            let below = if z < height { 0 } else { z - height + 1 };
            let across_m = dx.abs().max(dy.abs()) as f64 * cell_m;
            let steps = across_m.max(f64::from(below) * unit_m) / DISTANCE_STEP_M;
            nearest = nearest.min((steps - ROUNDING_SLACK).ceil().max(1.0) as u32);
        }
    }
    nearest
}

/// The mean of `D` over the item's voxels.
pub fn mean_distance(
    grid: &Grid,
    heightmap: &Heightmap,
    view: &ItemView,
    at: Placement,
    height: Units,
) -> f64 {
    let sum: u64 = columns(view, at, height)
        .flat_map(|(x, y, lowest, highest)| {
            (lowest..highest).map(move |z| u64::from(distance(grid, heightmap, x, y, z)))
        })
        .sum();
    sum as f64 / view.voxel_count() as f64
}

/// The same column by column, for items too tall to be counted voxel by voxel: below the floor's and the content's
/// reach voxel by voxel, above it all voxels are equally far from the walls alone.
pub fn mean_distance_by_column(
    grid: &Grid,
    heightmap: &Heightmap,
    view: &ItemView,
    at: Placement,
    height: Units,
) -> f64 {
    let reach = grid
        .resolution()
        .units_above(DISTANCE_STEP_M * DISTANCE_TRUNCATION as f64);
    let far = i32::from(heightmap.max()) + i32::from(reach) + 1;
    let sum: u64 = columns(view, at, height)
        .map(|(x, y, lowest, highest)| {
            let near: u64 = (lowest..highest.min(far))
                .map(|z| u64::from(distance(grid, heightmap, x, y, z)))
                .sum();
            let above = (highest - lowest.max(far)).max(0) as u64;
            near + above * u64::from(distance(grid, heightmap, x, y, far))
        })
        .sum();
    sum as f64 / view.voxel_count() as f64
}

/// The value of an objective as defined, with the balance term where `balanced`.
///
/// First-fit and random have no value of their own; they give 0.
pub fn value(
    grid: &Grid,
    heightmap: &Heightmap,
    view: &ItemView,
    (at, height): (Placement, Units),
    (heuristic, weights, balanced): (Heuristic, &Weights, bool),
) -> f64 {
    let unit = grid.resolution().height_unit_m() / 0.002;
    let cell_cm = grid.resolution().cell_m() * 100.0;
    let resting = weights.resting_height * f64::from(height) * unit;
    let corner = weights.corner * (at.x + at.y) as f64 * cell_cm;
    let voxels = view.voxel_count() as f64;
    let share = |of: f64| 1.0 - (voxels / of).cbrt();
    let balance = if balanced {
        weights.balance * share(grid.voxel_count())
    } else {
        0.0
    };
    match heuristic {
        Heuristic::Sdfm => {
            let distance = weights.distance * mean_distance(grid, heightmap, view, at, height);
            let compact = weights.box_share * share(view.box_voxel_count() as f64);
            resting + distance + compact + balance
        }
        Heuristic::Dbl => resting + corner + balance,
        Heuristic::Hm => {
            let mut after = heightmap.clone();
            for (x, y, _, highest) in columns(view, at, height) {
                after.raise(x, y, highest as Units);
            }
            let rectangle: f64 = (at.x..at.x + view.nx())
                .flat_map(|x| (at.y..at.y + view.ny()).map(move |y| (x, y)))
                .filter_map(|(x, y)| after.get(x, y))
                .map(f64::from)
                .sum();
            weights.surface_volume * rectangle * unit * cell_cm * cell_cm + corner + balance
        }
        Heuristic::Mta => {
            let area = touching_area_cm2(grid, heightmap, view, at, height);
            balance - weights.touching_area * area
        }
        Heuristic::FirstFit | Heuristic::Random => 0.0,
    }
}

/// The area of the item's faces that touch content, walls or floor, in square centimetres, voxel by voxel.
fn touching_area_cm2(
    grid: &Grid,
    heightmap: &Heightmap,
    view: &ItemView,
    at: Placement,
    height: Units,
) -> f64 {
    let cell_cm = grid.resolution().cell_m() * 100.0;
    let unit_cm = grid.resolution().height_unit_m() * 100.0;
    let mut area = 0.0;
    for (x, y, lowest, highest) in columns(view, at, height) {
        for z in lowest..highest {
            let (x, y) = (x as i64, y as i64);
            let below_is_full = z == 0 || z - 1 < content(heightmap, x, y);
            area += if below_is_full {
                cell_cm * cell_cm
            } else {
                0.0
            };
            for (x, y) in [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)] {
                area += if z < content(heightmap, x, y) {
                    cell_cm * unit_cm
                } else {
                    0.0
                };
            }
        }
    }
    area
}

/// How far the item's centre lies inside the hull of the published test's contacts, in cells: the least distance to
/// a line through two contacts that has all contacts on one side. Minus infinity where the hull has no area.
pub fn published_depth_cells(
    grid: &Grid,
    heightmap: &Heightmap,
    view: &ItemView,
    at: Placement,
    height: Units,
) -> f64 {
    let contact = i32::from(grid.resolution().units_below(0.01));
    let resting = i32::from(height);
    let contacts: Vec<Point2<f64>> = columns(view, at, 0)
        .filter(|(x, y, bottom, top)| {
            let below = content(heightmap, *x as i64, *y as i64);
            if resting <= contact {
                *bottom < contact
            } else {
                *bottom < contact.min(*top) && below > resting - contact - 1 + bottom
            }
        })
        .map(|(x, y, ..)| Point2::new((x - at.x) as f64 + 0.5, (y - at.y) as f64 + 0.5))
        .collect();
    let centre = view.centroid_cells();
    let mut depth = f64::INFINITY;
    let mut has_area = false;
    for a in &contacts {
        for b in &contacts {
            let along = b - a;
            let side = |point: &Point2<f64>| along.perp(&(point - a));
            if along.norm() == 0.0 {
                continue;
            }
            has_area |= contacts.iter().any(|point| side(point) != 0.0);
            if contacts.iter().all(|point| side(point) >= 0.0) {
                depth = depth.min(side(&centre) / along.norm());
            }
        }
    }
    if has_area { depth } else { f64::NEG_INFINITY }
}
