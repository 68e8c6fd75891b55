//! The last stage of Algorithm 1: of the placements by increasing value, those that every check accepts.

use std::time::Instant;

use crate::check::{BoxedCheck, Evidence, Verdict};
use crate::evaluator::Evaluator;
use crate::proposals::Proposals;
use crate::refusal::{Refusal, Refusals};
use crate::step::{
    Candidate, Evaluated, PlacementCounts, Shortfall, StageError, StepInput, Timings,
};

/// What kept a search for valid placements from going on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SearchError {
    /// The evaluator failed.
    #[error("evaluating placements failed: {0}")]
    Evaluate(#[source] StageError),
    /// A validity check failed to give an answer.
    #[error("a validity check failed: {0}")]
    Check(#[source] StageError),
}

/// A placement that every check accepted.
#[derive(Debug, Clone, PartialEq)]
pub struct ValidPlacement {
    /// The placement, with its value.
    pub placement: Evaluated,
    /// What the checks found out about it.
    pub evidence: Evidence,
}

/// What became of a candidate's placements.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    /// Index into the input's candidates.
    pub candidate: usize,
    /// Before any check.
    pub counts: PlacementCounts,
    /// Those that checks refused before the search ended.
    pub refusals: Refusals,
}

/// Valid placements by increasing value: an evaluator, and the checks that its placements have to pass. All checks of
/// the program are asked here, those of the planner, of the services and of the dataset's expert.
///
/// Like the evaluator's ranking, the search goes on where it stopped.
pub struct ValidSearch {
    evaluator: Box<dyn Evaluator>,
    /// The cheap ones first.
    checks: Vec<BoxedCheck>,
    /// By candidate of the input.
    refusals: Vec<Refusals>,
    shortfall: Shortfall,
    timings: Timings,
}

impl ValidSearch {
    /// A search that asks these checks, the cheap ones first.
    pub fn new(evaluator: Box<dyn Evaluator>, mut checks: Vec<BoxedCheck>) -> Self {
        checks.sort_by_key(|check| check.cost());
        Self {
            evaluator,
            checks,
            refusals: Vec::new(),
            shortfall: Shortfall::default(),
            timings: Timings::default(),
        }
    }

    /// Starts a search among the proposals of some candidates; `group` holds indices into the input's candidates.
    ///
    /// # Errors
    /// [`SearchError::Evaluate`] where the evaluator failed.
    pub fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> Result<(), SearchError> {
        self.refusals.iter_mut().for_each(Refusals::clear);
        let candidates = input.candidates.len().max(self.refusals.len());
        self.refusals.resize(candidates, Refusals::default());
        self.shortfall.clear();
        let started = Instant::now();
        let ranked = self.evaluator.rank(input, group, proposals);
        self.timings = Timings {
            evaluate: started.elapsed(),
            ..Timings::default()
        };
        ranked.map_err(SearchError::Evaluate)
    }

    /// The next valid placement by increasing value; equal values by candidate, yaw, x, y. `None` where there are no
    /// more, or where the time is over: see [`is_cut`](Self::is_cut).
    ///
    /// # Errors
    /// [`SearchError`] where the evaluator or a check failed.
    pub fn next_valid(
        &mut self,
        input: &StepInput<'_>,
    ) -> Result<Option<ValidPlacement>, SearchError> {
        while let Some(placement) = self.next_ranked(input)? {
            match self.judge(input, &placement)? {
                Some(Verdict::Accepted(evidence)) => {
                    return Ok(Some(ValidPlacement {
                        placement,
                        evidence,
                    }));
                }
                Some(Verdict::Refused(_)) => {}
                None => break,
            }
        }
        Ok(None)
    }

    /// The next placement by increasing value, before any check; `None` after the last.
    ///
    /// # Errors
    /// [`SearchError::Evaluate`] where the evaluator failed.
    pub fn next_ranked(&mut self, input: &StepInput<'_>) -> Result<Option<Evaluated>, SearchError> {
        if self.shortfall.is_cut {
            return Ok(None);
        }
        let started = Instant::now();
        let best = self.evaluator.next_best(input);
        self.timings.evaluate += started.elapsed();
        best.map_err(SearchError::Evaluate)
    }

    /// What the checks say of a placement: a refusal by the first that refuses it, else the evidence of all. `None`
    /// where the time is over.
    ///
    /// # Errors
    /// [`SearchError::Check`] where a check failed.
    pub fn judge(
        &mut self,
        input: &StepInput<'_>,
        placement: &Evaluated,
    ) -> Result<Option<Verdict>, SearchError> {
        let started = Instant::now();
        if input.deadline.is_some_and(|deadline| started >= deadline) {
            let what = "the time limit left placements unchecked";
            self.shortfall.cut(what.to_owned());
            return Ok(None);
        }
        let verdict = self.ask_checks(input, placement);
        self.timings.check += started.elapsed();
        let verdict = verdict?;
        if let Verdict::Refused(refusal) = &verdict
            && let Some(refusals) = self.refusals.get_mut(placement.candidate)
        {
            refusals.count(refusal.clone(), 1);
        }
        Ok(Some(verdict))
    }

    fn ask_checks(
        &mut self,
        input: &StepInput<'_>,
        placement: &Evaluated,
    ) -> Result<Verdict, SearchError> {
        let mut evidence = Evidence::default();
        let Some(candidate) = input.candidates.get(placement.candidate) else {
            return Ok(Verdict::Accepted(evidence));
        };
        for check in &mut self.checks {
            let verdict = check.judge(input, candidate, &placement.resting);
            match verdict.map_err(SearchError::Check)? {
                Verdict::Accepted(found) => evidence.add(found),
                refused @ Verdict::Refused(_) => return Ok(refused),
            }
        }
        Ok(Verdict::Accepted(evidence))
    }

    /// Why a check refuses every placement of a candidate, if one does.
    ///
    /// # Errors
    /// [`SearchError::Check`] where a check failed.
    pub fn ruled_out(
        &mut self,
        input: &StepInput<'_>,
        candidate: &Candidate,
    ) -> Result<Option<Refusal>, SearchError> {
        for check in &mut self.checks {
            let refusal = check.rules_out(input, candidate);
            if let Some(refusal) = refusal.map_err(SearchError::Check)? {
                return Ok(Some(refusal));
            }
        }
        Ok(None)
    }

    /// The placements of a candidate before any check.
    pub fn counts(&self, candidate: usize) -> PlacementCounts {
        self.evaluator.counts(candidate)
    }

    /// Adds the placements of a candidate that were refused since the search started: by the evaluator's checks, and by
    /// those of this search.
    pub fn add_refusals(&self, candidate: usize, refusals: &mut Refusals) {
        self.evaluator.add_refusals(candidate, refusals);
        if let Some(own) = self.refusals.get(candidate) {
            refusals.add(own);
        }
    }

    /// What became of a candidate's placements since the search started.
    pub fn tally(&self, candidate: usize) -> Tally {
        let mut refusals = Refusals::default();
        self.add_refusals(candidate, &mut refusals);
        Tally {
            candidate,
            counts: self.counts(candidate),
            refusals,
        }
    }

    /// Whether the time was over before every placement was looked at.
    pub fn is_cut(&self) -> bool {
        self.shortfalls().any(|shortfall| shortfall.is_cut)
    }

    /// What was done otherwise than was asked for: by the evaluator, and by this search.
    pub fn shortfalls(&self) -> impl Iterator<Item = &Shortfall> {
        self.evaluator
            .shortfall()
            .into_iter()
            .chain([&self.shortfall])
    }

    /// Time spent since the search started; none of it on proposing.
    pub fn timings(&self) -> Timings {
        self.timings
    }
}
