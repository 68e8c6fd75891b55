//! Lines of sight: how high content may stand where no point was seen.
//!
//! A measured point proves that its ray was free from the sensor down to it. So content in a column
//! is at most as high as the highest place in it that no ray is known to have passed.
//!
//! Rays are named by where they would pierce the floor if nothing stood there. On that plane the
//! pixels of a camera above lie evenly, organised or not. A column's places, from the rim down,
//! move along a line to its foot.
//!
//! ```text
//!            eye
//!             \
//!   rim  ------\---------      a ray's cell holds the height of the highest point that its rays hit
//!               \  ___
//!                \|   |
//!   floor  -------|---|-x---   x: its cell
//! ```

use nalgebra::{Point2, Point3};
use ppnpack_packing::kernel::grid::ContainerSize;

use crate::layers::neighbours;

/// Uncertainty of rays' heights, in standard deviations of the noise.
const NOISE_DEVIATIONS: f64 = 3.0;

/// Error of heights that a sensor's pose may make, in metres.
const POSE_M: f64 = 0.001;

/// Maximum distance from the rim, in metres, of points beside the opening that show the top of a
/// wall.
const WALL_TOP_M: f64 = 0.005;

/// Minimum number of rays of a cell on average. With fewer, cells are pooled by two and two, once:
/// what lies between rays farther apart may be missed.
const LEAST_RAYS: f64 = 1.5;

/// Maximum number of cells along a side: a sensor just above the rim looks on a wide plane.
const MAX_CELLS: f64 = 1024.0;

/// Minimum number of the eight cells around with a ray by which a cell without one lies among free
/// ones: a dropout.
const LEAST_AROUND: usize = 5;

/// Step down from the edge of a cell, in metres.
const STEP_M: f64 = 1e-6;

/// Height of a cell that no ray is known to have passed.
const NO_RAY: f32 = f32::INFINITY;

/// The rays of one sensor above a container.
#[derive(Debug, Clone)]
pub(crate) struct Sight {
    eye: Point3<f64>,
    container: ContainerSize,
    wall_margin_m: f64,
    margin_m: f64,
    /// The corner of the first cell on the plane of the floor.
    corner: Point2<f64>,
    pitch_m: f64,
    nx: usize,
    ny: usize,
    /// The greatest height that a ray hit, per cell; below 0 where there is none.
    hits_m: Vec<f32>,
    rays: u64,
    /// The greatest height around each cell, [`NO_RAY`] where no ray passes; after
    /// [`close`](Self::close).
    heights_m: Vec<f32>,
}

impl Sight {
    /// Makes the rays of a sensor at `eye`, on cells of `pitch_m`; `None` where that is not above
    /// the rim: such points come of no single sensor, or were taken to the container's frame
    /// before.
    pub(crate) fn new(
        container: ContainerSize,
        eye: Point3<f64>,
        pitch_m: f64,
        noise_m: f64,
        wall_margin_m: f64,
    ) -> Option<Self> {
        if !(eye.z - container.z_m > pitch_m && eye.coords.iter().all(|value| value.is_finite())) {
            return None;
        }
        // The opening as the sensor sees it on the floor.
        let spread = eye.z / (eye.z - container.z_m);
        let far = |at: f64, eye: f64| eye + (at - eye) * spread;
        let corner = Point2::new(far(0.0, eye.x), far(0.0, eye.y));
        let sides_m = [container.x_m * spread, container.y_m * spread];
        let least_m = sides_m.map(|side_m| side_m / MAX_CELLS);
        let pitch_m = least_m.into_iter().fold(pitch_m, f64::max);
        let [nx, ny] = sides_m.map(|side_m| (side_m / pitch_m).ceil().max(1.0) as usize);
        Some(Self {
            eye,
            container,
            wall_margin_m,
            margin_m: NOISE_DEVIATIONS * noise_m + POSE_M,
            corner,
            pitch_m,
            nx,
            ny,
            hits_m: vec![-1.0; nx * ny],
            rays: 0,
            heights_m: Vec::new(),
        })
    }

    /// Takes a point in, in the container's frame. Its ray counts where it passed the opening.
    #[inline]
    pub(crate) fn add(&mut self, point: &Point3<f64>) {
        let spread = self.eye.z / (self.eye.z - point.z);
        // Not one that is above the sensor, or no number.
        if spread.is_nan() || spread <= 0.0 {
            return;
        }
        let x = (self.eye.x + (point.x - self.eye.x) * spread - self.corner.x) / self.pitch_m;
        let y = (self.eye.y + (point.y - self.eye.y) * spread - self.corner.y) / self.pitch_m;
        if !(x >= 0.0 && y >= 0.0 && x < self.nx as f64 && y < self.ny as f64) {
            return;
        }
        let height_m = if self.container.holds(point, self.wall_margin_m) {
            point.z.max(0.0)
        } else if point.z < self.container.z_m - WALL_TOP_M {
            // The inner face of a wall: all of the ray within the container is free.
            0.0
        } else if point.z > self.container.z_m + WALL_TOP_M {
            point.z
        } else {
            return;
        };
        self.rays += 1;
        if let Some(hit_m) = self.hits_m.get_mut(x as usize * self.ny + y as usize) {
            *hit_m = hit_m.max(height_m as f32);
        }
    }

    /// Ends the rays of a cloud: from here on columns can be asked for.
    pub(crate) fn close(&mut self) {
        if self.is_sparse() {
            self.pool();
        }
        let hits_m = &self.hits_m;
        let hit = |cell: usize| hits_m.get(cell).copied().filter(|hit_m| *hit_m >= 0.0);
        let height = |cell: usize| {
            let around = || neighbours(cell, hits_m.len(), self.ny).filter_map(hit);
            match hit(cell) {
                None if around().count() < LEAST_AROUND => NO_RAY,
                _ => around().fold(0.0, f32::max),
            }
        };
        self.heights_m = (0..hits_m.len()).map(height).collect();
    }

    fn is_sparse(&self) -> bool {
        let hit = self.hits_m.iter().filter(|hit_m| **hit_m >= 0.0).count();
        (self.rays as f64) < LEAST_RAYS * hit as f64
    }

    /// Makes one cell of two by two.
    fn pool(&mut self) {
        let (nx, ny) = (self.nx.div_ceil(2), self.ny.div_ceil(2));
        let mut hits_m = vec![-1.0_f32; nx * ny];
        for (x, row) in self.hits_m.chunks_exact(self.ny).enumerate() {
            for (y, hit_m) in row.iter().enumerate() {
                if let Some(pooled_m) = hits_m.get_mut(x / 2 * ny + y / 2) {
                    *pooled_m = pooled_m.max(*hit_m);
                }
            }
        }
        (self.nx, self.ny, self.hits_m) = (nx, ny, hits_m);
        self.pitch_m *= 2.0;
    }

    /// Gives the height down to which the column at `at` is free from `top_m`, in metres; `top_m`
    /// where it is not free there.
    fn free_down_to(&self, at: Point2<f64>, top_m: f64) -> f64 {
        let spread = self.eye.z / (self.eye.z - top_m);
        let away = at - self.eye.xy();
        let pierced = (self.eye.xy() + away * spread - self.corner) / self.pitch_m;
        let [x, y] = [pierced.x, pierced.y].map(|at| at.max(0.0) as usize);
        if x >= self.nx || y >= self.ny {
            return top_m;
        }
        let height_m = self.heights_m.get(x * self.ny + y).copied();
        let blocked_m = f64::from(height_m.unwrap_or(NO_RAY)) + self.margin_m;
        if blocked_m >= top_m {
            return top_m;
        }
        blocked_m.max(self.leaves_cell_at(away, [x, y]))
    }

    /// Gives the height at which the way down a column leaves a cell.
    fn leaves_cell_at(&self, away: nalgebra::Vector2<f64>, [x, y]: [usize; 2]) -> f64 {
        let edge = |cell: usize, corner_m: f64, eye_m: f64, away_m: f64| {
            let edge = if away_m > 0.0 { cell } else { cell + 1 };
            let spread = (corner_m + edge as f64 * self.pitch_m - eye_m) / away_m;
            if spread.is_finite() { spread } else { 1.0 }
        };
        let along_x = edge(x, self.corner.x, self.eye.x, away.x);
        let along_y = edge(y, self.corner.y, self.eye.y, away.y);
        let spread = along_x.max(along_y).max(1.0);
        self.eye.z - self.eye.z / spread - STEP_M
    }
}

/// Gives the greatest height that content may have at a place, by all sensors: at or above the rim
/// where no ray passes there.
pub(crate) fn bound_m(sights: &[Sight], at: Point2<f64>, rim_m: f64) -> f64 {
    let mut top_m = rim_m;
    while top_m > 0.0 {
        let free = sights.iter().map(|sight| sight.free_down_to(at, top_m));
        let next_m = free.fold(top_m, f64::min);
        if next_m >= top_m {
            break;
        }
        top_m = next_m;
    }
    top_m.max(0.0)
}
