//! The bridge from outside: one program, as linking what carries messages takes long.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod common;
mod expiring;
mod holding;
mod placing;
mod remote;
mod scanning;
