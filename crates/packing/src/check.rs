//! Validity: may an item be placed there at all?

use crate::placement::RestingPlacement;
use crate::step::{Candidate, StageError, StepInput};

/// How long a check takes, so that the cheap ones go first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cost {
    /// Below a microsecond: a comparison or a table look-up.
    Lookup,
    /// Microseconds: geometry of the footprint.
    Footprint,
    /// Up to milliseconds: motion planning, collision tests.
    Motion,
    /// More: a simulated drop.
    Simulation,
}

/// One condition of `IsValid`. Checks compose: a placement is valid where all of them accept it.
pub trait ValidityCheck: Send {
    /// What a refusal says of the placement, such as `unstable`.
    fn name(&self) -> &'static str;

    /// How long one call takes.
    fn cost(&self) -> Cost;

    /// Whether it refuses every placement of the candidate, whatever the container holds. Such a candidate is left out
    /// of the step before anything is proposed for it. Asked once for each candidate as a step begins.
    ///
    /// # Errors
    /// What kept the check from giving an answer.
    fn rules_out(
        &mut self,
        _input: &StepInput<'_>,
        _candidate: &Candidate,
    ) -> Result<bool, StageError> {
        Ok(false)
    }

    /// Whether the candidate may be placed there.
    ///
    /// # Errors
    /// What kept the check from giving an answer.
    fn is_valid(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<bool, StageError>;
}

/// A check of any kind.
pub type BoxedCheck = Box<dyn ValidityCheck>;

/// Accepts placements whose upper surface stays at or below the rim.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fits;

impl ValidityCheck for Fits {
    fn name(&self) -> &'static str {
        "above the rim"
    }

    fn cost(&self) -> Cost {
        Cost::Lookup
    }

    fn is_valid(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<bool, StageError> {
        let view = candidate.item.views().get(resting.placement.yaw);
        Ok(view.is_some_and(|view| {
            let top = i32::from(resting.resting_height) + i32::from(view.height());
            top <= i32::from(input.grid.rim())
        }))
    }
}
