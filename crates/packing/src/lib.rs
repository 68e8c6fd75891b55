//! The packing domain of ppnpack: scene in, placement out.
//!
//! A [`Planner`](planning::plan::Planner) plans one step by Algorithm 1 of the PPN-Pack paper: a
//! [`Proposer`](ranking::proposals::Proposer) says which placements of the buffer's items are worth
//! evaluating, an [`Evaluator`](ranking::evaluator::Evaluator) ranks them by a packing heuristic,
//! and the best one that every [`ValidityCheck`](checks::check::ValidityCheck) accepts is chosen.
//!
//! Each room uses those before it alone: [`kernel`], [`scene`], [`ranking`], [`checks`],
//! [`planning`], [`streams`]. The crate is pure and synchronous: no wire, no async, no network
//! library.
//!
//! What the engine says of every placement of a block in an empty container:
//!
//! ```
//! use ppnpack_packing::kernel::grid::Grid;
//! use ppnpack_packing::kernel::heightmap::Heightmap;
//! use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
//! use ppnpack_packing::kernel::objective::{Heuristic, Weights};
//! use ppnpack_packing::planning::survey::survey;
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

pub mod checks;
pub mod kernel;
pub mod planning;
pub mod ranking;
pub mod scene;
pub mod streams;

/// Compiles the example of the README.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

/// Compiles and runs the example of the guide of a heuristic of one's own.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guides/own-heuristic.md")]
struct OwnHeuristic;
