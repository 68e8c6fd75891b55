//! Points to heights.

use nalgebra::{Isometry3, Point3};
use ppnpack_numbers::SettingError;
use ppnpack_packing::kernel::grid::{Grid, Units};
use ppnpack_packing::kernel::heightmap::{Heightmap, HeightmapError, Surface};
use ppnpack_packing::scene::Scene;

use crate::doubts::{Doubt, Watch};
use crate::holes::Holes;
use crate::layers::{NO_POINT, TopLayers, by_cell, is_known, neighbours};
use crate::raster::Raster;
use crate::settings::MapperSettings;
use crate::sight::{Sight, bound_m};
use crate::still::{History, Stillness};
use crate::walls::LeaningWalls;

/// Maximum height of points, in metres; higher ones count as this high: all the same to a
/// container, and still a number in every format.
const MAX_HEIGHT_M: f64 = 1000.0;

/// Minimum height, in metres, by which a sample that hides a part of another stands above it.
const STEP_M: f32 = 0.01;

/// Maximum share of a container that is seen above the rim; of more, it is none.
const MOST_ABOVE_RIM: f64 = 0.9;

/// Makes scenes of clouds on one grid. Keeps its memory between clouds.
#[derive(Debug, Clone)]
pub struct Mapper {
    grid: Grid,
    settings: MapperSettings,
    /// Height of what is unknown.
    unknown_m: f32,
    raster: Raster,
    layers: TopLayers,
    /// Number of points in each sample. A point nearby raises a sample, but does not show what is
    /// in it.
    points: Vec<u16>,
    /// Heights of the surface's samples, row-major.
    samples_m: Vec<f32>,
    /// Whether a sample's height is a bound, per sample.
    is_bound: Vec<bool>,
    /// Heights of cells, row-major.
    cells_m: Vec<f32>,
    /// Rays of each sensor that is above the rim.
    sights: Vec<Sight>,
    holes: Holes,
    tally: Tally,
    watch: Watch,
    history: History,
    /// Of a container that is no box.
    walls: Option<LeaningWalls>,
}

/// Counts of points by what became of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Points with three finite coordinates.
    pub measured: u64,
    /// Points within the container's walls, seen from above.
    pub inside: u64,
    /// Points within the walls that stood by themselves and were left out.
    pub alone: u64,
}

/// The scene that clouds show.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Mapped {
    /// The container's content: the surface, and its heightmap.
    pub scene: Scene,
    /// Counts of the points.
    pub tally: Tally,
    /// Cells that count as higher than the rim because no line of sight passes over a part of them.
    pub unknown_cells: usize,
    /// Samples of the surface that no point was seen of, filled ones included.
    pub unseen_samples: usize,
    /// Number of the latest clouds that the scene is made of; several sensors count as one.
    pub clouds: usize,
    /// Cells in which something moved since the clouds before; see
    /// [`StillSettings`](crate::still::StillSettings).
    pub moved_cells: usize,
    /// Reasons not to plan on the scene; empty where it can be trusted.
    pub doubts: Vec<Doubt>,
}

impl Mapper {
    /// Makes a mapper for a grid.
    pub fn new(grid: &Grid, settings: MapperSettings) -> Result<Self, SettingError> {
        settings.validate_on(grid)?;
        let raster = Raster::new(grid, &settings);
        let (cells, samples) = (grid.nx() * grid.ny(), raster.nx * raster.ny);
        let pitch_m = grid.resolution().surface_pitch_m();
        let (noise_m, least_points) = (settings.noise_m, settings.least_points);
        Ok(Self {
            grid: grid.clone(),
            unknown_m: above_rim_m(grid),
            raster,
            layers: TopLayers::new(samples, raster.ny, pitch_m, noise_m, least_points),
            watch: Watch::new(grid.container(), settings.doubts.clone()),
            history: History::new(grid, settings.noise_m, settings.still.clone()),
            walls: LeaningWalls::of(grid, settings.wall_margin_m),
            settings,
            points: vec![0; samples],
            samples_m: vec![NO_POINT; samples],
            is_bound: vec![false; samples],
            sights: Vec::new(),
            cells_m: vec![NO_POINT; cells],
            holes: Holes::default(),
            tally: Tally::default(),
        })
    }

    /// Gives the grid that clouds are mapped on.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Maps one cloud: [`clear`](Self::clear), [`add`](Self::add) and [`finish`](Self::finish).
    pub fn map(
        &mut self,
        points_m: impl IntoIterator<Item = Point3<f32>>,
        container_from_sensor: &Isometry3<f64>,
    ) -> Result<Mapped, HeightmapError> {
        self.clear();
        self.add(points_m, container_from_sensor);
        self.finish()
    }

    /// Tells the mapper that the scene was changed: clouds of it before that are not blended with
    /// those that follow.
    pub fn changed(&mut self) {
        self.history.clear();
    }

    /// Forgets all points. The heights of the clouds before stay, for as many as are blended.
    pub fn clear(&mut self) {
        self.watch.clear();
        self.samples_m.fill(NO_POINT);
        self.layers.clear();
        self.points.fill(0);
        self.sights.clear();
        self.tally = Tally::default();
    }

    /// Takes the points of a sensor in, given in metres in its frame. Points with a coordinate that
    /// is not finite are left out. Several sensors see one scene together. A sensor stands at the
    /// origin of its frame; where that is above the rim, its lines of sight bound what it does not
    /// see.
    pub fn add(
        &mut self,
        points_m: impl IntoIterator<Item = Point3<f32>>,
        container_from_sensor: &Isometry3<f64>,
    ) {
        let (raster, container) = (self.raster, self.grid.container());
        let margin_m = self.settings.wall_margin_m;
        let [x_range, y_range] =
            [container.x_m, container.y_m].map(|side_m| margin_m..=side_m - margin_m);
        let lowest_m = -self.settings.floor_tolerance_m;
        let rotation = container_from_sensor.rotation.to_rotation_matrix();
        let translation = container_from_sensor.translation.vector;
        let pitch_m = self.grid.resolution().surface_pitch_m();
        let noise_m = self.settings.noise_m;
        let mut sight = Sight::new(container, translation.into(), pitch_m, noise_m, margin_m);
        for point in points_m {
            let point = rotation * point.cast::<f64>() + translation;
            // One coordinate that is not finite makes all three so.
            self.tally.measured += u64::from(point.z.is_finite());
            self.watch.look(&point);
            if let Some(sight) = &mut sight {
                sight.add(&point);
            }
            let is_inside = x_range.contains(&point.x) && y_range.contains(&point.y);
            if !(is_inside && point.z >= lowest_m && point.z.is_finite()) {
                continue;
            }
            self.tally.inside += 1;
            let height_m = point.z.clamp(0.0, MAX_HEIGHT_M) as f32;
            let seen = raster.sample_at(point.x, point.y);
            if let Some(points) = seen.and_then(|sample| self.points.get_mut(sample)) {
                *points = points.saturating_add(1);
            }
            let wall = self.walls.as_ref().filter(|walls| walls.show_at(&point));
            for sample in raster.samples_near(point.x, point.y) {
                let height_m = wall.map_or(height_m, |wall| wall.height_m(sample));
                if noise_m > 0.0 {
                    self.layers.add(sample, height_m);
                } else if let Some(sample_m) = self.samples_m.get_mut(sample) {
                    *sample_m = sample_m.max(height_m);
                }
            }
        }
        if let Some(mut sight) = sight {
            sight.close();
            self.sights.push(sight);
        }
    }

    /// Makes the scene that the points show.
    ///
    /// A sample's height is that of the highest points in its square. A narrow hole among level
    /// samples is filled, and what lies at a wall within its margin is as high as what is beside
    /// it. A sample that stays unseen is at most as high as the lines of sight leave open. Without
    /// any, it takes the height of its cell, the highest of the cell's samples, or counts as higher
    /// than the rim where nothing of the cell was seen.
    pub fn finish(&mut self) -> Result<Mapped, HeightmapError> {
        if self.settings.noise_m > 0.0 {
            self.tally.alone = self.layers.heights(&mut self.samples_m);
        }
        for (sample_m, points) in self.samples_m.iter_mut().zip(&self.points) {
            if *points == 0 {
                *sample_m = NO_POINT;
            }
        }
        let cells_m = self.history.cells_of(&self.samples_m);
        self.hide_beside_steps();
        let stillness = self.history.blend(&mut self.samples_m, cells_m);
        let is_unseen = |sample_m: &&f32| !is_known(**sample_m);
        let unseen_samples = self.samples_m.iter().filter(is_unseen).count();
        self.is_bound.fill(false);
        self.fill_margins();
        self.fill_holes();
        self.bound_unseen();
        if let Some(walls) = &self.walls {
            walls.fill_margins(&mut self.samples_m, self.raster);
        }
        let cells = self.raise_cells();
        self.fill_samples();
        Ok(Mapped {
            scene: self.scene()?,
            tally: self.tally,
            unknown_cells: cells.unknown,
            unseen_samples,
            clouds: stillness.clouds,
            moved_cells: stillness.moved_cells,
            doubts: self.doubts(cells, stillness),
        })
    }

    fn doubts(&self, cells: Cells, stillness: Stillness) -> Vec<Doubt> {
        let all = self.cells_m.len();
        let least_seen = self.settings.doubts.least_seen_share * all as f64;
        let little_seen = Doubt::LittleSeen {
            seen_cells: cells.seen,
            cells: all,
        };
        let not_still = Doubt::NotStill {
            moved_cells: stillness.moved_cells,
            clouds: stillness.clouds,
            needed: stillness.needed,
        };
        let is_all_above = cells.above_rim as f64 > MOST_ABOVE_RIM * cells.seen as f64;
        let above_rim = Doubt::AboveRim {
            above_cells: cells.above_rim,
            seen_cells: cells.seen,
        };
        let mut doubts = Vec::new();
        doubts.extend(((cells.seen as f64) < least_seen).then_some(little_seen));
        doubts.extend((is_all_above && cells.seen > 0).then_some(above_rim));
        doubts.extend(self.watch.doubts());
        doubts.extend((!stillness.is_still()).then_some(not_still));
        doubts
    }

    /// Takes samples for hidden that lie below a step and hold fewer points than half of what a
    /// sensor has of others, where there are lines of sight to bound them: noise carries points
    /// across an edge, and a part of them is hidden.
    fn hide_beside_steps(&mut self) {
        if self.sights.is_empty() || self.settings.noise_m == 0.0 {
            return;
        }
        let counts = self.points.iter().map(|points| u64::from(*points));
        let seen = counts.clone().filter(|points| *points > 0).count().max(1);
        let sum: u64 = counts.sum();
        let few = 0.5 * sum as f64 / (seen * self.sights.len()) as f64;
        let samples_m = &self.samples_m;
        let is_hidden = |(sample_m, (sample, points)): (&f32, (usize, &u16))| {
            let is_sparse = *points > 0 && f64::from(*points) < few;
            let mut around = neighbours(sample, samples_m.len(), self.raster.ny);
            let step_m = sample_m + STEP_M;
            let is_step = |near: &f32| *near > step_m;
            is_sparse && around.any(|near| samples_m.get(near).is_some_and(is_step))
        };
        let samples = samples_m.iter().zip(self.points.iter().enumerate());
        let are_hidden: Vec<bool> = samples.map(is_hidden).collect();
        for (sample_m, is_hidden) in self.samples_m.iter_mut().zip(are_hidden) {
            if is_hidden {
                *sample_m = NO_POINT;
            }
        }
    }

    /// Gives unseen samples at the walls, whose points are left out, what the nearest sample beyond
    /// the margin has.
    fn fill_margins(&mut self) {
        for sample in 0..self.samples_m.len() {
            let near = self.raster.beyond_margin(sample);
            if near == sample {
                continue;
            }
            let height_m = self.samples_m.get(near).copied().unwrap_or(NO_POINT);
            let is_bound = self.is_bound.get(near).copied().unwrap_or(false);
            if let (Some(sample_m), Some(is_bound_here)) = (
                self.samples_m.get_mut(sample),
                self.is_bound.get_mut(sample),
            ) && !is_known(*sample_m)
            {
                (*sample_m, *is_bound_here) = (height_m, is_bound);
            }
        }
    }

    /// Bounds what no point was seen of by the lines of sight, where there are any.
    fn bound_unseen(&mut self) {
        if self.sights.is_empty() {
            return;
        }
        let (raster, rim_m) = (self.raster, self.grid.container().z_m);
        let heights = self.samples_m.iter_mut().zip(&mut self.is_bound);
        for (sample, (sample_m, is_bound)) in heights.enumerate() {
            if is_known(*sample_m) || raster.beyond_margin(sample) != sample {
                continue;
            }
            let bound_m = bound_m(&self.sights, raster.middle(sample), rim_m);
            *is_bound = true;
            *sample_m = if bound_m < rim_m {
                bound_m as f32
            } else {
                self.unknown_m
            };
        }
        self.fill_margins();
    }

    fn fill_holes(&mut self) {
        let pitch_m = self.grid.resolution().surface_pitch_m();
        let samples = (self.settings.largest_hole_m / pitch_m + 1e-6) as usize;
        if samples > 0 {
            let level_m = self.settings.level_m as f32;
            let ny = self.raster.ny;
            self.holes.fill(&mut self.samples_m, ny, samples, level_m);
        }
    }

    /// Gives each cell the highest of its samples, or a height above the rim where none is known.
    fn raise_cells(&mut self) -> Cells {
        let (per_cell, ny) = (self.grid.resolution().samples_per_cell(), self.grid.ny());
        let mut is_seen = vec![false; self.cells_m.len()];
        self.cells_m.fill(NO_POINT);
        let rows = by_cell(&self.samples_m, per_cell, ny);
        for ((cell, row), (_, bounds)) in rows.zip(by_cell(&self.is_bound, per_cell, ny)) {
            if let (Some(cell_m), Some(is_seen)) =
                (self.cells_m.get_mut(cell), is_seen.get_mut(cell))
            {
                *cell_m = row.iter().copied().fold(*cell_m, f32::max);
                let mut samples = row.iter().zip(bounds);
                *is_seen |= samples.any(|(sample_m, is_bound)| is_known(*sample_m) && !is_bound);
            }
        }
        let mut cells = Cells::default();
        for (cell_m, is_seen) in self.cells_m.iter_mut().zip(is_seen) {
            if !is_known(*cell_m) {
                *cell_m = self.unknown_m;
            }
            cells.unknown += usize::from(*cell_m == self.unknown_m);
            cells.seen += usize::from(is_seen);
            cells.above_rim += usize::from(is_seen && *cell_m > self.unknown_m);
        }
        cells
    }

    /// Gives samples without a height that of their cell.
    fn fill_samples(&mut self) {
        let (per_cell, ny) = (self.grid.resolution().samples_per_cell(), self.grid.ny());
        let blocks = self.samples_m.chunks_exact_mut(per_cell * per_cell * ny);
        for (cells, block) in self.cells_m.chunks_exact(ny).zip(blocks) {
            for row in block.chunks_exact_mut(per_cell * ny) {
                for (cell_m, chunk) in cells.iter().zip(row.chunks_exact_mut(per_cell)) {
                    for sample_m in chunk.iter_mut().filter(|sample_m| !is_known(**sample_m)) {
                        *sample_m = *cell_m;
                    }
                }
            }
        }
    }

    fn scene(&self) -> Result<Scene, HeightmapError> {
        let (Raster { nx, ny, .. }, mut samples_m) = (self.raster, self.samples_m.clone());
        let support = samples_m.iter().zip(&self.is_bound);
        let support = support.map(|(sample_m, is_bound)| if *is_bound { 0.0 } else { *sample_m });
        let mut support_m: Vec<f32> = support.collect();
        let heights = self.cells_m.iter().map(|cell_m| self.units(*cell_m));
        let mut heights: Vec<Units> = heights.collect();
        if let Some(walls) = &self.walls {
            walls.raise([&mut samples_m, &mut support_m], &mut heights);
        }
        let pitch_m = self.grid.resolution().surface_pitch_m();
        let surface = Surface::from_metres(nx, ny, pitch_m, samples_m)?;
        let surface = surface.with_support(support_m)?;
        let heightmap = Heightmap::from_units(self.grid.nx(), self.grid.ny(), heights)?;
        Scene::new(&self.grid, heightmap, Some(surface))
    }

    /// Gives the height of a cell in units, less the noise: its highest sample is a little too
    /// high, and is rounded up.
    fn units(&self, cell_m: f32) -> Units {
        let is_known = cell_m < self.unknown_m;
        let excess_m = if is_known { self.settings.noise_m } else { 0.0 };
        let height_m = (f64::from(cell_m) - excess_m).max(0.0);
        self.grid.resolution().units_above(height_m)
    }
}

/// Counts of a grid's cells.
#[derive(Debug, Clone, Copy, Default)]
struct Cells {
    /// Cells of which some sample was seen.
    seen: usize,
    /// Cells among those seen that are higher than the rim.
    above_rim: usize,
    /// Cells of which some sample may be higher than the rim.
    unknown: usize,
}

/// Gives a height above the rim that is the first unit above it.
fn above_rim_m(grid: &Grid) -> f32 {
    let unit_m = grid.resolution().height_unit_m();
    // Halfway, so that rounding does not reach the rim or the unit's end.
    let next_m = (f64::from(grid.rim()) + 1.0) * unit_m;
    (0.5 * (grid.container().z_m + next_m)) as f32
}
