//! The simulated robot cell: an open container into which items are released, what becomes of them, and what
//! a camera above it sees.
//!
//! [`SimulatedCell`](cell::SimulatedCell) releases items at planned poses, lets them fall and settle, and says where
//! they ended; it scans the container into the surface that the next placement is planned on.
//! [`DepthCamera`](camera::DepthCamera) renders the same content as a depth image or a point cloud.
//!
//! All positions are in the container frame: metres, right-handed, z up, the origin at an inner bottom corner. The
//! simulation is single-threaded, and the same settings and the same calls give the same bits.

mod body;
pub mod camera;
pub mod cell;
mod container;
mod convert;
pub mod error;
pub mod outcome;
mod overlap;
pub mod packing_cell;
pub mod settings;
mod surface;
mod world;
