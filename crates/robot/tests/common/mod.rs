//! Random placements, and a brute-force oracle for the motions that make them.
#![allow(dead_code, reason = "each test, example and bench uses a part of this")]
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

pub(crate) mod oracle;
pub(crate) mod scenes;
