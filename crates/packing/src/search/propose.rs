//! The heuristic itself as a source of proposals.

use super::{Search, SearchSettings};
use crate::grid::Grid;
use crate::objective::WeightError;
use crate::placement::Placement;
use crate::plan::{Evaluator, StepInput};
use crate::proposals::{Percent, Proposals, ProposeAll, Proposer, all_count};
use crate::step::StageError;

/// Proposes the placements of each candidate that a heuristic ranks best, best first: a share of all its placements.
///
/// On the planner's own grid that is a whole exhaustive search more; behind
/// [`CoarseToFine`](crate::coarse::CoarseToFine) it is the coarse search, what a network has to beat.
#[derive(Debug)]
pub struct ProposeBest {
    search: Search,
    share: Percent,
    all: Proposals,
    best: Vec<Placement>,
}

impl ProposeBest {
    /// Proposes `share` of the placements on a grid, by the heuristic and weights of `settings`.
    ///
    /// # Errors
    /// [`WeightError`] where a weight is negative or not finite.
    pub fn new(
        grid: &Grid,
        settings: &SearchSettings,
        share: Percent,
    ) -> Result<Self, WeightError> {
        Ok(Self {
            search: Search::new(grid, settings)?,
            share,
            all: Proposals::default(),
            best: Vec::new(),
        })
    }
}

impl Proposer for ProposeBest {
    fn propose(
        &mut self,
        input: &StepInput<'_>,
        proposals: &mut Proposals,
    ) -> Result<(), StageError> {
        proposals.clear();
        ProposeAll.propose(input, &mut self.all)?;
        for (index, candidate) in input.candidates.iter().enumerate() {
            let wanted = self.share.of(all_count(input.grid, &candidate.item));
            self.search.rank(input, &[index], &self.all)?;
            self.best.clear();
            for _ in 0..wanted {
                let Some(next) = self.search.next_best(input)? else {
                    break;
                };
                self.best.push(next.resting.placement);
            }
            proposals.push(self.best.iter().copied());
        }
        Ok(())
    }
}
