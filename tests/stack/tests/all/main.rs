//! The services as processes: one program, as linking what carries messages takes long.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod clocks;
mod commands;
mod common;
mod console;
mod containers;
mod controllers;
mod disk;
mod faults;
mod hostile;
mod leases;
mod stopping;
mod traces;
