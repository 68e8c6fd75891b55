//! Recognition of catalogue objects in point clouds, with their poses.
//!
//! [`segmentation`] finds the items on a support; a [`library::Library`] holds the objects that can
//! be recognised, prepared once; a [`recognise::Recogniser`] says of each item which object it is
//! and in which pose, or that it is unknown, and why. Both can be packed: a known one as it lies
//! ([`posed`]), an unknown one as far as it was seen ([`unknown_item`]). Whether an item lies where
//! it was placed, [`inspection`] tells.
//!
//! The crate is pure and synchronous; it knows neither the wire nor any sensor.
//!
//! A carton on a table, seen by a simulated camera:
//!
//! ```
//! use std::sync::Arc;
//!
//! use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
//! use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
//! use ppnpack_catalogue::build::{ModelSettings, model};
//! use ppnpack_catalogue::mesh::{Bounds, Mesh};
//! use ppnpack_recognition::library::{Library, LibrarySettings};
//! use ppnpack_recognition::recognise::{Recogniser, Recognition, RecognitionSettings};
//! use ppnpack_recognition::segmentation::{Region, SegmentationSettings, segment};
//!
//! let cuboid = |lowest: [f64; 3], highest: [f64; 3]| {
//!     Bounds { lowest: lowest.into(), highest: highest.into() }.mesh()
//! };
//! let carton = cuboid([-0.06, -0.035, 0.0], [0.06, 0.035, 0.04]);
//! let table = cuboid([-1.0, -1.0, -0.01], [1.0, 1.0, 0.0]);
//!
//! // What can be recognised.
//! let (known, _) = model("carton", carton.clone(), &ModelSettings::default())?;
//! let library = Library::new(&[Arc::new(known)], LibrarySettings::default())?;
//! let recogniser = Recogniser::new(Arc::new(library), RecognitionSettings::default());
//!
//! // What a camera 90 cm above the table sees.
//! let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.4);
//! let world_from_carton = Translation3::new(0.1, 0.05, 0.0) * turn;
//! fn body(mesh: &Mesh, world_from_body: Isometry3<f64>) -> Body<'_> {
//!     Body { vertices: &mesh.vertices, triangles: &mesh.triangles, world_from_body }
//! }
//! let bodies = [body(&table, Isometry3::identity()), body(&carton, world_from_carton)];
//! let eye = Point3::new(0.0, 0.0, 0.9);
//! let camera = DepthCamera::looking_down(Intrinsics::centred(640, 480, 600.0)?, eye);
//! let cloud = camera.see(&bodies, &NoiseModel::default(), 7)?;
//!
//! // Where items may lie, and what lies there.
//! let (lowest_m, highest_m) = (Point3::new(-0.3, -0.3, -0.05), Point3::new(0.3, 0.3, 0.3));
//! let settings = SegmentationSettings::of(Region { lowest_m, highest_m });
//! let seen = segment(camera.in_world_m(&cloud), &eye, &settings);
//! let Recognition::Known(found) = recogniser.recognise(&seen.clusters[0]) else {
//!     panic!("the carton is unknown");
//! };
//! assert_eq!(found.best.name, "carton");
//! let middle = Point3::new(0.0, 0.0, 0.02);
//! let off_m = nalgebra::distance(&(found.best.world_from_item * middle), &(world_from_carton * middle));
//! assert!(off_m < 0.002);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod align;
mod coarse;
pub mod evaluation;
pub mod expected;
mod groups;
pub mod inspection;
pub mod library;
mod moments;
pub mod nearest;
mod object;
mod outline;
mod pattern;
pub mod posed;
pub mod recognise;
mod refinement;
mod rest;
pub mod samples;
pub mod segmentation;
mod spacing;
pub mod support;
pub mod symmetry;
mod twins;
pub mod unknown_item;
