//! The rules of items as checks of placements.

use std::sync::Arc;

use ppnpack_packing::check::{BoxedCheck, Cost, ValidityCheck};
use ppnpack_packing::placement::RestingPlacement;
use ppnpack_packing::stability::{PhysicalStability, PhysicalStabilitySettings};
use ppnpack_packing::step::{Candidate, StageError, StepInput};

use crate::remote::StepContext;

/// How far inside its support the centre of mass of an upright item must lie, in metres.
const UPRIGHT_MARGIN_M: f64 = 0.01;

/// The checks for the rules of a step's items.
pub(crate) fn checks(context: &Arc<StepContext>) -> Vec<BoxedCheck> {
    let settings = PhysicalStabilitySettings {
        margin_m: UPRIGHT_MARGIN_M,
        ..PhysicalStabilitySettings::default()
    };
    vec![
        Box::new(OnFloor(Arc::clone(context))),
        Box::new(Upright {
            context: Arc::clone(context),
            stability: PhysicalStability::new(settings),
        }),
    ]
}

/// Items that must stand on the floor do.
struct OnFloor(Arc<StepContext>);

impl ValidityCheck for OnFloor {
    fn name(&self) -> &'static str {
        "not on the floor"
    }

    fn cost(&self) -> Cost {
        Cost::Lookup
    }

    fn is_valid(
        &mut self,
        _input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<bool, StageError> {
        let is_bound = self.0.rules_of(candidate.arrival).is_bottom_only;
        Ok(!is_bound || resting.resting_height == 0)
    }
}

/// Items that must stay upright stand well.
struct Upright {
    context: Arc<StepContext>,
    stability: PhysicalStability,
}

impl ValidityCheck for Upright {
    fn name(&self) -> &'static str {
        "could fall over"
    }

    fn cost(&self) -> Cost {
        Cost::Footprint
    }

    fn is_valid(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<bool, StageError> {
        if !self.context.rules_of(candidate.arrival).is_upright {
            return Ok(true);
        }
        self.stability.is_valid(input, candidate, resting)
    }
}
