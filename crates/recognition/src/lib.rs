//! Which catalogue object a point cloud shows, and how it lies.
//!
//! [`segmentation`] finds the items on a support; a [`library::Library`] holds the objects that can be recognised, prepared
//! once; a [`recognise::Recogniser`] says of each item which object it is and in which pose, or that it is unknown, and why.
//! An item that is unknown can be packed all the same ([`unknown_item`]).
//!
//! The crate is pure and synchronous; it knows neither the wire nor any sensor.

mod align;
mod coarse;
pub mod evaluation;
pub mod expected;
pub mod library;
pub mod nearest;
mod outline;
mod polish;
pub mod recognise;
mod rest;
pub mod samples;
pub mod segmentation;
mod spacing;
pub mod support;
pub mod symmetry;
pub mod twins;
pub mod unknown_item;
