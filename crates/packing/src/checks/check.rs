//! Validity: may an item be placed there at all?

use std::sync::Arc;

use nalgebra::Isometry3;

use crate::checks::loads::Load;
use crate::checks::motion::Cycle;
use crate::checks::trial::Settling;
use crate::kernel::item::{ItemView, ShapeId};
use crate::kernel::placement::RestingPlacement;
use crate::ranking::refusal::{Cause, Refusal};
use crate::ranking::step::{Candidate, StageResult, StepInput};

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

/// Answer of a check about a placement.
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

/// Findings of the checks about a placement that they accepted, for whoever carries it out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Evidence {
    /// The motion that makes the placement, where an arm was asked.
    pub cycle: Option<Arc<Cycle>>,
    /// Outcome of the try in a simulation, where there was one.
    pub settling: Option<Settling>,
    /// The item below that would be loaded most, for what it may carry, where one has a limit.
    pub load: Option<Load>,
    /// Shortcuts taken to find this out, for people.
    pub degraded: Vec<String>,
    /// Depth below its place, which is rounded up, at which the item touches the content, in
    /// metres.
    pub lowered_m: f64,
}

impl Evidence {
    pub(crate) fn noting(shortcut: &str) -> Self {
        Self {
            degraded: vec![shortcut.to_owned()],
            ..Self::default()
        }
    }

    /// Takes over what another check found out.
    pub fn add(&mut self, other: Self) {
        self.cycle = other.cycle.or(self.cycle.take());
        self.settling = other.settling.or(self.settling);
        self.load = other.load.or(self.load.take());
        self.degraded.extend(other.degraded);
        self.lowered_m = self.lowered_m.max(other.lowered_m);
    }

    /// Lowers the pose of a placement to where its item touches what lies there: what falls farther
    /// stays less often. An arm's motion ends at the place itself.
    #[must_use]
    pub fn lower(&self, mut container_from_item: Isometry3<f64>) -> Isometry3<f64> {
        if self.cycle.is_none() {
            container_from_item.translation.z -= self.lowered_m;
        }
        container_from_item
    }
}

/// One condition of `IsValid`. Checks compose: a placement is valid where all of them accept it.
/// Errors are what kept a check from giving an answer.
pub trait ValidityCheck: Send {
    /// How long one call takes.
    fn cost(&self) -> Cost;

    /// A step begins: what was found out about placements of an earlier one no longer holds.
    fn begin(&mut self, _input: &StepInput<'_>) -> StageResult {
        Ok(())
    }

    /// Why it refuses every placement of the candidate, whatever the container holds. Nothing is
    /// proposed for such a candidate. Asked once for each as a step begins.
    fn rules_out(
        &mut self,
        _input: &StepInput<'_>,
        _candidate: &Candidate,
    ) -> StageResult<Option<Refusal>> {
        Ok(None)
    }

    /// Why it refuses a placement by what it found out about others in this step. Every check is
    /// asked this first; none [`judges`](Self::judge) what one of them refuses so.
    fn refuses_unseen(
        &self,
        _input: &StepInput<'_>,
        _candidate: &Candidate,
        _resting: &RestingPlacement,
    ) -> Option<Refusal> {
        None
    }

    /// Whether the candidate may be placed there.
    fn judge(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> StageResult<Verdict>;

    /// How many placements it is told of before the first question, to work on them together.
    fn foresight(&self) -> usize {
        1
    }

    /// Tells which placements it will be asked about next, in this order, unless it accepts one
    /// before. What it answers does not depend on this.
    fn foresee(
        &mut self,
        _input: &StepInput<'_>,
        _next: &[(&Candidate, RestingPlacement)],
    ) -> StageResult {
        Ok(())
    }

    /// Whether it can answer about a placement at once, as it worked on that before.
    fn is_known(&self, _candidate: &Candidate, _resting: &RestingPlacement) -> bool {
        false
    }

    /// Looks anew into candidates that it was done with, as more is proposed in the next search.
    fn widen(&mut self) {}

    /// Whether it refuses all further placements of a candidate in this step unasked.
    fn is_done_with(&self, _candidate: &Candidate) -> bool {
        false
    }

    /// The best placement that it refused as long as another is valid: made if none is.
    fn last_resort(&self) -> Option<LastResort> {
        None
    }
}

/// A placement that a check refused as long as another is valid, and that is made if none is.
#[derive(Debug, Clone, PartialEq)]
pub struct LastResort {
    /// Arrival of the item.
    pub arrival: usize,
    /// The item's shape in the pose in which it is placed.
    pub shape: ShapeId,
    /// Resting placement.
    pub resting: RestingPlacement,
    /// Findings about it.
    pub evidence: Evidence,
}

/// A check of any kind.
pub type BoxedCheck = Box<dyn ValidityCheck>;

/// May a candidate, in this view, be placed there?
pub(crate) struct Question<'a> {
    pub(crate) input: &'a StepInput<'a>,
    pub(crate) held: &'a Candidate,
    pub(crate) view: &'a ItemView,
    pub(crate) at: &'a RestingPlacement,
}

/// A check that asks one question, to which there always is an answer.
pub(crate) trait Condition: Send {
    const COST: Cost;
    const CAUSE: Cause;

    fn is_met(&mut self, asked: &Question<'_>) -> bool;
}

impl<C: Condition> ValidityCheck for C {
    fn cost(&self) -> Cost {
        C::COST
    }

    fn judge(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
        resting: &RestingPlacement,
    ) -> StageResult<Verdict> {
        let asked = Question {
            input,
            held: candidate,
            view: candidate.item.view(resting.placement.yaw)?,
            at: resting,
        };
        Ok(Verdict::of(self.is_met(&asked), C::CAUSE))
    }
}

/// Accepts placements whose upper surface stays at or below the rim.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fits;

impl Condition for Fits {
    const COST: Cost = Cost::Lookup;
    const CAUSE: Cause = Cause::AboveRim;

    fn is_met(&mut self, asked: &Question<'_>) -> bool {
        asked
            .view
            .fits_at(asked.input.grid, asked.at.resting_height)
    }
}
