//! The stages of Algorithm 1 that other services carry out, as [`packing`](ppnpack_packing) knows stages.

mod evaluator;
mod items;
mod local;
mod pace;
mod peers;
mod proposer;
mod source;
mod split;

pub(crate) use evaluator::SharedEvaluator;
pub(crate) use local::LocalSearches;
pub(crate) use peers::Peers;
pub(crate) use proposer::RemoteProposer;
