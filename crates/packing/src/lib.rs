//! The packing domain of ppnpack: scene in, placement out.
//!
//! A [`Planner`](plan::Planner) plans one step by Algorithm 1 of the PPN-Pack paper: a
//! [`Proposer`](proposals::Proposer) says which placements of the buffer's items are worth evaluating, an
//! [`Evaluator`](plan::Evaluator) ranks them by a packing heuristic, and the best one that every
//! [`ValidityCheck`](check::ValidityCheck) accepts is chosen.
//!
//! The crate is pure and synchronous: no wire, no async, no network library.

pub mod blocked;
pub mod buffer;
pub mod check;
pub mod coarse;
pub mod distance;
pub mod episode;
pub mod grid;
pub mod heightmap;
pub mod item;
mod kernel;
pub mod metrics;
pub mod objective;
pub mod oracle;
pub mod placement;
pub mod plan;
pub mod proposals;
mod random;
pub mod resting;
mod resting_maps;
pub mod search;
pub mod stability;
pub mod step;
pub mod survey;
pub mod valid;

/// Compiles the example of the README.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
