//! The perception service over real sessions: heightmaps, items that are recognised on trays and
//! found again after they were placed.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

mod inspecting;
#[path = "../../../../wire/tests/support/payload.rs"]
mod payload;
mod rig;
mod ros;
mod serving;
mod trays;
