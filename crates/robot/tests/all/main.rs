//! The arm from outside.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod common;
mod cycle;
mod feasibility;
mod kinematics;
mod oracle;
mod pick;
mod station;
