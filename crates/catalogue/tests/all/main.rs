//! Folders of meshes, and real objects.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod folders;
#[path = "../../../packing/tests/golden/cases.rs"]
mod golden;
#[path = "../../../../tests/shared.rs"]
mod shared;
mod shared_data;
