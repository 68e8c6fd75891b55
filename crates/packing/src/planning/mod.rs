//! The step: Algorithm 1 over one container, and over several that are open.
//!
//! [`Planner`](plan::Planner) proposes, ranks and checks; [`Method`](method::Method) is its
//! settings, and makes it.

pub mod containers;
pub mod method;
pub mod plan;
pub mod survey;
pub mod valid;
