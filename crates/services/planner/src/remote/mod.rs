//! The stages of Algorithm 1, as [`packing`](ppnpack_packing) has them, by other services.

mod evaluator;
mod items;
mod peers;
mod proposer;

pub(crate) use evaluator::ServiceEvaluator;
pub(crate) use peers::Peers;
pub(crate) use proposer::RemoteProposer;
