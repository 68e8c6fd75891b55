//! The arm of a physical cell: six joints, a suction cup, a container to fill from above.
//!
//! [`Arm`](arm::Arm) is made of a parameter file or [by name](arms); [`pick::find`] says where its
//! cup holds an item; [`PlacePlanner`](motion::PlacePlanner) plans the motion that places it,
//! checked for reach, joint ranges, singularities and collisions;
//! [`ArmCheck`](feasibility::ArmCheck) is that as one more validity check of the planning engine.
//! [`plan_cycle`](motion::PlacePlanner::plan_cycle) adds the pick and the transfer, and times it
//! all. [`ArmStation`](station::ArmStation) is all of it made of settings.
//!
//! All positions are in the container frame: metres, right-handed, z up, the origin at an inner
//! bottom corner.
//!
//! A built-in arm puts a carton down in the empty container:
//!
//! ```
//! use std::sync::Arc;
//!
//! use ppnpack_catalogue::build::{ModelSettings, model};
//! use ppnpack_catalogue::mesh::Bounds;
//! use ppnpack_catalogue::views;
//! use ppnpack_packing::kernel::grid::Grid;
//! use ppnpack_packing::kernel::heightmap::Heightmap;
//! use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
//! use ppnpack_packing::scene::Scene;
//! use ppnpack_robot::arms;
//! use ppnpack_robot::cell::CellSettings;
//! use ppnpack_robot::motion::{PlacePlanner, Placing};
//! use ppnpack_robot::pick;
//! use ppnpack_robot::surface::UpperSurface;
//!
//! let sides = Bounds { lowest: [0.0; 3].into(), highest: [0.12, 0.08, 0.06].into() };
//! let (carton, _) = model("carton", sides.mesh(), &ModelSettings::default())?;
//! let grid = Grid::reference();
//! let item = views::item(&carton, grid.resolution())?;
//!
//! let cell = CellSettings::default();
//! let mut planner = PlacePlanner::new(Arc::new(arms::arm("nachi-mz07l")?), cell.clone())?;
//! let surface = UpperSurface::of_model(&carton, 0.001).ok_or("the carton has no surface")?;
//! let pick = pick::find(&surface, planner.arm().gripper(), &cell.pick)?;
//! let motion = planner.plan(&Placing {
//!     grid: &grid,
//!     scene: &Scene::from_heightmap(Heightmap::empty(&grid)),
//!     item: &item,
//!     resting: &RestingPlacement { placement: Placement { yaw: 0, x: 10, y: 12 }, resting_height: 0 },
//!     pick: &pick,
//! })?;
//! // The cup lets go at the carton's top, 6 cm above the floor.
//! assert!((motion.release.z - 0.06).abs() < 0.002);
//! assert!(motion.approach.z > grid.container().z_m);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod arm;
pub mod arms;
pub mod cell;
mod clearance;
mod columns;
pub mod cycle;
pub mod error;
pub mod feasibility;
pub mod gripper;
pub mod joints;
pub mod kinematics;
pub mod motion;
pub mod parameters;
pub mod path;
pub mod pick;
pub mod refusal;
pub mod shapes;
pub mod station;
pub mod surface;
mod surroundings;
mod track;
pub mod trajectory;
