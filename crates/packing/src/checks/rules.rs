//! The rules of items as checks of placements.

use crate::checks::check::{BoxedCheck, Condition, Cost, Question};
use crate::checks::sequence::Sequence;
use crate::checks::stability::{PhysicalStability, PhysicalStabilitySettings};
use crate::ranking::refusal::Cause;

/// How far inside its support the centre of mass of an upright item must lie, in metres.
const UPRIGHT_MARGIN_M: f64 = 0.01;

/// The checks for the rules of a step's items.
pub fn checks() -> Vec<BoxedCheck> {
    vec![
        Box::new(OnFloor),
        Box::new(Upright::default()),
        Box::new(Sequence),
    ]
}

/// Items that must stand on the floor do.
#[derive(Debug, Clone, Copy, Default)]
pub struct OnFloor;

impl Condition for OnFloor {
    const COST: Cost = Cost::Lookup;
    const CAUSE: Cause = Cause::NotOnFloor;

    fn is_met(&mut self, asked: &Question<'_>) -> bool {
        !asked.held.rules.is_bottom_only || asked.at.resting_height == 0
    }
}

/// Items that must stay upright stand well.
#[derive(Debug, Clone)]
pub struct Upright(PhysicalStability);

impl Default for Upright {
    fn default() -> Self {
        Self(PhysicalStability::new(PhysicalStabilitySettings {
            margin_m: UPRIGHT_MARGIN_M,
            ..PhysicalStabilitySettings::default()
        }))
    }
}

impl Condition for Upright {
    const COST: Cost = Cost::Footprint;
    const CAUSE: Cause = Cause::CouldFallOver;

    fn is_met(&mut self, asked: &Question<'_>) -> bool {
        !asked.held.rules.is_upright || self.0.is_met(asked)
    }
}
