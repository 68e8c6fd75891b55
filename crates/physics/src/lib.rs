//! The simulated robot cell: an open container into which items are released, what becomes of
//! them, and how high the content stands.
//!
//! [`SimulatedCell`](cell::SimulatedCell) releases items at planned poses, lets them fall and settle, and says where
//! they ended; it scans the container into the surface that the next placement is planned on.
//!
//! All positions are in the container frame: metres, right-handed, z up, the origin at an inner bottom corner. The
//! simulation is single-threaded, and the same settings and the same calls give the same bits.

mod body;
pub mod cell;
mod container;
mod convert;
pub mod error;
mod noise;
pub mod outcome;
mod overlap;
pub mod packing_cell;
pub mod settings;
mod surface;
mod world;
