//! The stages of Algorithm 1 that other services carry out, as [`packing`](ppnpack_packing) knows stages.

mod evaluator;
mod items;
mod peers;
mod proposer;

pub(crate) use evaluator::ServiceEvaluator;
pub(crate) use peers::Peers;
pub(crate) use proposer::RemoteProposer;
