//! The sensors of a simulated cell.

use nalgebra::{Isometry3, Point3};
use ppnpack_packing::kernel::grid::{Grid, Resolution, Yaws};
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::view::Cameras;

use super::{Scan, SimulatedError, SimulatedSettings, sensor_names};
use crate::robot::View as RobotView;

/// The sensors of a simulated cell.
pub(super) enum View {
    /// A point above the middle of each sample of this grid.
    Exact(Box<Grid>),
    /// Cameras.
    Camera(Box<Cameras>),
}

impl View {
    pub(super) fn new(settings: &SimulatedSettings) -> Result<Self, SimulatedError> {
        let container = settings.physics.container;
        match settings.scan {
            Scan::Exact => {
                // Heights are scanned in metres: the units do not matter.
                let unit_m = container.z_m / 1000.0;
                let grid = Yaws::half_turn(1)
                    .and_then(|yaws| Resolution::new(settings.scan_pitch_m, unit_m, yaws))
                    .and_then(|resolution| Grid::new(container, resolution))?;
                Ok(Self::Exact(Box::new(grid)))
            }
            Scan::Camera => {
                let cameras = Cameras::new(&settings.camera, container)?;
                Ok(Self::Camera(Box::new(cameras)))
            }
        }
    }

    /// Looks at a cell with each.
    pub(super) fn of(
        &mut self,
        cell: &mut SimulatedCell,
    ) -> Result<Vec<RobotView>, SimulatedError> {
        match self {
            Self::Exact(grid) => Ok(vec![scan(cell, grid)?]),
            Self::Camera(cameras) => {
                let clouds = cameras.see(cell)?;
                let names = sensor_names(clouds.len());
                let views = names
                    .into_iter()
                    .zip(clouds)
                    .map(|(sensor, cloud)| RobotView {
                        sensor,
                        points_m: cloud.points_m,
                        container_from_sensor: cloud.container_from_camera,
                        is_of_now: true,
                    });
                Ok(views.collect())
            }
        }
    }
}

/// Scans a cell as points in the container's frame: heights and middles keep their bits on the way
/// to a heightmap.
fn scan(cell: &mut SimulatedCell, grid: &Grid) -> Result<RobotView, SimulatedError> {
    let surface = cell.scan_surface(grid)?;
    let middle_m = |index: usize| ((index as f64 + 0.5) * surface.pitch_m()) as f32;
    let rows = surface.heights_m().chunks_exact(surface.ny()).enumerate();
    let points = rows.flat_map(|(x, row)| {
        let samples = row.iter().enumerate();
        samples.map(move |(y, height_m)| Point3::new(middle_m(x), middle_m(y), *height_m))
    });
    Ok(RobotView {
        sensor: String::new(),
        points_m: points.collect(),
        container_from_sensor: Isometry3::identity(),
        is_of_now: true,
    })
}
