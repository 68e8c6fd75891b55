//! Clouds to scenes, and containers found in clouds.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod calibrating;
mod doubts;
mod hidden;
mod mapping;
mod simulated;
