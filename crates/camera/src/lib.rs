//! A simulated depth camera.
//!
//! A [`DepthCamera`] sees posed triangle meshes ([`Body`]) through a pinhole, as a sensor with the
//! noise of a [`NoiseModel`] would publish them. The [`DepthBuffer`] underneath is for those who
//! draw many expected views, such as a pose search.
//!
//! The camera frame is the optical one: x to the right of the image, y down, z forward, origin at
//! the pinhole. Pixel `(u, v)` is column `u` of row `v` and stands for the ray through its centre:
//! `u = fx x / z + cx`, `v = fy y / z + cy`.
//!
//! The crate knows neither a scene's meaning nor any mesh type: it borrows slices of vertices and
//! triangles.
//!
//! ```
//! use nalgebra::{Isometry3, Point3};
//! use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
//!
//! let vertices = [Point3::new(-1.0, -1.0, 0.0), Point3::new(1.0, -1.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
//! let triangle = Body { vertices: &vertices, triangles: &[[0, 1, 2]], world_from_body: Isometry3::identity() };
//! let camera = DepthCamera::looking_down(Intrinsics::centred(64, 48, 60.0)?, Point3::new(0.0, 0.0, 0.9));
//! let cloud = camera.see(&[triangle], &NoiseModel::none(), 7)?;
//! assert_eq!(cloud.len(), 64 * 48);
//! assert!((cloud[24 * 64 + 32].z - 0.9).abs() < 1e-6);
//! # Ok::<(), ppnpack_camera::CameraError>(())
//! ```

mod buffer;
mod camera;
mod error;
mod intrinsics;
mod noise;

pub use buffer::DepthBuffer;
pub use camera::{Body, DepthCamera};
pub use error::CameraError;
pub use intrinsics::Intrinsics;
pub use noise::NoiseModel;
