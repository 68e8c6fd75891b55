//! The arm's part in a packing.

use std::collections::BTreeMap;
use std::time::Duration;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::ranking::refusal::Cause;
use ppnpack_packing::streams::episode::{Episode, Step};
use ppnpack_robot::parameters::ArmParameters;
use ppnpack_robot::station::ArmStation;
use serde::Serialize;

use super::summary::{Spread, Unplaceable};
use crate::sequence::Sequence;

/// The arm's part in a packing, as `summary.json` has it.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct ArmWork {
    /// The planned time from one pick to the next, in seconds; zeros before there are steps.
    pub(crate) cycle_s: Spread,
    /// The questions to its check; none where it ran in a service.
    #[serde(flatten)]
    pub(crate) asked: Option<ArmAsked>,
    /// Items of the sequence that it cannot hold or lift: they were not there to be packed.
    pub(crate) set_aside: Vec<Unplaceable>,
    /// The arm, its stand, and its gripper.
    pub(crate) parameters: ArmParameters,
}

/// The questions to an arm's check.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct ArmAsked {
    /// The number of placements that it was asked for.
    checks: u64,
    /// The number of them that it refused, by reason.
    refused: BTreeMap<String, u64>,
}

impl ArmAsked {
    /// Counts those of an episode with an arm: it is asked last, so what is valid was accepted by
    /// it.
    pub(crate) fn of(episode: &Episode) -> Self {
        let steps = episode.steps.iter();
        let accepted: usize = steps.map(|step| 1 + step.alternatives.len()).sum();
        let refused = episode.refusals.iter();
        let refused = refused.filter(|(refusal, _)| refusal.cause == Cause::Arm);
        let refused = refused.map(|(refusal, count)| {
            let detail = refusal.detail.as_deref().unwrap_or_default();
            (detail.to_owned(), count)
        });
        let refused: BTreeMap<String, u64> = refused.collect();
        Self {
            checks: accepted as u64 + refused.values().sum::<u64>(),
            refused,
        }
    }
}

impl ArmWork {
    /// Begins with an arm that has not packed anything yet; what it cannot hold or lift is taken
    /// out of its sequence.
    pub(crate) fn new(
        station: &ArmStation,
        sequence: &mut Sequence,
        catalogue: &Catalogue,
    ) -> Self {
        Self {
            cycle_s: Spread::default(),
            asked: None,
            set_aside: sequence.set_aside(catalogue, station),
            parameters: station.parameters().clone(),
        }
    }

    /// Adds the cycles of these steps.
    pub(super) fn with_cycles(&self, steps: &[Step]) -> Self {
        let cycles_s = steps.iter().filter_map(Step::cycle_s);
        Self {
            cycle_s: Spread::of(cycles_s.map(Duration::from_secs_f64)),
            ..self.clone()
        }
    }
}
