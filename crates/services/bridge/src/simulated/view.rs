//! What the sensor of a simulated cell sees.

use nalgebra::{Isometry3, Point3};
use ppnpack_packing::grid::{Grid, Resolution, Yaws};
use ppnpack_physics::camera::DepthCamera;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::error::PhysicsError;

use super::{CameraSettings, Scan, SimulatedError, SimulatedSettings};
use crate::robot::View as RobotView;

/// The sensor of a simulated cell.
pub(super) enum View {
    /// A point above the middle of each sample of this grid.
    Exact(Box<Grid>),
    /// What a camera sees.
    Camera {
        camera: Box<DepthCamera>,
        settings: CameraSettings,
        /// How many images were taken: each has noise of its own.
        images: u64,
    },
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
                let camera = &settings.camera;
                camera.noise.validate()?;
                Ok(Self::Camera {
                    camera: Box::new(DepthCamera::pinhole_above(
                        container,
                        camera.height_m,
                        camera.width_px,
                        camera.height_px,
                    )?),
                    settings: *camera,
                    images: 0,
                })
            }
        }
    }

    /// What it sees of a cell.
    pub(super) fn of(&mut self, cell: &mut SimulatedCell) -> Result<RobotView, PhysicsError> {
        match self {
            Self::Exact(grid) => scan(cell, grid),
            Self::Camera {
                camera,
                settings,
                images,
            } => {
                *images += 1;
                let seed = settings.seed.wrapping_add(*images);
                let image = cell.render(camera)?.with_noise(&settings.noise, seed)?;
                let cloud = image.to_point_cloud();
                Ok(RobotView {
                    points_m: cloud.points_m,
                    container_from_sensor: cloud.container_from_camera,
                })
            }
        }
    }
}

/// The scan as points in the container frame: heights and middles keep their bits on the way to a heightmap.
fn scan(cell: &mut SimulatedCell, grid: &Grid) -> Result<RobotView, PhysicsError> {
    let surface = cell.scan_surface(grid)?;
    let middle_m = |index: usize| ((index as f64 + 0.5) * surface.pitch_m()) as f32;
    let rows = surface.heights_m().chunks_exact(surface.ny()).enumerate();
    let points = rows.flat_map(|(x, row)| {
        let samples = row.iter().enumerate();
        samples.map(move |(y, height_m)| Point3::new(middle_m(x), middle_m(y), *height_m))
    });
    Ok(RobotView {
        points_m: points.collect(),
        container_from_sensor: Isometry3::identity(),
    })
}
