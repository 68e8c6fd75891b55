//! Slow, plain references for the fast kernels: brute force, as the definitions are written.

use nalgebra::Point2;
use ppnpack_packing::kernel::distance::{DISTANCE_STEP_M, DISTANCE_TRUNCATION};
use ppnpack_packing::kernel::grid::{Grid, Units};
use ppnpack_packing::kernel::heightmap::{Heightmap, Surface};
use ppnpack_packing::kernel::item::ItemView;
use ppnpack_packing::kernel::objective::{Heuristic, Weights};
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};

/// Slack when a distance is rounded up to a whole step.
const ROUNDING_SLACK: f64 = 1e-6;

/// Says what is true of an item's view placed over the content of a container.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Oracle<'a> {
    /// The container's grid.
    pub(crate) grid: &'a Grid,
    /// The container's content.
    pub(crate) heightmap: &'a Heightmap,
    /// The item at one yaw.
    pub(crate) view: &'a ItemView,
}

impl Oracle<'_> {
    /// The item's columns in the container: cell indices, lower and upper surface, in units.
    fn columns(&self, at: &RestingPlacement) -> impl Iterator<Item = (usize, usize, i32, i32)> {
        let Placement { x, y, .. } = at.placement;
        let height = i32::from(at.resting_height);
        self.view.cells().map(move |(cell_x, cell_y, bottom, top)| {
            let (lowest, highest) = (height + i32::from(bottom), height + i32::from(top));
            (x + cell_x, y + cell_y, lowest, highest)
        })
    }

    /// The content's height at a cell that may lie outside, where the wall is.
    fn content(&self, x: i64, y: i64) -> i32 {
        let inside = usize::try_from(x).ok().zip(usize::try_from(y).ok());
        let height = inside.and_then(|(x, y)| self.heightmap.get(x, y));
        height.map_or(i32::MAX, i32::from)
    }

    /// Resting height: the lowest from which the item can be lifted straight up freely.
    ///
    /// `None` where the footprint leaves the container.
    pub(crate) fn resting_height(&self, placement: Placement) -> Option<Units> {
        let Self {
            heightmap, view, ..
        } = self;
        let (end_x, end_y) = (placement.x + view.nx(), placement.y + view.ny());
        if end_x > heightmap.nx() || end_y > heightmap.ny() {
            return None;
        }
        (0..=heightmap.max()).find(|height| {
            let at = RestingPlacement {
                placement,
                resting_height: *height,
            };
            let mut columns = self.columns(&at);
            columns.all(|(x, y, lowest, _)| lowest >= self.content(x as i64, y as i64))
        })
    }

    /// `D` of the voxel above cell `(x, y)` whose lower face is at `z` units: the Chebyshev
    /// distance to the nearest voxel of content, wall or floor, in steps, rounded up and truncated.
    fn distance(&self, x: usize, y: usize, z: i32) -> u64 {
        let resolution = self.grid.resolution();
        let (cell_m, unit_m) = (resolution.cell_m(), resolution.height_unit_m());
        let reach = (DISTANCE_STEP_M * DISTANCE_TRUNCATION as f64 / cell_m).ceil() as i64 + 1;
        let mut nearest = DISTANCE_TRUNCATION as u64;
        for dx in -reach..=reach {
            for dy in -reach..=reach {
                let height = self.content(x as i64 + dx, y as i64 + dy);
                // The nearest voxel of that column: beside this one, or the content's uppermost,
                // one below its height.
                let below = if z < height { 0 } else { z - height + 1 };
                let across_m = dx.abs().max(dy.abs()) as f64 * cell_m;
                let steps = across_m.max(f64::from(below) * unit_m) / DISTANCE_STEP_M;
                nearest = nearest.min((steps - ROUNDING_SLACK).ceil().max(1.0) as u64);
            }
        }
        nearest
    }

    /// The mean of `D` over the item's voxels. Voxels beyond the reach of floor and content are all
    /// equally far from the walls alone, so tall items are counted by column there.
    pub(crate) fn mean_distance(&self, at: &RestingPlacement) -> f64 {
        let reach_m = DISTANCE_STEP_M * DISTANCE_TRUNCATION as f64;
        let reach = self.grid.resolution().units_above(reach_m);
        let far = i32::from(self.heightmap.max()) + i32::from(reach) + 1;
        let columns = self.columns(at).map(|(x, y, lowest, highest)| {
            let near = (lowest..highest.min(far)).map(|z| self.distance(x, y, z));
            let above = (highest - lowest.max(far)).max(0) as u64;
            near.sum::<u64>() + above * self.distance(x, y, far)
        });
        columns.sum::<u64>() as f64 / self.view.voxel_count() as f64
    }

    /// The value of an objective as defined, with the balance term where `balanced`.
    ///
    /// First-fit and random have no value of their own; they give 0.
    pub(crate) fn value(
        &self,
        at: &RestingPlacement,
        heuristic: Heuristic,
        weights: &Weights,
        balanced: bool,
    ) -> f64 {
        let Self {
            grid,
            heightmap,
            view,
        } = *self;
        let Placement { x, y, .. } = at.placement;
        let unit = grid.resolution().height_unit_m() / 0.002;
        let cell_cm = grid.resolution().cell_m() * 100.0;
        let resting = weights.resting_height * f64::from(at.resting_height) * unit;
        let corner = weights.corner * (x + y) as f64 * cell_cm;
        let voxels = view.voxel_count() as f64;
        let share = |of: f64| 1.0 - (voxels / of).cbrt();
        let balance = if balanced {
            weights.balance * share(grid.voxel_count())
        } else {
            0.0
        };
        match heuristic {
            Heuristic::Sdfm => {
                let distance = weights.distance * self.mean_distance(at);
                let compact = weights.box_share * share(view.box_voxel_count() as f64);
                let top = weights.top_height * f64::from(self.top_above_rest(at)) * unit;
                resting + distance + compact + top + balance
            }
            Heuristic::Dbl => resting + corner + balance,
            Heuristic::Hm => {
                let mut after = heightmap.clone();
                for (x, y, _, highest) in self.columns(at) {
                    after.raise(x, y, highest.try_into().unwrap());
                }
                let rectangle: f64 = (x..x + view.nx())
                    .flat_map(|x| (y..y + view.ny()).map(move |y| (x, y)))
                    .filter_map(|(x, y)| after.get(x, y))
                    .map(f64::from)
                    .sum();
                weights.surface_volume * rectangle * unit * cell_cm * cell_cm + corner + balance
            }
            Heuristic::Mta => balance - weights.touching_area * self.touching_area_cm2(at),
            _ => 0.0,
        }
    }

    /// How far the item's highest point lies above where it rests, in units.
    fn top_above_rest(&self, at: &RestingPlacement) -> i32 {
        let highest = self.columns(at).map(|(.., highest)| highest).max();
        highest.unwrap() - i32::from(at.resting_height)
    }

    /// The area of the item's faces that touch something, in square centimetres, by voxels.
    fn touching_area_cm2(&self, at: &RestingPlacement) -> f64 {
        let cell_cm = self.grid.resolution().cell_m() * 100.0;
        let unit_cm = self.grid.resolution().height_unit_m() * 100.0;
        let mut area = 0.0;
        for (x, y, lowest, highest) in self.columns(at) {
            let (x, y) = (x as i64, y as i64);
            for z in lowest..highest {
                if z == 0 || z - 1 < self.content(x, y) {
                    area += cell_cm * cell_cm;
                }
                for (x, y) in [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)] {
                    if z < self.content(x, y) {
                        area += cell_cm * unit_cm;
                    }
                }
            }
        }
        area
    }

    /// How far the centre lies inside the hull of the published test's contacts, in cells: the
    /// least distance to a line with all contacts on one side; minus infinity without an area.
    pub(crate) fn published_depth_cells(&self, at: &RestingPlacement) -> f64 {
        let contact = i32::from(self.grid.resolution().units_below(0.01));
        let resting = i32::from(at.resting_height);
        let Placement { x, y, .. } = at.placement;
        let cells = self.view.cells().filter(|(cell_x, cell_y, bottom, top)| {
            let (bottom, top) = (i32::from(*bottom), i32::from(*top));
            let below = self.content((x + cell_x) as i64, (y + cell_y) as i64);
            if resting <= contact {
                bottom < contact
            } else {
                bottom < contact.min(top) && below > resting - contact - 1 + bottom
            }
        });
        let middle =
            |(x, y, ..): (usize, usize, Units, Units)| Point2::new(x as f64 + 0.5, y as f64 + 0.5);
        let contacts: Vec<Point2<f64>> = cells.map(middle).collect();
        depth_in_hull(&contacts, self.view.centroid_cells())
    }

    /// As [`published_depth_cells`](Self::published_depth_cells) by the physical test, in metres:
    /// of the samples of `surface`, or of the cells where none is given.
    pub(crate) fn physical_depth_m(
        &self,
        at: Placement,
        surface: Option<&Surface>,
        contact_tolerance_m: f64,
    ) -> f64 {
        let resolution = self.grid.resolution();
        let cell_m = resolution.cell_m();
        // The middle of each sample, and the content's reach above the item on the floor.
        let mut overlaps: Vec<(Point2<f64>, f32)> = Vec::new();
        let mut add = |pitch_m: f64, x: usize, y: usize, overlap_m: f32| {
            let middle = Point2::new(x as f64 + 0.5, y as f64 + 0.5) * pitch_m;
            overlaps.push((middle, overlap_m));
        };
        if let (Some(surface), Some(underside)) = (surface, self.view.underside()) {
            let samples = underside.samples_per_cell;
            let pitch_m = cell_m / samples as f64;
            for (index, lower_m) in underside.heights_m.iter().enumerate() {
                let (x, y) = (index / underside.ny, index % underside.ny);
                let below = (at.x * samples + x) * surface.ny() + at.y * samples + y;
                let below_m = surface.heights_m().get(below).copied();
                add(pitch_m, x, y, below_m.unwrap_or(f32::NAN) - lower_m);
            }
        } else {
            let metres = |units: i32| units as f32 * resolution.height_unit_m() as f32;
            for (x, y, bottom, _) in self.view.cells() {
                let below = self.content((at.x + x) as i64, (at.y + y) as i64);
                add(cell_m, x, y, metres(below) - metres(bottom.into()));
            }
        }
        let resting_m = overlaps.iter().map(|(_, overlap_m)| *overlap_m);
        let touching_m = resting_m.fold(0.0, f32::max) - contact_tolerance_m as f32;
        let contacts = overlaps
            .iter()
            .filter(|(_, overlap_m)| *overlap_m >= touching_m);
        let contacts: Vec<Point2<f64>> = contacts.map(|(middle, _)| *middle).collect();
        depth_in_hull(&contacts, self.view.centre_of_mass_m(cell_m))
    }
}

/// The least distance of a point to a line through two contacts with all contacts on one side;
/// negative beyond one, minus infinity where the hull has no area.
fn depth_in_hull(contacts: &[Point2<f64>], point: Point2<f64>) -> f64 {
    let mut depth = f64::INFINITY;
    let mut has_area = false;
    for a in contacts {
        for b in contacts {
            let along = b - a;
            let side = |point: &Point2<f64>| along.perp(&(point - a));
            if along.norm() == 0.0 {
                continue;
            }
            has_area |= contacts.iter().any(|point| side(point) != 0.0);
            if contacts.iter().all(|point| side(point) >= 0.0) {
                depth = depth.min(side(&point) / along.norm());
            }
        }
    }
    if has_area { depth } else { f64::NEG_INFINITY }
}
