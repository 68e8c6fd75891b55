//! Objects recognised, and placed items found again, in simulated views.
#![cfg(test)]

mod common;
mod geometry;
mod inspection;
mod recognition;
#[path = "../../../../tests/shapes.rs"]
mod shapes;
#[path = "../../../../tests/shared.rs"]
mod shared;
mod shared_data;
