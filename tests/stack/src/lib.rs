//! A whole stack of real processes on this machine: a router, and services that connect to it.
//!
//! The processes are those that lie beside the program that uses this crate: build them first, as `scripts/test` and
//! `scripts/bench-stack` do.

pub mod cell;
pub mod faults;
pub mod latency;
mod process;
pub mod records;
pub mod soak;
mod stack;

pub use process::{Signal, beside};
pub use stack::{Options, Stack};
