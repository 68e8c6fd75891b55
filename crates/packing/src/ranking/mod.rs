//! The candidates of a step, and their placements by increasing value.
//!
//! A [`Proposer`](proposals::Proposer) names placements, an [`Evaluator`](evaluator::Evaluator)
//! ranks them. A new term of the objective is one of [`Weights`](crate::kernel::objective::Weights);
//! an evaluator of one's own stands in place of [`Search`](search::Search).

pub mod candidate;
pub mod coarse;
pub mod evaluator;
pub mod proposals;
pub mod refusal;
pub mod scene_value;
pub mod search;
pub mod step;
