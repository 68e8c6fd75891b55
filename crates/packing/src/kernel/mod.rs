//! The kernel: grid, heightmaps, items, resting heights, objectives.
//!
//! Everything here is a function of numbers on a grid. It knows no step, no order, no check; the
//! inner loops are in `lanes.rs`, and the layout that they read is made in `layout.rs`.

pub(crate) mod clock;
pub mod distance;
pub mod grid;
pub mod heightmap;
mod inside;
pub mod item;
pub(crate) mod lanes;
pub(crate) mod layout;
pub mod objective;
pub mod placement;
pub(crate) mod polygon;
pub(crate) mod random;
pub mod rectangle;
pub mod resting;
