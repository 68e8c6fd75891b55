//! Walls that lean, or have round corners between them: a sensor sees them from above.
//!
//! What shows such a wall shows that the container is empty there: its height is known, and more
//! exactly than a point of a steep wall tells it.

use nalgebra::Point3;
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Units};
use ppnpack_packing::kernel::heightmap::{Heightmap, Surface};

use crate::raster::Raster;

/// Minimum height above the wall at which a sample shows something else, in metres.
const LEAST_M: f32 = 0.001;

/// The walls of a container that is no box.
#[derive(Debug, Clone)]
pub(crate) struct LeaningWalls {
    container: ContainerSize,
    margin_m: f64,
    /// The margin in samples.
    reach: usize,
    inside: Surface,
    empty: Heightmap,
}

impl LeaningWalls {
    /// Makes the walls of a grid's container, which show up to a margin before them; `None` of a
    /// box, whose walls are seen from their edge.
    pub(crate) fn of(grid: &Grid, margin_m: f64) -> Option<Self> {
        let container = grid.container();
        let reach = margin_m / grid.resolution().surface_pitch_m();
        (!container.is_box()).then(|| Self {
            container,
            margin_m,
            reach: (reach - 1e-6).ceil() as usize,
            inside: Surface::empty(grid),
            empty: Heightmap::empty(grid),
        })
    }

    /// Says whether what is at a point may be a wall.
    pub(crate) fn show_at(&self, point: &Point3<f64>) -> bool {
        !self.container.holds(point, self.margin_m)
    }

    /// Gives the height of the inside at a sample, in metres.
    pub(crate) fn height_m(&self, sample: usize) -> f32 {
        let height_m = self.inside.heights_m().get(sample);
        height_m.copied().unwrap_or_default()
    }

    /// Gives samples in which content would count as a wall the height of the content beside them.
    pub(crate) fn fill_margins(&self, samples_m: &mut [f32], raster: Raster) {
        let seen_m = samples_m.to_vec();
        for (sample, sample_m) in samples_m.iter_mut().enumerate() {
            let middle = raster.middle(sample);
            let wall_m = self.height_m(sample);
            for near in raster.samples_within(sample, self.reach) {
                let near_m = seen_m.get(near).copied().unwrap_or_default();
                let is_content = near_m > self.height_m(near) + LEAST_M && near_m > wall_m;
                let place = Point3::new(middle.x, middle.y, f64::from(near_m));
                if is_content && near_m > *sample_m && self.show_at(&place) {
                    *sample_m = near_m;
                }
            }
        }
    }

    /// Raises samples, in metres, and cells, in units, to the inside where they are below it.
    pub(crate) fn raise(&self, samples_m: [&mut Vec<f32>; 2], cells: &mut [Units]) {
        for samples_m in samples_m {
            for (sample_m, inside_m) in samples_m.iter_mut().zip(self.inside.heights_m()) {
                *sample_m = sample_m.max(*inside_m);
            }
        }
        for (cell, lowest) in cells.iter_mut().zip(self.empty.heights()) {
            *cell = (*cell).max(*lowest);
        }
    }
}
