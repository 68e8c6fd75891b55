//! The simulated cell from outside.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod common;
mod determinism;
mod household;
mod laying_down;
mod loads;
mod placing;
mod scanning;
mod seen;
#[path = "../../../../tests/shapes.rs"]
mod shapes;
#[path = "../../../../tests/shared.rs"]
mod shared;
mod tapered;
mod trial;
mod trial_loads;
mod twin;
