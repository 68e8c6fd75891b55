//! The last stage of Algorithm 1: of placements by value, those that every check accepts.

use std::collections::VecDeque;
use std::ops::Range;
use std::time::Instant;

use crate::checks::check::{BoxedCheck, Cost, Evidence, Verdict};
use crate::ranking::evaluator::Evaluator;
use crate::ranking::proposals::Proposals;
use crate::ranking::refusal::{Refusal, Refusals};
use crate::ranking::step::{
    Candidate, Evaluated, PlacementCounts, Shortfall, StageError, StepInput, Timings,
};

/// Failure of a search for valid placements.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SearchError {
    /// The evaluator failed.
    #[error("evaluating placements failed: {0}")]
    Evaluate(#[source] StageError),
    /// A validity check failed to give an answer.
    #[error("a validity check failed: {0}")]
    Check(#[source] StageError),
    /// The evaluator ranked what is none of the step's candidates.
    #[error(
        "broken invariant \"what is ranked is a candidate of the step\": there is no number {0}"
    )]
    NoSuchCandidate(usize),
}

/// A placement that every check accepted.
#[derive(Debug, Clone, PartialEq)]
pub struct ValidPlacement {
    /// The placement, with its value.
    pub placement: Evaluated,
    /// Findings of the checks about it.
    pub evidence: Evidence,
}

/// Outcome of a candidate's placements.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    /// Index into the input's candidates.
    pub candidate: usize,
    /// Before any check.
    pub counts: PlacementCounts,
    /// Refusals before the search ended.
    pub refusals: Refusals,
}

/// Evidence of a placement that was not simulated.
const UNTRIED: &str =
    "the time limit passed before the placement was tried: the item may not stay there";

fn only(placement: &Evaluated) -> Range<usize> {
    placement.candidate..placement.candidate + 1
}

/// Valid placements by increasing value: an evaluator, and the checks that its placements have to
/// pass, those of the planner and those of the services.
///
/// Like the evaluator's ranking, the search goes on where it stopped.
pub struct ValidSearch {
    evaluator: Box<dyn Evaluator>,
    checks: Vec<BoxedCheck>,
    /// The next placements by value that all checks but the last accept, with their findings.
    upcoming: VecDeque<(Evaluated, Evidence)>,
    refusals: Vec<Refusals>,
    /// Placements that a simulation refused since the step began.
    refused_last: Vec<Evaluated>,
    /// The best placement that there was no time to simulate, with what the other checks found.
    untried: Option<(Evaluated, Evidence)>,
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
            upcoming: VecDeque::new(),
            refusals: Vec::new(),
            refused_last: Vec::new(),
            untried: None,
            shortfall: Shortfall::default(),
            timings: Timings::default(),
        }
    }

    /// A step begins: the checks forget what they found out in the last one.
    ///
    /// # Errors
    /// [`SearchError::Check`] where a check failed.
    pub fn begin(&mut self, input: &StepInput<'_>) -> Result<(), SearchError> {
        self.refused_last.clear();
        self.untried = None;
        let mut checks = self.checks.iter_mut();
        let begun = checks.try_for_each(|check| check.begin(input));
        begun.map_err(SearchError::Check)
    }

    /// Has the checks look anew into candidates that they were done with.
    pub fn widen(&mut self) {
        self.checks.iter_mut().for_each(|check| check.widen());
    }

    /// Starts a search among the proposals of `group`, indices into the input's candidates.
    ///
    /// # Errors
    /// [`SearchError::Evaluate`] where the evaluator failed.
    pub fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> Result<(), SearchError> {
        self.upcoming.clear();
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

    /// The next valid placement by increasing value; equal values by candidate, yaw, x, y. `None`
    /// where there are no more, or where the time is over: see [`is_cut`](Self::is_cut).
    ///
    /// # Errors
    /// [`SearchError`] where the evaluator or a check failed.
    pub fn next_valid(
        &mut self,
        input: &StepInput<'_>,
    ) -> Result<Option<ValidPlacement>, SearchError> {
        // Of what was looked into together, what comes after a valid one may not be known yet.
        self.foresee(input)?;
        loop {
            self.refill(input)?;
            let Some((placement, mut evidence)) = self.upcoming.pop_front() else {
                return Ok(None);
            };
            match self.ask(input, &placement, true)? {
                Some(Verdict::Accepted(found)) => {
                    evidence.add(found);
                    return Ok(Some(ValidPlacement {
                        placement,
                        evidence,
                    }));
                }
                Some(Verdict::Refused(_)) => {
                    self.keep_tried(placement);
                    self.leave_out_what_is_done(input, 0..input.candidates.len());
                }
                // The time is over, but of what was looked into together some may be known.
                None if self.is_last_simulated() => {
                    self.untried.get_or_insert((placement, evidence));
                }
                None => {}
            }
        }
    }

    /// Takes placements that all checks but the last accept from the ranking, as many as the last
    /// wants to know of at once, where none is left.
    fn refill(&mut self, input: &StepInput<'_>) -> Result<(), SearchError> {
        if !self.upcoming.is_empty() {
            return Ok(());
        }
        let last = self.checks.last();
        let foresight = last.map_or(1, |check| check.foresight().max(1));
        while self.upcoming.len() < foresight
            && let Some(placement) = self.next_ranked(input)?
        {
            match self.ask(input, &placement, false)? {
                Some(Verdict::Accepted(evidence)) => {
                    self.upcoming.push_back((placement, evidence));
                }
                Some(Verdict::Refused(_)) => self.leave_out_what_is_done(input, only(&placement)),
                None => break,
            }
        }
        self.foresee(input)
    }

    /// Tells the last check of the placements that it will be asked about next, where it wants to
    /// know of several.
    fn foresee(&mut self, input: &StepInput<'_>) -> Result<(), SearchError> {
        let last = self.checks.last_mut().filter(|last| last.foresight() > 1);
        let Some(last) = last.filter(|_| !self.upcoming.is_empty() && !self.shortfall.is_cut)
        else {
            return Ok(());
        };
        let started = Instant::now();
        let next = self.upcoming.iter().filter_map(|(placement, _)| {
            let candidate = input.candidates.get(placement.candidate)?;
            Some((candidate, placement.resting))
        });
        let foreseen = last.foresee(input, &next.collect::<Vec<_>>());
        self.timings.check += started.elapsed();
        foreseen.map_err(SearchError::Check)
    }

    /// Keeps a placement that a simulation refused: one of these few may be the last resort.
    fn keep_tried(&mut self, placement: Evaluated) {
        if self.is_last_simulated() {
            self.refused_last.push(placement);
        }
    }

    fn is_last_simulated(&self) -> bool {
        let last = self.checks.last();
        last.is_some_and(|check| check.cost() == Cost::Simulation)
    }

    /// Takes the best placement of the step that all checks accept but the simulation, for which
    /// there was no time. Its evidence says so.
    pub fn take_untried(&mut self) -> Option<ValidPlacement> {
        let (placement, mut evidence) = self.untried.take()?;
        evidence.degraded.push(UNTRIED.to_owned());
        Some(ValidPlacement {
            placement,
            evidence,
        })
    }

    /// Leaves the candidates of a range out of which a check accepts no more.
    fn leave_out_what_is_done(&mut self, input: &StepInput<'_>, among: Range<usize>) {
        for index in among {
            let Some(candidate) = input.candidates.get(index) else {
                continue;
            };
            let mut checks = self.checks.iter();
            if checks.any(|check| check.is_done_with(candidate)) {
                self.evaluator.leave_out(index);
                self.upcoming
                    .retain(|(placement, _)| placement.candidate != index);
            }
        }
    }

    /// The best placement that the last check refused in this step, where it is made for want of a
    /// valid one, with the findings of the other checks, such as the arm's cycle.
    ///
    /// # Errors
    /// [`SearchError::Check`] where a check failed.
    pub fn last_resort(
        &mut self,
        input: &StepInput<'_>,
    ) -> Result<Option<ValidPlacement>, SearchError> {
        let Some((last, others)) = self.checks.split_last_mut() else {
            return Ok(None);
        };
        let Some(resort) = last.last_resort() else {
            return Ok(None);
        };
        let held_of = |placement: &Evaluated| input.candidates.get(placement.candidate);
        let is_it = |refused: &&Evaluated| {
            refused.resting == resort.resting
                && held_of(refused).is_some_and(|held| {
                    (held.arrival, held.item.shape()) == (resort.arrival, resort.shape)
                })
        };
        let placement = self.refused_last.iter().find(is_it).copied();
        let Some((placement, held)) = placement.and_then(|it| Some((it, held_of(&it)?))) else {
            return Ok(None);
        };
        let mut evidence = Evidence::default();
        for check in others {
            let verdict = check.judge(input, held, &placement.resting);
            match verdict.map_err(SearchError::Check)? {
                Verdict::Accepted(found) => evidence.add(found),
                Verdict::Refused(_) => return Ok(None),
            }
        }
        evidence.add(resort.evidence);
        Ok(Some(ValidPlacement {
            placement,
            evidence,
        }))
    }

    /// The next placement by increasing value, before any check; `None` after the last.
    fn next_ranked(&mut self, input: &StepInput<'_>) -> Result<Option<Evaluated>, SearchError> {
        if self.shortfall.is_cut {
            return Ok(None);
        }
        let started = Instant::now();
        let best = self.evaluator.next_best(input);
        self.timings.evaluate += started.elapsed();
        best.map_err(SearchError::Evaluate)
    }

    /// Asks the last check, or all others, about a placement: the first refusal, else the evidence
    /// of all. `None` where the time is over.
    fn ask(
        &mut self,
        input: &StepInput<'_>,
        placement: &Evaluated,
        is_last: bool,
    ) -> Result<Option<Verdict>, SearchError> {
        let started = Instant::now();
        if self.is_late(input) && !(is_last && self.is_known(input, placement)) {
            return Ok(None);
        }
        let verdict = self.ask_checks(input, placement, is_last);
        self.timings.check += started.elapsed();
        let verdict = verdict?;
        // It may have been refused for want of time.
        if matches!(verdict, Verdict::Refused(_)) && self.is_late(input) {
            return Ok(None);
        }
        if let Verdict::Refused(refusal) = &verdict
            && let Some(refusals) = self.refusals.get_mut(placement.candidate)
        {
            refusals.count(refusal.clone(), 1);
        }
        Ok(Some(verdict))
    }

    /// Whether the time is over; then the search is cut.
    fn is_late(&mut self, input: &StepInput<'_>) -> bool {
        let is_late = input
            .deadline
            .is_some_and(|deadline| Instant::now() >= deadline);
        if is_late {
            let what = "the time limit left placements unchecked";
            self.shortfall.cut(what.to_owned());
        }
        is_late
    }

    fn is_known(&self, input: &StepInput<'_>, placement: &Evaluated) -> bool {
        let candidate = input.candidates.get(placement.candidate);
        let last = candidate.zip(self.checks.last());
        last.is_some_and(|(held, last)| last.is_known(held, &placement.resting))
    }

    fn ask_checks(
        &mut self,
        input: &StepInput<'_>,
        placement: &Evaluated,
        is_last: bool,
    ) -> Result<Verdict, SearchError> {
        let mut evidence = Evidence::default();
        let index = placement.candidate;
        let candidate = input.candidates.get(index);
        let candidate = candidate.ok_or(SearchError::NoSuchCandidate(index))?;
        let resting = &placement.resting;
        let mut checks = self.checks.iter();
        let unseen = checks.find_map(|check| check.refuses_unseen(input, candidate, resting));
        if let Some(refusal) = unseen {
            return Ok(Verdict::Refused(refusal));
        }
        let others = self.checks.len().saturating_sub(1);
        let asked = if is_last {
            others..self.checks.len()
        } else {
            0..others
        };
        for check in self.checks.get_mut(asked).unwrap_or(&mut []) {
            let verdict = check.judge(input, candidate, resting);
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

    /// Adds the placements of a candidate that were refused since the search started: by the
    /// evaluator's checks, and by those of this search.
    pub fn add_refusals(&self, candidate: usize, refusals: &mut Refusals) {
        self.evaluator.add_refusals(candidate, refusals);
        if let Some(own) = self.refusals.get(candidate) {
            refusals.add(own);
        }
    }

    /// Gives the outcome of a candidate's placements since the search started.
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

    /// Gives the deviations of the evaluator and of this search from what was asked for.
    pub fn shortfalls(&self) -> impl Iterator<Item = &Shortfall> {
        self.evaluator
            .shortfall()
            .into_iter()
            .chain([&self.shortfall])
    }

    /// About how many bytes its evaluator holds for this ranking and the next.
    pub fn held_bytes(&self) -> usize {
        self.evaluator.held_bytes()
    }

    /// Time spent since the search started; none of it on proposing.
    pub fn timings(&self) -> Timings {
        self.timings
    }
}
