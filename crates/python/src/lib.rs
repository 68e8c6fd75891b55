//! The native part of the Python package `ppnpack`: the engine over NumPy arrays.
//!
//! Each file binds one thing of the engine, and keeps to its words; what a class or a function
//! means in Python is said in its docstring, and its types in `python/ppnpack/_native.pyi`. Rules
//! that all of them follow:
//!
//! - Whatever computes is called with the interpreter's lock released.
//! - Heights are `int16` in units of the grid, as in the engine; arrays are C-contiguous, indexed
//!   `[yaw, x, y]`.
//! - An array that is returned was moved into Python without a copy. An array that is given is read
//!   where it lies; the engine keeps
//!   its own copy of a heightmap or an item's surfaces.
//! - What is wrong with an input is a `ValueError`, what went wrong on the way a `RuntimeError`, in
//!   the engine's words.

#![expect(
    clippy::needless_pass_by_value,
    reason = "the interpreter's arguments are given by value"
)]

mod arrays;
mod catalogue;
mod cell;
mod error;
mod evaluation;
mod evaluator;
mod grid;
mod item;
mod packing;
mod packings;
mod placement;
mod plan;
mod planner;
mod scene;
mod settings;

#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::catalogue::Catalogue;
    #[pymodule_export]
    use crate::cell::{Body, PlacedReport, SimulatedCell};
    #[pymodule_export]
    use crate::evaluation::{Evaluation, evaluate, resting_heights};
    #[pymodule_export]
    use crate::grid::Grid;
    #[pymodule_export]
    use crate::item::Item;
    #[pymodule_export]
    use crate::packings::{Observation, Packings, Stepped};
    #[pymodule_export]
    use crate::placement::{Placement, place};
    #[pymodule_export]
    use crate::plan::Plan;
    #[pymodule_export]
    use crate::planner::Planner;
    #[pymodule_export]
    use crate::scene::Scene;
}
