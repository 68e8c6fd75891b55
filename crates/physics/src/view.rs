//! Depth cameras above a simulated cell.

use std::ops::Bound;

use nalgebra::{Isometry3, Point3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_numbers::{SettingError, settings, within};
use ppnpack_packing::kernel::grid::{ContainerSize, Grid};
use ppnpack_packing::scene::Scene;
use ppnpack_packing::scene::content::Content;
use ppnpack_packing::scene::hidden::SceneMemory;
use ppnpack_perception::mapper::Mapper;
use ppnpack_perception::settings::MapperSettings;

pub use ppnpack_camera::NoiseModel;

use crate::cell::SimulatedCell;
use crate::error::PhysicsError;

/// Distance of each of two cameras from the middle of the container along x, in metres.
const BESIDE_M: f64 = 0.2;

settings! {
    /// Depth cameras above a container, each with all of its rim in the image.
    #[derive(Copy)]
    pub struct CameraSettings {
        /// One camera above the middle, or two, beside it along x.
        pub cameras: usize = 1,
        /// Their height above the floor, in metres.
        pub height_m: f64 = 0.9,
        /// Columns of an image.
        pub width_px: usize = 640,
        /// Rows of an image.
        pub height_px: usize = 480,
        /// Their noise.
        pub noise: NoiseModel = NoiseModel::default(),
        /// The seed of their noise.
        pub seed: u64 = 0,
    }
}

impl CameraSettings {
    /// Checks that every number is possible above a container.
    ///
    /// # Errors
    /// [`SettingError`] names the first that is not.
    pub fn validate(&self, container: ContainerSize) -> Result<(), SettingError> {
        within("1 or 2", 1.0..=2.0)("camera.cameras", self.cameras as f64)?;
        let above = (Bound::Excluded(container.z_m), Bound::Unbounded);
        within("above the rim", above)("camera.height_m", self.height_m)?;
        let of_camera = |error: SettingError| SettingError {
            name: format!("camera.{}", error.name),
            ..error
        };
        self.noise.validate().map_err(of_camera)
    }

    fn poses(&self, container: ContainerSize) -> Result<Vec<DepthCamera>, PhysicsError> {
        let (x_m, y_m) = (container.x_m * 0.5, container.y_m * 0.5);
        let middle = Point3::new(x_m, y_m, 0.0);
        let beside: &[f64] = match self.cameras {
            1 => &[0.0],
            _ => &[-BESIDE_M, BESIDE_M],
        };
        let cameras = beside.iter().map(|beside_m| {
            let place = Point3::new(x_m + beside_m, y_m, self.height_m);
            // One that leans sees the near wall's rim wider than one above the middle.
            let wider_m = beside_m.abs();
            let sides_m = [container.x_m + 1.5 * wider_m, container.y_m + wider_m];
            let to_rim_m = self.height_m - container.z_m;
            let intrinsics = Intrinsics::framing(self.width_px, self.height_px, sides_m, to_rim_m)?;
            let camera = DepthCamera {
                // The rim may be right below the camera.
                near_m: 0.01,
                ..DepthCamera::looking_at(intrinsics, place, &middle)
            };
            camera.validate()?;
            Ok(camera)
        });
        cameras.collect()
    }
}

/// A cloud of one camera.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraCloud {
    /// The points that were measured, in the camera's frame, in metres.
    pub points_m: Vec<Point3<f32>>,
    /// The camera's pose.
    pub container_from_camera: Isometry3<f64>,
}

/// Cameras above a simulated cell.
#[derive(Debug, Clone)]
pub struct Cameras {
    cameras: Vec<DepthCamera>,
    noise: NoiseModel,
    seed: u64,
    /// The number of images that were taken: each has noise of its own.
    images: u64,
}

impl Cameras {
    /// Sets up the cameras of these settings above a container.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] or [`PhysicsError::Camera`] where a setting is impossible.
    pub fn new(settings: &CameraSettings, container: ContainerSize) -> Result<Self, PhysicsError> {
        settings.validate(container)?;
        Ok(Self {
            cameras: settings.poses(container)?,
            noise: settings.noise,
            seed: settings.seed,
            images: 0,
        })
    }

    /// Gives the cameras, in the container's frame.
    pub fn cameras(&self) -> &[DepthCamera] {
        &self.cameras
    }

    /// Takes a cloud of a cell with each.
    ///
    /// # Errors
    /// [`PhysicsError::Camera`] where the content has too many triangles.
    pub fn see(&mut self, cell: &SimulatedCell) -> Result<Vec<CameraCloud>, PhysicsError> {
        let (container, contents) = (cell.container_mesh(), cell.contents());
        let mut bodies = vec![posed(&container, Isometry3::identity())];
        let items = contents.iter();
        bodies.extend(items.map(|item| posed(&item.model.mesh, item.container_from_item)));
        let clouds = self.cameras.iter().map(|camera| {
            self.images += 1;
            let seed = self.seed.wrapping_add(self.images);
            let mut points_m = camera.see(&bodies, &self.noise, seed)?;
            points_m.retain(|point| !point.z.is_nan());
            Ok(CameraCloud {
                points_m,
                container_from_camera: camera.world_from_camera,
            })
        });
        clouds.collect()
    }
}

fn posed(mesh: &Mesh, container_from_mesh: Isometry3<f64>) -> Body<'_> {
    Body {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        world_from_body: container_from_mesh,
    }
}

/// Cameras with what perception makes of their clouds.
#[derive(Debug, Clone)]
pub struct CameraView {
    cameras: Cameras,
    mapper: Mapper,
    memory: SceneMemory,
    grid: Grid,
}

impl CameraView {
    /// Makes a view of the content of a grid's container.
    ///
    /// # Errors
    /// As [`Cameras::new`].
    pub fn new(settings: &CameraSettings, grid: &Grid) -> Result<Self, PhysicsError> {
        let mapper = MapperSettings::of_camera(settings.noise.sigma_m);
        Ok(Self {
            cameras: Cameras::new(settings, grid.container())?,
            mapper: Mapper::new(grid, mapper)?,
            memory: SceneMemory::default(),
            grid: grid.clone(),
        })
    }

    /// Forgets what was seen, as when the container is emptied.
    pub fn clear(&mut self) {
        self.memory.clear();
    }

    /// Makes the scene of a cell in which this is known to lie.
    ///
    /// # Errors
    /// As [`Cameras::see`].
    pub fn scene(&mut self, cell: &SimulatedCell, known: Content) -> Result<Scene, PhysicsError> {
        self.mapper.clear();
        for cloud in self.cameras.see(cell)? {
            let pose = &cloud.container_from_camera;
            self.mapper.add(cloud.points_m, pose);
        }
        let scene = self.mapper.finish()?.scene.with_content(known);
        Ok(self.memory.complete(&self.grid, scene))
    }
}
