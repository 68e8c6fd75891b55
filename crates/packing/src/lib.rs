//! The packing domain of ppnpack: scene in, placement out.
//!
//! A [`Planner`](plan::Planner) plans one step by Algorithm 1 of the PPN-Pack paper: a
//! [`Proposer`](proposals::Proposer) says which placements of the buffer's items are worth
//! evaluating, an [`Evaluator`](evaluator::Evaluator) ranks them by a packing heuristic, and the
//! best one that every [`ValidityCheck`](check::ValidityCheck) accepts is chosen.
//!
//! The crate is pure and synchronous: no wire, no async, no network library.
//!
//! What the engine says of every placement of a block in an empty container:
//!
//! ```
//! use ppnpack_packing::grid::Grid;
//! use ppnpack_packing::heightmap::Heightmap;
//! use ppnpack_packing::item::{Item, ViewSurfaces};
//! use ppnpack_packing::objective::{Heuristic, Weights};
//! use ppnpack_packing::survey::survey;
//!
//! // Heights are in units of 2 mm.
//! let surfaces = ViewSurfaces::of_cells(6, 4, vec![25; 24], vec![0; 24]);
//! let block = Item::new("block", vec![surfaces], 0.0)?;
//! let grid = Grid::reference();
//! let empty = Heightmap::empty(&grid);
//! let placements = survey(&grid, &empty, &block.views()[0], Heuristic::Sdfm, &Weights::default())?;
//! let valid = placements.iter().filter(|at| at.fits && at.is_stable);
//! let best = valid.min_by(|a, b| a.value.total_cmp(&b.value)).ok_or("nothing is valid")?;
//! assert_eq!((best.x, best.y, best.resting_height), (0, 0, 0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A whole step is planned in the example of the README, which is compiled and run with the tests.

pub mod blocked;
pub mod buffer;
pub mod candidate;
pub mod carton;
pub mod check;
pub mod closing;
pub mod coarse;
pub mod containers;
pub mod content;
pub mod distance;
pub mod episode;
pub mod evaluator;
pub mod expected;
pub mod grid;
pub mod heightmap;
pub mod hidden;
mod inside;
pub mod item;
mod kernel;
mod layout;
pub mod leaving;
pub mod loads;
pub mod method;
pub mod metrics;
pub mod model;
pub mod motion;
pub mod objective;
pub mod orders;
pub mod placement;
pub mod plan;
pub mod proposals;
mod random;
pub mod rectangle;
pub mod refusal;
pub mod resting;
pub mod rules;
pub mod scene_value;
pub mod search;
pub mod stability;
pub mod step;
pub mod stream;
pub mod survey;
pub mod trial;
pub mod valid;

/// Compiles the example of the README.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

/// Compiles and runs the example of the guide of a heuristic of one's own.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guides/own-heuristic.md")]
struct OwnHeuristic;
