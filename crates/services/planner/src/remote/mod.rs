//! The stages of Algorithm 1 that other services carry out, as [`packing`](ppnpack_packing) knows stages.

mod context;
mod evaluator;
mod items;
mod local;
mod merge;
mod pace;
mod proposer;
mod split;

pub(crate) use context::StepContext;
pub(crate) use evaluator::{Judgement, SharedEvaluator};
pub(crate) use proposer::RemoteProposer;
