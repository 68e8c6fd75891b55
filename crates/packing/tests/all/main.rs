//! The engine against slow references, golden vectors and examples, in one program.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod allocations;
mod coarse;
mod drawn;
mod expected;
mod golden;
mod hidden;
mod invariants;
mod kernels;
mod limits;
mod loads;
mod orders;
mod planning;
mod raster;
mod scene_value;
mod search;
mod setting_aside;
mod streams;
mod support;
mod tapered;
