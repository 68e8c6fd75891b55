//! The second stage of Algorithm 1: ranking placements by an objective.

use crate::ranking::proposals::Proposals;
use crate::ranking::refusal::Refusals;
use crate::ranking::step::{Evaluated, PlacementCounts, Shortfall, StageResult, StepInput};

/// Ranks placements by an objective. Placements that do not fit below the rim are left out.
///
/// A ranking goes on where it stopped: asking for one placement more never begins again. Errors are
/// what kept the evaluator from answering.
pub trait Evaluator: Send {
    /// Starts ranking the proposals of `group`, indices into the input's candidates.
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> StageResult;

    /// The next placement by increasing value; equal values by candidate, yaw, x, y. `None` after
    /// the last, or where the time is over, which the [shortfall](Self::shortfall) says.
    fn next_best(&mut self, input: &StepInput<'_>) -> StageResult<Option<Evaluated>>;

    /// Leaves a candidate out of the rest of the ranking. One that does not is only slower.
    fn leave_out(&mut self, _candidate: usize) {}

    /// The counts of a candidate of the last ranked group.
    fn counts(&self, candidate: usize) -> PlacementCounts;

    /// Adds the placements of a candidate of the last ranked group that were left out because a
    /// check refused them: of evaluators that have checks asked where placements are evaluated.
    fn add_refusals(&self, _candidate: usize, _refusals: &mut Refusals) {}

    /// About how many bytes it holds for this ranking and the next; 0 where that is little.
    fn held_bytes(&self) -> usize {
        0
    }

    /// Gives what was done otherwise than asked since the last [`rank`](Self::rank).
    fn shortfall(&self) -> Option<&Shortfall> {
        None
    }
}
