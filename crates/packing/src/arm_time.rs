//! The arm's time in the choice of a placement: a quicker one may be worth a little of the objective.

use serde::{Deserialize, Serialize};

use crate::valid::ValidPlacement;

/// How the planned time of the arm's cycle counts beside the objective. Off by default.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ArmTime {
    /// How many litres that may still be packed a second is worth, by what the method has a litre count beside the objective
    /// ([`SceneValue::weight`](crate::scene_value::SceneValue::weight)); 0 switches it off.
    pub litres_per_s: f64,
    /// Among how many of the best valid placements it decides. The arm plans a cycle for each, and each is tried.
    pub among: usize,
}

/// The most placements among which the time decides.
const MOST_AMONG: usize = 100;

/// Why a weight of the time is not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ArmTimeError {
    /// The weight is none.
    #[error("arm_time.litres_per_s: {0} is no weight: give 0, or what a second is worth")]
    Weight(f64),
    /// A litre is worth nothing.
    #[error(
        "arm_time.litres_per_s: a litre counts nothing beside the objective: set scene_value, or leave it out"
    )]
    NoLitre,
    /// Nothing to choose among.
    #[error("arm_time.among: {0} is not possible: give 2 to {MOST_AMONG}")]
    Among(usize),
}

impl Default for ArmTime {
    fn default() -> Self {
        Self {
            litres_per_s: 0.0,
            among: 5,
        }
    }
}

impl ArmTime {
    /// Whether time counts at all.
    pub fn is_on(&self) -> bool {
        self.litres_per_s > 0.0
    }

    /// Whether it is as by default, and need not be written down.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// What it is where a litre counts so much beside the objective.
    pub fn cost(&self, value_per_litre: f64) -> TimeCost {
        TimeCost {
            value_per_s: self.litres_per_s * value_per_litre,
            among: self.among,
        }
    }

    /// Checks that it is possible where a litre counts so much beside the objective.
    ///
    /// # Errors
    /// [`ArmTimeError`] where it is not.
    pub fn validate(&self, value_per_litre: f64) -> Result<(), ArmTimeError> {
        if !self.litres_per_s.is_finite() || self.litres_per_s < 0.0 {
            return Err(ArmTimeError::Weight(self.litres_per_s));
        }
        if self.is_on() && value_per_litre <= 0.0 {
            return Err(ArmTimeError::NoLitre);
        }
        match (2..=MOST_AMONG).contains(&self.among) {
            true => Ok(()),
            false => Err(ArmTimeError::Among(self.among)),
        }
    }
}

/// What the time of the arm's cycle costs. A placement without a planned cycle counts as one of no time: those of a step are planned for
/// the same arm, or for none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TimeCost {
    /// How much of the objective's value a second is worth; 0 where it counts nothing.
    pub value_per_s: f64,
    /// Among how many of the best valid placements it decides.
    pub among: usize,
}

impl TimeCost {
    /// Whether time counts at all.
    pub fn is_on(&self) -> bool {
        self.value_per_s > 0.0
    }

    /// How many valid placements are to be found where so many are wanted.
    pub(crate) fn wanted(&self, wanted: usize) -> usize {
        match self.is_on() {
            true => wanted.max(self.among),
            false => wanted,
        }
    }

    /// Brings valid placements, by increasing value, into the order of value and time; equal ones stay as they are.
    pub(crate) fn arrange(&self, ranked: &mut [ValidPlacement]) {
        if self.is_on() {
            ranked.sort_by(|a, b| self.cost(a).total_cmp(&self.cost(b)));
        }
    }

    fn cost(&self, valid: &ValidPlacement) -> f64 {
        let cycle = valid.evidence.cycle.as_ref();
        let cycle_s = cycle.map_or(0.0, |cycle| cycle.cycle_s);
        valid.placement.value + self.value_per_s * cycle_s
    }
}
