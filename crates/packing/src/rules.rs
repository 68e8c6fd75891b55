//! The rules of items as checks of placements.

use crate::check::{BoxedCheck, Cost, ValidityCheck, Verdict};
use crate::placement::RestingPlacement;
use crate::refusal::Cause;
use crate::stability::{PhysicalStability, PhysicalStabilitySettings};
use crate::step::{Candidate, StageError, StepInput};

/// How far inside its support the centre of mass of an upright item must lie, in metres.
const UPRIGHT_MARGIN_M: f64 = 0.01;

/// The checks for the rules of a step's items.
pub fn checks() -> Vec<BoxedCheck> {
    vec![Box::new(OnFloor), Box::new(Upright::default())]
}

/// Items that must stand on the floor do.
#[derive(Debug, Clone, Copy, Default)]
pub struct OnFloor;

impl ValidityCheck for OnFloor {
    fn cost(&self) -> Cost {
        Cost::Lookup
    }

    fn judge(
        &mut self,
        _input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Verdict, StageError> {
        let is_free = !candidate.rules.is_bottom_only;
        let is_met = is_free || resting.resting_height == 0;
        Ok(Verdict::of(is_met, Cause::NotOnFloor))
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

impl ValidityCheck for Upright {
    fn cost(&self) -> Cost {
        Cost::Footprint
    }

    fn judge(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Verdict, StageError> {
        let is_met =
            !candidate.rules.is_upright || self.0.judge(input, candidate, resting)?.is_accepted();
        Ok(Verdict::of(is_met, Cause::CouldFallOver))
    }
}
