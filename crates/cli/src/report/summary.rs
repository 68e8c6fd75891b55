//! The figures of a packing.

use std::collections::BTreeMap;
use std::time::Duration;

use ppnpack_packing::episode::{Ending, SetAside, steps_widened};
use ppnpack_packing::metrics::Metrics;
use ppnpack_packing::plan::{Candidate, Timings};
use serde::Serialize;

use super::arm::ArmWork;
use super::{Packing, Settings};

/// What `summary.json` holds.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Summary {
    pub(crate) version: &'static str,
    pub(crate) items_in_sequence: usize,
    pub(crate) items_placed: usize,
    /// Placed, but not inside the container at the end.
    pub(crate) items_fallen_out: usize,
    /// Toppled, slid by more than 2 cm or left the container when they were placed.
    pub(crate) items_unsteady: usize,
    /// Placed in another pose than that in which they were offered.
    pub(crate) items_in_other_pose: usize,
    /// The placement that brought an item nearest to what it may carry, as estimated; absent where none loaded one with a limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) nearest_limit: Option<NearestLimit>,
    #[serde(flatten)]
    pub(crate) metrics: Metrics,
    pub(crate) height_m: f64,
    pub(crate) decision_s: Spread,
    /// Mean time per packed item in each stage, in seconds.
    pub(crate) stages_s: Stages,
    /// Steps that were searched exhaustively as none of their proposals was valid.
    pub(crate) steps_widened: usize,
    /// Why steps were not planned as was asked for; empty where all were.
    pub(crate) degraded: Vec<Degraded>,
    pub(crate) took_s: f64,
    /// The arm's part, where there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) arm: Option<ArmWork>,
    /// Items that were set aside for the next container, in this order.
    pub(crate) set_aside: Vec<Unplaceable>,
    pub(crate) ending: EndingSummary,
    pub(crate) settings: Settings,
}

/// What an item carries as estimated, against what it may.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct NearestLimit {
    /// From 0.
    pub(crate) step: u64,
    /// The item that carries.
    pub(crate) item: String,
    pub(crate) estimated_kg: f64,
    pub(crate) carries_kg: f64,
}

/// Decision time per packed item, in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(crate) struct Spread {
    pub(crate) mean: f64,
    pub(crate) median: f64,
    pub(crate) max: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(crate) struct Stages {
    pub(crate) propose: f64,
    pub(crate) evaluate: f64,
    pub(crate) check: f64,
}

/// Steps that were planned in another way than was asked for, and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(crate) struct Degraded {
    pub(crate) reason: String,
    pub(crate) steps: usize,
}

/// Why the episode ended.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub(crate) enum EndingSummary {
    /// The whole sequence is packed.
    AllPacked,
    /// All that was not set aside is packed.
    OthersSetAside,
    /// Nothing in the buffer had a valid placement.
    NothingFits {
        /// Each item of the buffer.
        items: Vec<Unplaceable>,
    },
}

/// An item that was not placed, and why.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Unplaceable {
    pub(crate) arrival: usize,
    pub(crate) item: String,
    pub(crate) reason: String,
}

impl Unplaceable {
    /// An item, and why it was not placed.
    pub(crate) fn new(candidate: &Candidate, reason: String) -> Self {
        Self {
            arrival: candidate.arrival,
            item: candidate.item.name().to_string(),
            reason,
        }
    }
}

impl From<&SetAside> for Unplaceable {
    fn from(item: &SetAside) -> Self {
        let reason = item.reason.as_ref().map(ToString::to_string);
        let unknown = || "no valid placement was found".to_owned();
        Self::new(&item.candidate, reason.unwrap_or_else(unknown))
    }
}

impl EndingSummary {
    /// The end of an episode.
    pub(crate) fn new(ending: &Ending) -> Self {
        let items = match ending {
            Ending::AllPacked => return Self::AllPacked,
            Ending::OthersSetAside => return Self::OthersSetAside,
            Ending::NothingFits(items) => items.iter(),
        };
        let items = items.map(|(candidate, why)| Unplaceable::new(candidate, why.to_string()));
        Self::NothingFits {
            items: items.collect(),
        }
    }
}

impl Spread {
    pub(crate) fn of(durations: impl Iterator<Item = Duration>) -> Self {
        let mut seconds: Vec<f64> = durations.map(|duration| duration.as_secs_f64()).collect();
        seconds.sort_by(f64::total_cmp);
        let count = seconds.len().max(1) as f64;
        Self {
            mean: seconds.iter().sum::<f64>() / count,
            median: seconds.get(seconds.len() / 2).copied().unwrap_or(0.0),
            max: seconds.last().copied().unwrap_or(0.0),
        }
    }
}

impl Packing {
    /// The figures.
    pub(crate) fn summary(&self) -> Summary {
        let steps = &self.steps;
        let turned = steps.iter().filter(|step| step.candidate.pose > 0).count();
        let unit_m = self.settings.grid.resolution().height_unit_m();
        let mean = |stage: fn(&Timings) -> Duration| {
            let total: Duration = steps.iter().map(|step| stage(&step.timings)).sum();
            total.as_secs_f64() / steps.len().max(1) as f64
        };
        Summary {
            version: env!("CARGO_PKG_VERSION"),
            items_in_sequence: self.settings.sequence.objects.len(),
            items_placed: steps.len(),
            items_fallen_out: steps.len() - self.metrics.packed.items,
            items_unsteady: self
                .settled
                .iter()
                .filter(|placed| placed.is_unsteady())
                .count(),
            items_in_other_pose: turned,
            nearest_limit: self.nearest_limit(),
            metrics: self.metrics,
            height_m: f64::from(self.scene.heightmap().max()) * unit_m,
            decision_s: Spread::of(steps.iter().map(|step| step.timings.total())),
            stages_s: Stages {
                propose: mean(|timings| timings.propose),
                evaluate: mean(|timings| timings.evaluate),
                check: mean(|timings| timings.check),
            },
            steps_widened: steps_widened(steps),
            degraded: self.degraded(),
            took_s: self.took.as_secs_f64(),
            arm: self.arm.as_ref().map(|arm| arm.with_cycles(steps)),
            set_aside: self.set_aside.clone(),
            ending: self.ending.clone(),
            settings: self.settings.clone(),
        }
    }

    fn nearest_limit(&self) -> Option<NearestLimit> {
        let loads = self.steps.iter();
        let loads = loads.filter_map(|step| Some((step, step.evidence.load.as_ref()?)));
        let nearest = loads.max_by(|(_, one), (_, other)| one.share().total_cmp(&other.share()));
        nearest.map(|(step, load)| NearestLimit {
            step: step.step,
            item: load.item.clone(),
            estimated_kg: load.estimated_kg,
            carries_kg: load.carries_kg,
        })
    }

    fn degraded(&self) -> Vec<Degraded> {
        let steps = self.steps.iter().filter(|step| !step.degraded.is_empty());
        let counts = counted(steps.map(|step| step.degraded.join("; ")));
        let counts = counts.into_iter();
        counts
            .map(|(reason, steps)| Degraded { reason, steps })
            .collect()
    }
}

/// How often each comes, in their order.
pub(super) fn counted<T: Ord>(all: impl Iterator<Item = T>) -> BTreeMap<T, usize> {
    let mut counts = BTreeMap::new();
    for one in all {
        *counts.entry(one).or_default() += 1;
    }
    counts
}
