//! Pictures of packing: scenes, contact sheets of objects, and heightmaps.
//!
//! Everything is drawn on the CPU and without system fonts, so that a picture looks the same on
//! every machine and equal input gives equal bytes. Nothing here touches files: pictures are
//! returned as an [`Image`] or a PNG's bytes.
//!
//! ```
//! use nalgebra::{Isometry3, Point3};
//! use ppnpack_picture::{Camera, Colour, Item, Scene3d, Size, TriangleMesh, render};
//!
//! let vertices = [Point3::origin(), Point3::new(0.1, 0.0, 0.0), Point3::new(0.0, 0.1, 0.05)];
//! let item = Item {
//!     mesh: TriangleMesh { vertices: &vertices, triangles: &[[0, 1, 2]] },
//!     world_from_item: Isometry3::translation(0.1, 0.1, 0.0),
//!     colour: Colour::of_item(0),
//! };
//! let scene = Scene3d { items: vec![item], container_m: Some([0.32, 0.32, 0.30]) };
//! let image = render(&scene, &Camera::overlooking(&scene), Size::new(160, 120)?)?;
//! let png: Vec<u8> = image.to_png()?;
//! # Ok::<(), ppnpack_picture::PictureError>(())
//! ```

mod colour;
mod error;
mod heightmap;
mod image;
mod scene3d;
mod sheet;
mod text;
mod ticks;

pub use colour::Colour;
pub use error::PictureError;
pub use heightmap::{HeightField, heightmap};
pub use image::{Image, Size};
pub use scene3d::{Camera, Item, Scene3d, TriangleMesh, render};
pub use sheet::{Tile, contact_sheet};
