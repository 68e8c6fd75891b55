//! The method that experiments vary.

use ppnpack_packing::method::{Method, ProposalSource, Stability};
use ppnpack_packing::trial::TrialSettings;

/// SDF minimisation over all items of the buffer together.
pub(crate) fn sdfm(
    proposals: ProposalSource,
    stability: Stability,
    buffer: usize,
    seed: u64,
) -> Method {
    Method {
        proposals,
        stability,
        trial: TrialSettings::off(),
        buffer,
        seed,
        ..Method::default()
    }
}
