//! What the arm had to do with a packing.

use std::collections::BTreeMap;
use std::time::Duration;

use ppnpack_packing::episode::Episode;
use ppnpack_packing::refusal::Cause;
use ppnpack_robot::parameters::ArmParameters;
use ppnpack_robot::station::ArmStation;
use serde::Serialize;

use super::summary::{Spread, Unplaceable};

/// The arm's part in a packing.
#[derive(Debug, Clone)]
pub(crate) struct ArmWork {
    pub(crate) parameters: ArmParameters,
    /// Items of the sequence that it cannot hold or lift: they were not there to be packed.
    pub(crate) set_aside: Vec<Unplaceable>,
    /// Per step: the planned time of the cycle, in seconds.
    pub(crate) cycles_s: Vec<Option<f64>>,
    /// What its check was asked; none where it ran in a service.
    pub(crate) asked: Option<ArmAsked>,
}

/// What an arm's check was asked.
#[derive(Debug, Clone)]
pub(crate) struct ArmAsked {
    /// For how many placements.
    checks: u64,
    /// How many of them it refused, by reason.
    refused: BTreeMap<String, u64>,
}

impl ArmAsked {
    /// Of an episode with an arm: it is asked last, so what is valid was accepted by it.
    pub(crate) fn of(episode: &Episode) -> Self {
        let steps = episode.steps.iter();
        let accepted: usize = steps.map(|step| 1 + step.alternatives.len()).sum();
        let of_arm = episode
            .refusals
            .iter()
            .filter(|(refusal, _)| refusal.cause == Cause::Arm);
        let refused: BTreeMap<String, u64> = of_arm
            .map(|(refusal, count)| {
                (
                    refusal.detail.as_deref().unwrap_or_default().to_owned(),
                    count,
                )
            })
            .collect();
        Self {
            checks: accepted as u64 + refused.values().sum::<u64>(),
            refused,
        }
    }
}

/// What `summary.json` says of the arm.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct ArmSummary {
    /// The planned time from one pick to the next, in seconds.
    pub(crate) cycle_s: Spread,
    /// For how many placements the arm's check was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) checks: Option<u64>,
    /// How many of them it refused, by reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) refused: Option<BTreeMap<String, u64>>,
    /// Items of the sequence that the arm cannot hold or lift: they were not there to be packed.
    pub(crate) set_aside: Vec<Unplaceable>,
    /// The arm, where it stands, and its gripper.
    pub(crate) parameters: ArmParameters,
}

impl ArmWork {
    /// An arm that has not packed anything yet.
    pub(crate) fn new(station: &ArmStation, set_aside: Vec<Unplaceable>) -> Self {
        Self {
            parameters: station.parameters().clone(),
            set_aside,
            cycles_s: Vec::new(),
            asked: None,
        }
    }

    /// The planned time of a step's cycle, in seconds.
    pub(crate) fn cycle_s(&self, step: usize) -> Option<f64> {
        self.cycles_s.get(step).copied().flatten()
    }

    pub(crate) fn summary(&self) -> ArmSummary {
        let cycles = self.cycles_s.iter().flatten();
        ArmSummary {
            cycle_s: Spread::of(cycles.map(|cycle_s| Duration::from_secs_f64(*cycle_s))),
            checks: self.asked.as_ref().map(|asked| asked.checks),
            refused: self.asked.as_ref().map(|asked| asked.refused.clone()),
            set_aside: self.set_aside.clone(),
            parameters: self.parameters.clone(),
        }
    }
}

impl ArmSummary {
    /// Named figures for people.
    pub(super) fn figures(&self) -> Vec<(&'static str, String)> {
        let cycle_s = &self.cycle_s;
        let mut figures = vec![
            ("Arm", self.parameters.name.clone()),
            (
                "Cycle per item",
                format!(
                    "{:.2} s mean, {:.2} s median, {:.2} s at most",
                    cycle_s.mean, cycle_s.median, cycle_s.max
                ),
            ),
        ];
        if let (Some(checks), Some(refused)) = (self.checks, &self.refused) {
            let count: u64 = refused.values().sum();
            figures.push((
                "Arm checks",
                format!("{checks} placements, {count} refused"),
            ));
        }
        figures
    }

    /// What the arm refused or could not pick, counted by reason, for people.
    pub(super) fn refusals(&self) -> Vec<(&'static str, String)> {
        let mut set_aside: BTreeMap<&str, usize> = BTreeMap::new();
        for item in &self.set_aside {
            *set_aside.entry(item.reason.as_str()).or_default() += 1;
        }
        let refused = self.refused.iter().flatten();
        let refused = refused
            .map(|(why, count)| ("refused by the arm", format!("{count} placements: {why}")));
        let set_aside = set_aside
            .iter()
            .map(|(why, count)| ("set aside", format!("{count} items: {why}")));
        refused.chain(set_aside).collect()
    }
}
