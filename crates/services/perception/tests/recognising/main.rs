//! Items that are recognised on trays, and found again after they were placed, over real sessions.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

mod inspecting;
mod rig;
mod trays;
