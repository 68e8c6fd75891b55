//! The command end to end, as a user runs it.

#![cfg(test)]

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
