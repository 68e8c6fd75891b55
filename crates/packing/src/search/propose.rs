//! The heuristic itself as a source of proposals.

use super::{Search, SearchSettings};
use crate::evaluator::Evaluator;
use crate::grid::Grid;
use crate::objective::{Order, WeightError};
use crate::placement::Placement;
use crate::proposals::{Percent, Proposals, Proposer, all_count};
use crate::step::{Candidate, StageResult, StepInput};

/// Proposes those placements of another proposer that a heuristic ranks best, best first: a share of all placements.
///
/// Under [`Order::Balance`], where values of different items compare, the candidates share it: one that others beat gets little.
/// Under other orders each candidate has its own share. Behind [`CoarseToFine`](crate::coarse::CoarseToFine) it chooses among a
/// network's proposals, before finer ones are made of them.
pub struct ProposeBest {
    search: Search,
    share: Percent,
    among: Box<dyn Proposer>,
    ranked: Proposals,
    best: Vec<Vec<Placement>>,
    is_shared: bool,
}

impl ProposeBest {
    /// Proposes `share` of the placements on a grid out of those of `among`, by the heuristic and weights of `settings`.
    ///
    /// # Errors
    /// [`WeightError`] where a weight is negative or not finite.
    pub fn new(
        grid: &Grid,
        settings: &SearchSettings,
        share: Percent,
        among: Box<dyn Proposer>,
    ) -> Result<Self, WeightError> {
        Ok(Self {
            search: Search::new(grid, settings)?,
            share,
            among,
            ranked: Proposals::default(),
            best: Vec::new(),
            is_shared: settings.order == Order::Balance,
        })
    }

    /// Keeps the best placements of a group of candidates.
    fn keep_best(&mut self, input: &StepInput<'_>, group: &[usize], wanted: u64) -> StageResult {
        self.search.rank(input, group, &self.ranked)?;
        for _ in 0..wanted {
            let Some(next) = self.search.next_best(input)? else {
                break;
            };
            if let Some(best) = self.best.get_mut(next.candidate) {
                best.push(next.resting.placement);
            }
        }
        Ok(())
    }
}

impl Proposer for ProposeBest {
    fn propose(&mut self, input: &StepInput<'_>, proposals: &mut Proposals) -> StageResult {
        proposals.clear();
        self.among.propose(input, &mut self.ranked)?;
        if let Some(reason) = self.ranked.degraded() {
            proposals.degrade(reason);
        }
        self.best.resize_with(input.candidates.len(), Vec::new);
        self.best.iter_mut().for_each(Vec::clear);
        let wanted = |candidate: &Candidate| self.share.of(all_count(input.grid, &candidate.item));
        let wanted: Vec<u64> = input.candidates.iter().map(wanted).collect();
        if self.is_shared {
            let all: Vec<usize> = (0..input.candidates.len()).collect();
            self.keep_best(input, &all, wanted.iter().sum())?;
        } else {
            for (index, wanted) in wanted.into_iter().enumerate() {
                self.keep_best(input, &[index], wanted)?;
            }
        }
        for best in &self.best {
            proposals.push(best.iter().copied());
        }
        Ok(())
    }
}
