//! The packing domain of ppnpack: scene in, placement out.
//!
//! Pure and synchronous: no wire, no async, no network library.

pub mod grid;
pub mod heightmap;
pub mod item;
pub mod placement;
