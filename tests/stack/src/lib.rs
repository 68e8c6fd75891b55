//! A whole stack of real processes on this machine: a router, and services that connect to it.
//!
//! The processes are those that lie beside the program that uses this crate: build them first, as `scripts/test` and
//! `scripts/bench-stack` do.

pub mod cell;
pub mod clock;
pub mod disk;
pub mod faults;
pub mod http;
pub mod latency;
pub mod mix;
mod process;
pub mod records;
pub mod report;
pub mod soak;
mod stack;
pub mod tray;

pub use process::{Signal, beside};
pub use stack::{Options, Stack};
