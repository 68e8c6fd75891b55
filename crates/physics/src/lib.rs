//! The simulated robot cell: an open container into which items are released, what becomes of
//! them, and how high the content stands.
//!
//! [`SimulatedCell`](cell::SimulatedCell) releases items at planned poses, lets them fall and
//! settle, and says where they ended; it scans the container into the surface that the next
//! placement is planned on.
//!
//! All positions are in the container frame: metres, right-handed, z up, the origin at an inner
//! bottom corner. The simulation is single-threaded, and the same settings and the same calls give
//! the same bits.
//!
//! ```
//! use std::sync::Arc;
//!
//! use nalgebra::{Isometry3, Point3};
//! use ppnpack_catalogue::build::{ModelSettings, model};
//! use ppnpack_catalogue::mesh::Bounds;
//! use ppnpack_packing::kernel::grid::Grid;
//! use ppnpack_physics::cell::SimulatedCell;
//! use ppnpack_physics::settings::CellSettings;
//!
//! let sides = Bounds { lowest: Point3::origin(), highest: Point3::new(0.2, 0.1, 0.05) };
//! let (brick, _repairs) = model("brick", sides.mesh(), &ModelSettings::default())?;
//!
//! let mut cell = SimulatedCell::new(CellSettings::default())?;
//! let placed = cell.place(&Arc::new(brick), &Isometry3::translation(0.06, 0.11, 0.0))?;
//! assert!(placed.inside && !placed.toppled);
//! let scene = cell.scan(&Grid::reference())?;
//! // Units of 2 mm.
//! assert!((24..=26).contains(&scene.heightmap().max()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod body;
pub mod cell;
mod container;
mod convert;
pub mod error;
mod laid;
pub mod moves;
pub mod outcome;
mod overlap;
pub mod packing_cell;
mod rolling;
pub mod settings;
mod surface;
mod terrain;
pub mod trial;
pub mod twin;
pub mod view;
mod world;
