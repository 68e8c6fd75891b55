//! Meshes to packable items.
//!
//! A [`catalogue::Catalogue`] is loaded from a folder of mesh files, or from meshes that the program has. Each mesh
//! is read ([`reader`]), checked and repaired ([`repair`]), and becomes a model ([`build`]): its
//! mass, convex pieces for physics and resting poses. A model at a resolution of the grid is an
//! item ([`views`]), rasterised exactly ([`raster`]); in another resting pose it is another item. Of an item of which
//! no more is known than its heightmaps there is a solid all the same ([`seen`]).
//!
//! ```
//! use nalgebra::Point3;
//! use ppnpack_catalogue::build::{ModelSettings, model};
//! use ppnpack_catalogue::mesh::Bounds;
//! use ppnpack_catalogue::views;
//! use ppnpack_packing::kernel::grid::Resolution;
//!
//! let sides = Bounds { lowest: Point3::origin(), highest: Point3::new(0.2, 0.1, 0.05) };
//! let (brick, _repairs) = model("brick", sides.mesh(), &ModelSettings::default())?;
//! assert!((brick.volume_m3 - 0.001).abs() < 1e-9);
//!
//! // Cells of 1 cm, units of 2 mm, 4 yaws: one view a yaw.
//! let item = views::item(&brick, &Resolution::reference())?;
//! assert_eq!(item.views().len(), 4);
//! assert_eq!((item.views()[0].nx(), item.views()[0].ny(), item.views()[0].height()), (20, 10, 25));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod build;
pub mod cache;
pub mod cartons;
pub mod catalogue;
pub mod container;
pub mod convex;
mod error;
mod hull;
pub mod lying;
pub mod mass;
pub mod object;
pub mod orders;
mod overlap;
pub mod poses;
pub mod reader;
pub mod repair;
pub mod report;
pub mod resting;
pub mod rows;
pub mod seen;
pub mod shape_class;
#[cfg(test)]
mod shapes;
mod source;
mod table;
pub mod unit;
pub mod views;

pub use ppnpack_packing::scene::model::{mesh, raster};
