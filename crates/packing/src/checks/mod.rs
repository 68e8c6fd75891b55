//! Checks of a placement: stability, loads, order of leaving, and what tries and arms are asked.
//!
//! Each is a [`ValidityCheck`](check::ValidityCheck); a new one is listed in
//! [`Method::build_with`](crate::planning::method::Method::build_with). Checks that simulate, or
//! know an arm, are in crates above.

pub mod check;
pub mod loads;
pub mod motion;
pub mod rules;
pub mod sequence;
pub mod stability;
pub mod trial;
