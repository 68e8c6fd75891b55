//! The figures of a packing.

use std::collections::BTreeMap;
use std::time::Duration;

use ppnpack_packing::checks::trial::RIM_TOLERANCE_M;
use ppnpack_packing::ranking::step::{Candidate, Timings};
use ppnpack_packing::streams::episode::{Ending, SetAside, steps_widened};
use ppnpack_packing::streams::metrics::Metrics;
use ppnpack_physics::outcome::above_rim_m;
use serde::Serialize;

use super::arm::ArmWork;
use super::{Packing, Settings};
use crate::text::{render, table, template};

/// The content of `summary.json`.
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
    /// The placement that brought an item nearest to what it may carry, as estimated; absent where
    /// none loaded one with a limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) nearest_limit: Option<NearestLimit>,
    #[serde(flatten)]
    pub(crate) metrics: Metrics,
    pub(crate) height_m: f64,
    /// The items that end higher than the rim by more than a millimetre, the highest first.
    pub(crate) above_rim: Vec<AboveRim>,
    pub(crate) decision_s: Spread,
    /// Mean time per packed item in each stage, in seconds.
    pub(crate) stages_s: Stages,
    /// Steps that were searched exhaustively as none of their proposals was valid.
    pub(crate) steps_widened: usize,
    /// The reasons why steps were not planned as was asked for; empty where all were.
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

/// An item that ends above the rim, and by how much.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct AboveRim {
    pub(crate) item: String,
    pub(crate) by_m: f64,
}

/// The load of an item as estimated, against its limit.
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

/// The reason why the episode ended.
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
    /// Makes it of an item, and the reason why it was not placed.
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
    /// Converts the end of an episode.
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
        let at = |index: usize| seconds.get(index).copied().unwrap_or(0.0);
        let (half, other) = (seconds.len() / 2, seconds.len().saturating_sub(1) / 2);
        Self {
            // The sum of nothing is -0.0.
            mean: (0.0 + seconds.iter().sum::<f64>()) / count,
            median: (at(half) + at(other)) / 2.0,
            max: seconds.last().copied().unwrap_or(0.0),
        }
    }
}

impl Summary {
    /// Renders its figures, a name and a value a line.
    pub(super) fn figures(&self) -> anyhow::Result<String> {
        render(template!("figures.txt"), self)
    }

    /// Renders its figures for people, and what did not go well.
    pub(crate) fn table(&self) -> anyhow::Result<String> {
        let problems = render(template!("problems.txt"), self)?;
        Ok(table(&(self.figures()? + &problems), false).to_string())
    }
}

impl Packing {
    /// Gives the figures.
    pub(crate) fn summary(&self) -> Summary {
        let steps = &self.steps;
        let turned = steps.iter().filter(|step| step.candidate.pose > 0).count();
        let unsteady = self.settled.iter().filter(|placed| placed.is_unsteady());
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
            items_unsteady: unsteady.count(),
            items_in_other_pose: turned,
            nearest_limit: self.nearest_limit(),
            metrics: self.metrics,
            height_m: f64::from(self.scene.heightmap().highest_content(&self.settings.grid))
                * unit_m,
            above_rim: self.above_rim(),
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

    fn above_rim(&self) -> Vec<AboveRim> {
        let container = self.settings.grid.container();
        let placed = self.contents.iter().map(|(_, body)| body);
        let all = placed.chain(&self.preloaded);
        let inside = all.filter(|body| body.inside);
        let above = inside.map(|body| AboveRim {
            item: body.model.name.clone(),
            by_m: above_rim_m(container, &body.model.mesh, &body.container_from_item),
        });
        let mut above: Vec<_> = above.filter(|item| item.by_m > RIM_TOLERANCE_M).collect();
        above.sort_by(|one, other| other.by_m.total_cmp(&one.by_m));
        above
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
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for step in steps {
            *counts.entry(step.degraded.join("; ")).or_default() += 1;
        }
        let degraded = counts
            .into_iter()
            .map(|(reason, steps)| Degraded { reason, steps });
        degraded.collect()
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::kernel::grid::Grid;
    use ppnpack_packing::planning::method::ProposalSource;
    use serde_json::{Value, json};

    use super::*;

    /// A packing with an arm in which something went wrong of every kind.
    fn packed() -> Value {
        let spread = json!({"mean": 0.0125, "median": 0.01, "max": 1.5});
        let left = json!([{"item": "mug", "reason": "too large"}]);
        json!({
            "items_in_sequence": 3,
            "items_placed": 2,
            "items_fallen_out": 1,
            "items_unsteady": 1,
            "items_in_other_pose": 1,
            "packed": {"items": 1, "meshes_m3": 0.001, "voxels_m3": 0.002},
            "floor_compactness": 0.5,
            "box_compactness": 0.5,
            "mesh_floor_compactness": 0.5,
            "utilisation": 0.5,
            "height_m": 0.3042,
            "above_rim": [{"item": "plate", "by_m": 0.0042}, {"item": "mug", "by_m": 0.002}],
            "decision_s": spread,
            "took_s": 2.0,
            "steps_widened": 1,
            "nearest_limit": {"step": 0, "item": "cup", "estimated_kg": 0.1, "carries_kg": 0.2},
            "degraded": [{"reason": "no network", "steps": 2}],
            "set_aside": left,
            "ending": {"kind": "nothing-fits", "items": left},
            "arm": {
                "parameters": {"name": "An arm"},
                "cycle_s": spread,
                "checks": 5,
                "refused": {"out of reach": 3},
                "set_aside": left,
            },
            "settings": {
                "sequence": {"from": "--items"},
                "set_aside": 2,
                "poses": 2,
                "grid": Grid::reference(),
                "method": {"proposals": ProposalSource::Random { percent: 5.0 }},
            },
        })
    }

    #[test]
    fn a_packing_of_nothing_took_no_time() {
        let none = Spread::of(std::iter::empty());
        assert_eq!(format!("{} {}", none.mean, none.median), "0 0");
    }

    #[test]
    fn every_figure_and_every_problem_has_its_line() {
        let figures = render(template!("figures.txt"), packed()).unwrap();
        let problems = render(template!("problems.txt"), packed()).unwrap();
        let told = figures + &problems;
        for line in [
            "Proposals │ random, K = 5.0 %",
            "Height │ 30.4 cm",
            "Above the rim │ 2 items, by 4 mm at most: plate, mug",
            "Packed │ 1 of 3 items, 1 more fell out",
            "Decision per item │ 12.50 ms mean, 10.00 ms median, 1.5 s at most",
            "Ended because │ none of the 1 items in the buffer has a valid placement",
            "Nearest to what it may carry │ cup with 0.10 of 0.20 kg, since step 1",
            "Set aside │ 1 of at most 2 items",
            "In another pose than offered │ 1 of 2 items",
            "Arm checks │ 5 placements, 3 refused",
            "refused by the arm │ 3 placements: out of reach",
            "set aside │ 1 items: too large",
            "not as asked for │ 2 steps: no network",
            "could not be placed │ mug: too large",
        ] {
            assert!(told.lines().any(|of| of == line), "{line}: {told}");
        }
    }
}
