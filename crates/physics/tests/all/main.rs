//! The simulated cell from outside.
#![cfg(test)]

mod common;
mod determinism;
mod household;
mod laying_down;
mod loads;
mod placing;
mod scanning;
mod seen;
#[path = "../../../../tests/shapes.rs"]
mod shapes;
#[path = "../../../../tests/shared.rs"]
mod shared;
mod tapered;
mod trial;
mod trial_loads;
mod twin;
