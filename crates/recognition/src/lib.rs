//! Which catalogue object a point cloud shows, and how it lies.
//!
//! [`segmentation`] finds the items on a support; a [`library::Library`] holds the objects that can be recognised, prepared
//! once; a [`recognise::Recogniser`] says of each item which object it is and in which pose, or that it is unknown, and why.
//! Both can be packed: a known one as it lies ([`posed`]), an unknown one as far as it was seen ([`unknown_item`]).
//! Whether an item lies where it was placed, [`inspection`] tells.
//!
//! The crate is pure and synchronous; it knows neither the wire nor any sensor.

mod align;
mod coarse;
pub mod evaluation;
pub mod expected;
pub mod inspection;
pub mod library;
pub mod nearest;
mod outline;
mod polish;
pub mod posed;
pub mod recognise;
mod rectangle;
mod rest;
pub mod samples;
pub mod segmentation;
mod spacing;
pub mod support;
pub mod symmetry;
pub mod twins;
pub mod unknown_item;
