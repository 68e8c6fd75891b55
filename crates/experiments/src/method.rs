//! The method that experiments vary.

use ppnpack_cli::options::{Method, ProposalSource, StabilityOption};
use ppnpack_packing::objective::{Heuristic, Order, Weights};

/// SDF minimisation over all items of the buffer together, without an arm.
pub(crate) fn sdfm(
    proposals: ProposalSource,
    stability: StabilityOption,
    buffer: usize,
    seed: u64,
) -> Method {
    Method {
        heuristic: Heuristic::Sdfm,
        order: Order::Balance,
        proposals,
        stability,
        arm: None,
        weights: Weights::default(),
        buffer,
        seed,
    }
}
