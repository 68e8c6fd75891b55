//! The planner from outside: one program, as linking what carries messages takes long.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod believing;
mod bridges;
mod common;
mod containers;
mod contradicting;
mod counting;
mod inspecting;
mod interrupting;
mod limits;
mod loads;
mod orders;
mod poses;
mod replaying;
mod setting_aside;
mod stateless;
mod trying;
mod two_controllers;
mod versions;
