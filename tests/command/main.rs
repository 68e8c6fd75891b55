//! The command end to end, as a user runs it.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

mod carton;
mod cube;
mod inputs;
mod pack;
mod perceive;
#[path = "../printed.rs"]
mod printed;
mod recording;
mod report;
mod support;
mod up;
