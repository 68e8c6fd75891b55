//! Points to heights.

use nalgebra::{Isometry3, Point3};
use ppnpack_numbers::SettingError;
use ppnpack_packing::grid::{Grid, Units};
use ppnpack_packing::heightmap::{Heightmap, HeightmapError, Scene, Surface};

use crate::doubts::{Doubt, Watch};
use crate::holes::{Fillable, Holes};
use crate::layers::{NO_POINT, TopLayers, by_cell, is_known};
use crate::settings::MapperSettings;
use crate::still::{History, Stillness};

/// Points higher than this count as this high: all the same to a container, and still a number in every format.
const MAX_HEIGHT_M: f64 = 1000.0;

/// Makes scenes of clouds on one grid. Keeps its memory between clouds.
#[derive(Debug, Clone)]
pub struct Mapper {
    grid: Grid,
    settings: MapperSettings,
    /// How high what is unknown counts.
    unknown_m: f32,
    layers: TopLayers,
    /// Whether a point lies in a sample, per sample. A point nearby raises a sample, but does not show what is in it.
    is_seen: Vec<bool>,
    /// Per sample of the surface, row-major.
    samples_m: Vec<f32>,
    /// Per cell, row-major.
    cells_m: Vec<f32>,
    holes: Holes,
    tally: Tally,
    watch: Watch,
    history: History,
}

/// What became of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Points with three finite coordinates.
    pub measured: u64,
    /// Points within the container's walls, seen from above.
    pub inside: u64,
    /// Points within the walls that stood by themselves and were left out.
    pub alone: u64,
}

/// What clouds show.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Mapped {
    /// The container's content: the surface, and its heightmap.
    pub scene: Scene,
    /// What became of the points.
    pub tally: Tally,
    /// Cells that count as higher than the rim because too little is known of them.
    pub unknown_cells: usize,
    /// Samples of the surface that no point was seen of, filled ones included.
    pub unseen_samples: usize,
    /// How many of the latest clouds the scene is made of; several sensors count as one.
    pub clouds: usize,
    /// Cells in which something moved since the clouds before; see [`StillSettings`](crate::still::StillSettings).
    pub moved_cells: usize,
    /// Why nothing is to be planned on the scene; empty where it can be trusted.
    pub doubts: Vec<Doubt>,
}

impl Mapper {
    /// A mapper for a grid.
    ///
    /// # Errors
    /// [`SettingError`] where a setting is impossible.
    pub fn new(grid: &Grid, settings: MapperSettings) -> Result<Self, SettingError> {
        settings.validate_on(grid)?;
        let per_cell = grid.resolution().samples_per_cell();
        let cells = grid.nx() * grid.ny();
        let samples = cells * per_cell * per_cell;
        Ok(Self {
            grid: grid.clone(),
            unknown_m: above_rim_m(grid),
            layers: TopLayers::new(
                samples,
                grid.ny() * per_cell,
                grid.resolution().surface_pitch_m(),
                settings.noise_m,
                settings.least_points,
            ),
            watch: Watch::new(grid.container(), settings.doubts.clone()),
            history: History::new(
                grid.ny(),
                per_cell,
                settings.noise_m,
                settings.still.clone(),
            ),
            settings,
            is_seen: vec![false; samples],
            samples_m: vec![NO_POINT; samples],
            cells_m: vec![NO_POINT; cells],
            holes: Holes::default(),
            tally: Tally::default(),
        })
    }

    /// The grid that clouds are mapped on.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The scene that one cloud shows: [`clear`](Self::clear), [`add`](Self::add) and [`finish`](Self::finish).
    ///
    /// # Errors
    /// None in practice: heights are finite, and as many as the grid needs.
    pub fn map(
        &mut self,
        points_m: impl IntoIterator<Item = Point3<f32>>,
        container_from_sensor: &Isometry3<f64>,
    ) -> Result<Mapped, HeightmapError> {
        self.clear();
        self.add(points_m, container_from_sensor);
        self.finish()
    }

    /// Tells that the scene was changed: clouds of it before that are not blended with those that follow.
    pub fn changed(&mut self) {
        self.history.clear();
    }

    /// Forgets all points. The heights of the clouds before stay, for as many as are blended.
    pub fn clear(&mut self) {
        self.watch.clear();
        self.samples_m.fill(NO_POINT);
        self.layers.clear();
        self.is_seen.fill(false);
        self.tally = Tally::default();
    }

    /// Takes the points of a sensor in, given in metres in its frame. Points with a coordinate that is not finite are
    /// left out. Several sensors see one scene together.
    pub fn add(
        &mut self,
        points_m: impl IntoIterator<Item = Point3<f32>>,
        container_from_sensor: &Isometry3<f64>,
    ) {
        let raster = Raster::new(&self.grid, self.settings.point_radius_m);
        let container = self.grid.container();
        let margin_m = self.settings.wall_margin_m;
        let (x_range, y_range) = (
            margin_m..=container.x_m - margin_m,
            margin_m..=container.y_m - margin_m,
        );
        let lowest_m = -self.settings.floor_tolerance_m;
        let is_noisy = self.settings.noise_m > 0.0;
        let is_watched = self.watch.is_needed();
        let rotation = container_from_sensor.rotation.to_rotation_matrix();
        let translation = container_from_sensor.translation.vector;
        for point in points_m {
            let point = rotation * point.cast::<f64>() + translation;
            // One coordinate that is not finite makes all three so.
            self.tally.measured += u64::from(point.z.is_finite());
            if is_watched {
                self.watch.look(&point);
            }
            if !(x_range.contains(&point.x) && y_range.contains(&point.y)) {
                continue;
            }
            if !(point.z >= lowest_m && point.z.is_finite()) {
                continue;
            }
            self.tally.inside += 1;
            let height_m = point.z.clamp(0.0, MAX_HEIGHT_M) as f32;
            let seen = raster.sample_at(point.x, point.y);
            if let Some(is_seen) = seen.and_then(|sample| self.is_seen.get_mut(sample)) {
                *is_seen = true;
            }
            for sample in raster.samples_near(point.x, point.y) {
                if is_noisy {
                    self.layers.add(sample, height_m);
                } else if let Some(sample_m) = self.samples_m.get_mut(sample) {
                    *sample_m = sample_m.max(height_m);
                }
            }
        }
    }

    /// The scene that the points show.
    ///
    /// A sample's height is that of the highest points in its square. A narrow hole among level samples is filled. A
    /// sample that stays unseen takes the height of its cell, the highest of the cell's samples, or counts as higher
    /// than the rim where too little of the cell was seen.
    ///
    /// # Errors
    /// None in practice: heights are finite, and as many as the grid needs.
    pub fn finish(&mut self) -> Result<Mapped, HeightmapError> {
        if self.settings.noise_m > 0.0 {
            self.tally.alone = self.layers.heights(&mut self.samples_m);
        }
        for (sample_m, is_seen) in self.samples_m.iter_mut().zip(&self.is_seen) {
            if !is_seen {
                *sample_m = NO_POINT;
            }
        }
        let stillness = self.history.blend(&mut self.samples_m);
        let is_unseen = |sample_m: &&f32| !is_known(**sample_m);
        let unseen_samples = self.samples_m.iter().filter(is_unseen).count();
        self.fill_holes();
        let unknown_cells = self.raise_cells();
        self.fill_samples();
        Ok(Mapped {
            scene: self.scene()?,
            tally: self.tally,
            unknown_cells,
            unseen_samples,
            clouds: stillness.clouds,
            moved_cells: stillness.moved_cells,
            doubts: self.doubts(unknown_cells, stillness),
        })
    }

    fn doubts(&self, unknown_cells: usize, stillness: Stillness) -> Vec<Doubt> {
        let cells = self.cells_m.len();
        let known_cells = cells - unknown_cells;
        let least_known = self.settings.doubts.least_known_share * cells as f64;
        let little_seen = Doubt::LittleSeen { known_cells, cells };
        let not_still = Doubt::NotStill {
            moved_cells: stillness.moved_cells,
            clouds: stillness.clouds,
            needed: stillness.needed,
        };
        let mut doubts = Vec::new();
        doubts.extend(((known_cells as f64) < least_known).then_some(little_seen));
        doubts.extend(self.watch.doubts());
        doubts.extend((!stillness.is_still()).then_some(not_still));
        doubts
    }

    fn fill_holes(&mut self) {
        let resolution = self.grid.resolution();
        let samples = (self.settings.largest_hole_m / resolution.surface_pitch_m() + 1e-6) as usize;
        if samples > 0 {
            let ny = self.grid.ny() * resolution.samples_per_cell();
            let fillable = Fillable {
                samples,
                level_m: self.settings.level_m as f32,
            };
            self.holes.fill(&mut self.samples_m, ny, fillable);
        }
    }

    /// Gives each cell the highest of its samples, or a height above the rim where too few are known; counts those.
    fn raise_cells(&mut self) -> usize {
        let (per_cell, ny) = (self.grid.resolution().samples_per_cell(), self.grid.ny());
        let in_cell = per_cell * per_cell;
        let largest_unseen = (self.settings.largest_unseen_share * in_cell as f64) as usize;
        // Where a single point is enough, it is needed all the same.
        let least_known = in_cell.saturating_sub(largest_unseen).max(1);
        let mut known = vec![0; self.cells_m.len()];
        self.cells_m.fill(NO_POINT);
        for (cell, row) in by_cell(&self.samples_m, per_cell, ny) {
            if let (Some(cell_m), Some(known)) = (self.cells_m.get_mut(cell), known.get_mut(cell)) {
                *cell_m = row.iter().copied().fold(*cell_m, f32::max);
                *known += row.iter().filter(|sample_m| is_known(**sample_m)).count();
            }
        }
        let mut unknown_cells = 0;
        for (cell_m, known) in self.cells_m.iter_mut().zip(known) {
            if known < least_known {
                *cell_m = self.unknown_m;
                unknown_cells += 1;
            }
        }
        unknown_cells
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
        let resolution = self.grid.resolution();
        let per_cell = resolution.samples_per_cell();
        let (nx, ny) = (self.grid.nx() * per_cell, self.grid.ny() * per_cell);
        let pitch_m = resolution.surface_pitch_m();
        let surface = Surface::from_metres(nx, ny, pitch_m, self.samples_m.clone())?;
        let heights = self.cells_m.iter().map(|cell_m| self.units(*cell_m));
        let heightmap = Heightmap::from_units(self.grid.nx(), self.grid.ny(), heights.collect())?;
        Scene::new(&self.grid, heightmap, Some(surface))
    }

    /// The height of a cell in units, less the noise: its highest sample is a little too high, and is rounded up.
    fn units(&self, cell_m: f32) -> Units {
        let is_known = cell_m < self.unknown_m;
        let excess_m = if is_known { self.settings.noise_m } else { 0.0 };
        let height_m = (f64::from(cell_m) - excess_m).max(0.0);
        self.grid.resolution().units_above(height_m)
    }
}

/// The samples of a grid's surface, numbered row by row, seen from above.
///
/// A container that is no multiple of the cell has a strip beside the grid, which is in no sample.
#[derive(Debug, Clone, Copy)]
struct Raster {
    nx: usize,
    ny: usize,
    samples_per_m: f64,
    radius_m: f64,
}

impl Raster {
    /// For points that stand for what is within `radius_m` along x and y.
    fn new(grid: &Grid, radius_m: f64) -> Self {
        let per_cell = grid.resolution().samples_per_cell();
        Self {
            nx: grid.nx() * per_cell,
            ny: grid.ny() * per_cell,
            samples_per_m: 1.0 / grid.resolution().surface_pitch_m(),
            radius_m,
        }
    }

    /// The sample that a place with positive coordinates is in.
    fn sample_at(&self, x_m: f64, y_m: f64) -> Option<usize> {
        let [x, y] = [x_m, y_m].map(|side_m| (side_m * self.samples_per_m) as usize);
        (x < self.nx && y < self.ny).then_some(x * self.ny + y)
    }

    /// The samples that a point at this place stands for.
    fn samples_near(self, x_m: f64, y_m: f64) -> impl Iterator<Item = usize> {
        // Casts saturate: what lies before the first sample belongs to it.
        let first = |side_m: f64| ((side_m - self.radius_m) * self.samples_per_m) as usize;
        let end = |side_m: f64| ((side_m + self.radius_m) * self.samples_per_m) as usize + 1;
        let xs = first(x_m)..end(x_m).min(self.nx);
        let ys = first(y_m)..end(y_m).min(self.ny);
        xs.flat_map(move |x| ys.clone().map(move |y| x * self.ny + y))
    }
}

/// A height above the rim that is the first unit above it.
fn above_rim_m(grid: &Grid) -> f32 {
    let unit_m = grid.resolution().height_unit_m();
    // Halfway, so that rounding does not reach the rim or the unit's end.
    let next_m = (f64::from(grid.rim()) + 1.0) * unit_m;
    (0.5 * (grid.container().z_m + next_m)) as f32
}
