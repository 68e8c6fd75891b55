//! Depth cameras: what a sensor above the container would see.
//!
//! The camera frame is the optical one: x to the right of the image, y down, z forward, the origin at the camera. A
//! pixel `(u, v)` is column `u` of row `v` and stands for the ray through its centre, whose image coordinates are
//! `(u, v)`.

mod image;
mod noise;
mod render;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_numbers::require;
use ppnpack_packing::grid::{ContainerSize, Grid};
use serde::{Deserialize, Serialize};

pub use self::image::{DepthImage, PointCloud};
pub use self::noise::DepthNoise;
use crate::error::PhysicsError;

/// The most pixels along one side of an image.
const MAX_SIDE_PX: f64 = 8192.0;

/// How much of the image a camera placed above the container leaves free around the rim.
const FRAMING: f64 = 0.95;

/// How points become pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Lens {
    /// Parallel rays along z; the middle of the image lies on the z axis.
    Parallel {
        /// The distance between two pixels, in metres.
        pitch_m: f64,
    },
    /// Rays through the camera's origin: `u = fx x / z + cx`, `v = fy y / z + cy`.
    Pinhole {
        /// Focal length along x, in pixels.
        fx_px: f64,
        /// Focal length along y, in pixels.
        fy_px: f64,
        /// Column of the z axis.
        cx_px: f64,
        /// Row of the z axis.
        cy_px: f64,
    },
}

/// A depth camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthCamera {
    /// Columns of the image.
    pub width_px: usize,
    /// Rows of the image.
    pub height_px: usize,
    /// How points become pixels.
    pub lens: Lens,
    /// Where the camera is.
    pub container_from_camera: Isometry3<f64>,
    /// Nothing nearer than this along z is seen, in metres.
    pub near_m: f64,
    /// Nothing farther than this along z is seen, in metres.
    pub far_m: f64,
}

impl DepthCamera {
    /// A parallel camera that looks straight down on a grid from `height_m` above the floor, one pixel per sample of
    /// its surface. Columns run along x; rows run against y.
    pub fn parallel_above(grid: &Grid, height_m: f64) -> Self {
        let samples = grid.resolution().samples_per_cell();
        let (width_px, height_px) = (grid.nx() * samples, grid.ny() * samples);
        let pitch_m = grid.resolution().surface_pitch_m();
        let [x_m, y_m] = [width_px, height_px].map(|side| side as f64 * pitch_m * 0.5);
        Self {
            width_px,
            height_px,
            lens: Lens::Parallel { pitch_m },
            container_from_camera: looking_down(Point3::new(x_m, y_m, height_m)),
            near_m: 0.01,
            far_m: 10.0,
        }
    }

    /// A pinhole camera that looks straight down on the middle of a container from `height_m` above the floor, with
    /// the whole rim in the image. Columns run along x; rows run against y.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] where it would not be above the rim, or the image has no pixel.
    pub fn pinhole_above(
        container: ContainerSize,
        height_m: f64,
        width_px: usize,
        height_px: usize,
    ) -> Result<Self, PhysicsError> {
        require("the camera's height", height_m, "above the rim", |height| {
            height > container.z_m
        })?;
        let to_rim_m = height_m - container.z_m;
        let [width, height] = [width_px, height_px].map(|side| side as f64);
        let focal_px = FRAMING * to_rim_m * (width / container.x_m).min(height / container.y_m);
        let camera = Self {
            width_px,
            height_px,
            lens: Lens::Pinhole {
                fx_px: focal_px,
                fy_px: focal_px,
                cx_px: (width - 1.0) * 0.5,
                cy_px: (height - 1.0) * 0.5,
            },
            container_from_camera: looking_down(Point3::new(
                container.x_m * 0.5,
                container.y_m * 0.5,
                height_m,
            )),
            near_m: 0.01,
            far_m: 10.0,
        };
        camera.validate()?;
        Ok(camera)
    }

    /// Checks that every number is possible.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] or [`PhysicsError::CameraPose`] for the first that is not.
    pub fn validate(&self) -> Result<(), PhysicsError> {
        let is_side = |side: f64| (1.0..=MAX_SIDE_PX).contains(&side);
        require(
            "the image's width",
            self.width_px as f64,
            "between 1 and 8192",
            is_side,
        )?;
        require(
            "the image's height",
            self.height_px as f64,
            "between 1 and 8192",
            is_side,
        )?;
        let is_positive = |value: f64| value > 0.0;
        match self.lens {
            Lens::Parallel { pitch_m } => {
                require("the pixels' pitch", pitch_m, "above 0 m", is_positive)?;
            }
            Lens::Pinhole {
                fx_px,
                fy_px,
                cx_px,
                cy_px,
            } => {
                require("the focal length fx", fx_px, "above 0 pixels", is_positive)?;
                require("the focal length fy", fy_px, "above 0 pixels", is_positive)?;
                require("the principal point cx", cx_px, "finite", |_| true)?;
                require("the principal point cy", cy_px, "finite", |_| true)?;
            }
        }
        require(
            "the camera's near limit",
            self.near_m,
            "above 0 m",
            is_positive,
        )?;
        require(
            "the camera's far limit",
            self.far_m,
            "above the near limit",
            |far| far > self.near_m,
        )?;
        let rotation = self.container_from_camera.rotation.into_inner();
        let translation = self.container_from_camera.translation.vector;
        let is_rigid = (rotation.norm() - 1.0).abs() <= 1e-3;
        if is_rigid && translation.iter().all(|value| value.is_finite()) {
            Ok(())
        } else {
            Err(PhysicsError::CameraPose)
        }
    }

    /// The depth image of meshes, each with its pose in the container frame.
    ///
    /// # Errors
    /// As [`validate`](Self::validate).
    pub fn render<'mesh>(
        &self,
        meshes: impl IntoIterator<Item = (&'mesh Mesh, Isometry3<f64>)>,
    ) -> Result<DepthImage, PhysicsError> {
        self.validate()?;
        let mut canvas = render::Canvas::new(self);
        let camera_from_container = self.container_from_camera.inverse();
        for (mesh, container_from_mesh) in meshes {
            canvas.draw(mesh, &(camera_from_container * container_from_mesh));
        }
        Ok(DepthImage::new(self.clone(), canvas.into_depths_m()))
    }

    /// The point that a pixel sees at a depth, in the camera frame, in metres.
    pub fn unproject(&self, u: f64, v: f64, depth_m: f64) -> Point3<f64> {
        match self.lens {
            Lens::Parallel { pitch_m } => {
                let [middle_u, middle_v] = self.middle_px();
                Point3::new((u - middle_u) * pitch_m, (v - middle_v) * pitch_m, depth_m)
            }
            Lens::Pinhole {
                fx_px,
                fy_px,
                cx_px,
                cy_px,
            } => {
                let (x, y) = ((u - cx_px) / fx_px, (v - cy_px) / fy_px);
                Point3::new(x * depth_m, y * depth_m, depth_m)
            }
        }
    }

    /// Image coordinates of a point of the camera frame with positive z.
    fn project(&self, point: &Point3<f64>) -> [f64; 2] {
        match self.lens {
            Lens::Parallel { pitch_m } => {
                let [middle_u, middle_v] = self.middle_px();
                [point.x / pitch_m + middle_u, point.y / pitch_m + middle_v]
            }
            Lens::Pinhole {
                fx_px,
                fy_px,
                cx_px,
                cy_px,
            } => [
                fx_px * point.x / point.z + cx_px,
                fy_px * point.y / point.z + cy_px,
            ],
        }
    }

    fn middle_px(&self) -> [f64; 2] {
        [self.width_px, self.height_px].map(|side| (side as f64 - 1.0) * 0.5)
    }
}

/// A camera at a place whose z axis points down and whose x axis is the container's.
fn looking_down(place: Point3<f64>) -> Isometry3<f64> {
    let half_turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    Isometry3::from_parts(Translation3::from(place.coords), half_turn)
}
