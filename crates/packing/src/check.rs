//! Validity: may an item be placed there at all?

use std::sync::Arc;

use crate::motion::Cycle;
use crate::placement::RestingPlacement;
use crate::refusal::{Cause, Refusal};
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

/// What a check says of a placement.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// The item may be placed there, with what was found out about it.
    Accepted(Evidence),
    /// It may not, and why.
    Refused(Refusal),
}

impl Verdict {
    /// Accepts where a condition is met, without evidence; refuses for this cause elsewhere.
    pub fn of(is_met: bool, cause: Cause) -> Self {
        if is_met {
            Self::Accepted(Evidence::default())
        } else {
            Self::Refused(cause.into())
        }
    }

    /// Whether the item may be placed there.
    pub fn is_accepted(&self) -> bool {
        matches!(self, Self::Accepted(_))
    }
}

/// What checks found out about a placement that they accepted: whoever carries it out is given that.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Evidence {
    /// The motion that makes the placement, where an arm was asked.
    pub cycle: Option<Arc<Cycle>>,
}

impl Evidence {
    /// Takes over what another check found out.
    pub fn add(&mut self, other: Self) {
        self.cycle = other.cycle.or(self.cycle.take());
    }
}

/// One condition of `IsValid`. Checks compose: a placement is valid where all of them accept it.
pub trait ValidityCheck: Send {
    /// How long one call takes.
    fn cost(&self) -> Cost;

    /// Why it refuses every placement of the candidate, whatever the container holds, where it does. Such a candidate
    /// is left out of the step before anything is proposed for it. Asked once for each candidate as a step begins.
    ///
    /// # Errors
    /// What kept the check from giving an answer.
    fn rules_out(
        &mut self,
        _input: &StepInput<'_>,
        _candidate: &Candidate,
    ) -> Result<Option<Refusal>, StageError> {
        Ok(None)
    }

    /// Whether the candidate may be placed there.
    ///
    /// # Errors
    /// What kept the check from giving an answer.
    fn judge(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Verdict, StageError>;
}

/// A check of any kind.
pub type BoxedCheck = Box<dyn ValidityCheck>;

/// Accepts placements whose upper surface stays at or below the rim.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fits;

impl ValidityCheck for Fits {
    fn cost(&self) -> Cost {
        Cost::Lookup
    }

    fn judge(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> Result<Verdict, StageError> {
        let view = candidate.item.views().get(resting.placement.yaw);
        let fits = view.is_some_and(|view| {
            let top = i32::from(resting.resting_height) + i32::from(view.height());
            top <= i32::from(input.grid.rim())
        });
        Ok(Verdict::of(fits, Cause::AboveRim))
    }
}
