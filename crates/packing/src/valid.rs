//! The last stage of Algorithm 1: of the placements by increasing value, those that every check accepts.

use std::time::{Duration, Instant};

use crate::check::BoxedCheck;
use crate::grid::Grid;
use crate::objective::WeightError;
use crate::plan::{Evaluator, PlanError};
use crate::proposals::Proposals;
use crate::search::{Search, SearchSettings};
use crate::step::{Candidate, Evaluated, PlacementCounts, StepInput};

/// Checks, sorted by their cost, and what they refused in the last search.
pub struct ValidityFilter {
    checks: Vec<BoxedCheck>,
    /// By position in the group, then check.
    refusals: Vec<u64>,
}

/// How a search for valid placements went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Searched {
    /// Whether every placement was looked at.
    pub is_exhausted: bool,
    /// Time spent ranking placements.
    pub evaluate: Duration,
    /// Time spent in the checks.
    pub check: Duration,
}

impl ValidityFilter {
    /// A filter that asks these checks, the cheap ones first.
    pub fn new(mut checks: Vec<BoxedCheck>) -> Self {
        checks.sort_by_key(|check| check.cost());
        Self {
            checks,
            refusals: Vec::new(),
        }
    }

    /// Ranks the proposals of some candidates and adds valid placements to `found`, the best first, until it holds
    /// `limit` of them or none is left. `group` holds indices into the input's candidates.
    ///
    /// # Errors
    /// [`PlanError::Evaluate`] and [`PlanError::Check`] where a stage failed.
    pub fn search(
        &mut self,
        evaluator: &mut dyn Evaluator,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
        limit: usize,
        found: &mut Vec<Evaluated>,
    ) -> Result<Searched, PlanError> {
        self.refusals.clear();
        self.refusals.resize(group.len() * self.checks.len(), 0);
        let started = Instant::now();
        evaluator
            .rank(input, group, proposals)
            .map_err(PlanError::Evaluate)?;
        let mut searched = Searched {
            is_exhausted: false,
            evaluate: started.elapsed(),
            check: Duration::ZERO,
        };
        while found.len() < limit {
            let started = Instant::now();
            let best = evaluator.next_best(input).map_err(PlanError::Evaluate)?;
            let ranked = Instant::now();
            searched.evaluate += ranked - started;
            let Some(best) = best else {
                searched.is_exhausted = true;
                break;
            };
            let refused_by = self.refused_by(input, &best)?;
            searched.check += ranked.elapsed();
            match refused_by {
                None => found.push(best),
                Some(check) => self.count(group, best.candidate, check),
            }
        }
        Ok(searched)
    }

    /// What each check refused of a candidate in the last search, by the candidate's position in the group.
    pub fn refusals(&self, position: usize) -> impl Iterator<Item = (&'static str, u64)> + Clone {
        let first = position * self.checks.len();
        let counts = self.refusals.get(first..).unwrap_or(&[]);
        let names = self.checks.iter().map(|check| check.name());
        names.zip(counts.iter().copied())
    }

    /// The first check that refuses every placement of a candidate, if one does.
    ///
    /// # Errors
    /// [`PlanError::Check`] where a check failed.
    pub fn ruled_out_by(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
    ) -> Result<Option<&'static str>, PlanError> {
        for check in &mut self.checks {
            let name = check.name();
            let is_ruled_out =
                check
                    .rules_out(input, candidate)
                    .map_err(|source| PlanError::Check {
                        check: name,
                        source,
                    })?;
            if is_ruled_out {
                return Ok(Some(name));
            }
        }
        Ok(None)
    }

    /// The index of the first check that refuses a placement.
    fn refused_by(
        &mut self,
        input: &StepInput<'_>,
        placement: &Evaluated,
    ) -> Result<Option<usize>, PlanError> {
        let Some(candidate) = input.candidates.get(placement.candidate) else {
            return Ok(None);
        };
        for (index, check) in self.checks.iter_mut().enumerate() {
            let valid = check
                .is_valid(input, candidate, &placement.resting)
                .map_err(|source| PlanError::Check {
                    check: check.name(),
                    source,
                })?;
            if !valid {
                return Ok(Some(index));
            }
        }
        Ok(None)
    }

    fn count(&mut self, group: &[usize], candidate: usize, check: usize) {
        let position = group.iter().position(|member| *member == candidate);
        let count = position.and_then(|at| self.refusals.get_mut(at * self.checks.len() + check));
        if let Some(count) = count {
            *count += 1;
        }
    }
}

/// A search with its checks, for those who want the best valid placements of a step without planning it: a service
/// that evaluates for a planner elsewhere.
pub struct ValidSearch {
    search: Search,
    filter: ValidityFilter,
}

/// The best valid placements of some candidates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BestValid {
    /// By increasing value; equal values by candidate, yaw, x, y.
    pub placements: Vec<Evaluated>,
    /// Whether there are no further ones.
    pub is_complete: bool,
    /// What became of the placements of each candidate of the group, in its order.
    pub tallies: Vec<Tally>,
}

/// What became of a candidate's placements.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    /// Index into the input's candidates.
    pub candidate: usize,
    /// Before any check.
    pub counts: PlacementCounts,
    /// What each check refused before the search ended.
    pub refusals: Vec<(&'static str, u64)>,
}

impl ValidSearch {
    /// A search by these settings, for placements that pass these checks.
    ///
    /// # Errors
    /// [`WeightError`] where a weight is negative or not finite.
    pub fn new(
        grid: &Grid,
        settings: &SearchSettings,
        checks: Vec<BoxedCheck>,
    ) -> Result<Self, WeightError> {
        Ok(Self {
            search: Search::new(grid, settings)?.bounded(),
            filter: ValidityFilter::new(checks),
        })
    }

    /// Spreads the work over the threads of a pool; the result is the same, bit for bit.
    #[must_use]
    pub fn with_pool(mut self, pool: std::sync::Arc<rayon::ThreadPool>) -> Self {
        self.search = self.search.with_pool(pool);
        self
    }

    /// The best `limit` valid placements of a group of candidates among their proposals.
    ///
    /// # Errors
    /// [`PlanError::Evaluate`] and [`PlanError::Check`] where a stage failed.
    pub fn best(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
        limit: usize,
    ) -> Result<BestValid, PlanError> {
        let mut placements = Vec::new();
        let searched = self.filter.search(
            &mut self.search,
            input,
            group,
            proposals,
            limit,
            &mut placements,
        )?;
        let tallies = group.iter().enumerate().map(|(position, candidate)| Tally {
            candidate: *candidate,
            counts: self.search.counts(*candidate),
            refusals: self.filter.refusals(position).collect(),
        });
        Ok(BestValid {
            placements,
            is_complete: searched.is_exhausted,
            tallies: tallies.collect(),
        })
    }
}
