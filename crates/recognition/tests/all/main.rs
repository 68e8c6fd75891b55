//! Objects recognised, and placed items found again, in simulated views.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod common;
mod geometry;
mod inspection;
mod recognition;
#[path = "../../../../tests/shapes.rs"]
mod shapes;
#[path = "../../../../tests/shared.rs"]
mod shared;
mod shared_data;
