//! Algorithm 1: planning one step over whoever proposes, evaluates and checks.

use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::check::ValidityCheck;
use crate::item::YawsMismatch;
use crate::objective::Order;
use crate::proposals::{Proposals, Proposer};
pub use crate::step::{Candidate, Evaluated, PlacementCounts, StageError, StepInput};
use crate::valid::ValidityFilter;

/// Why a step could not be planned. That nothing fits is no error: see [`Plan::choice`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The scene is not of the grid.
    #[error(
        "the heightmap has {} x {} cells, but the grid {} x {}",
        found.0, found.1, expected.0, expected.1
    )]
    SceneSize {
        /// Cells of the grid along x and y.
        expected: (usize, usize),
        /// Cells of the heightmap along x and y.
        found: (usize, usize),
    },
    /// An item was made for another number of yaws.
    #[error(transparent)]
    Yaws(#[from] YawsMismatch),
    /// The proposer failed.
    #[error("proposing placements failed: {0}")]
    Propose(#[source] StageError),
    /// The evaluator failed.
    #[error("evaluating placements failed: {0}")]
    Evaluate(#[source] StageError),
    /// A validity check failed to give an answer.
    #[error("the check '{check}' failed: {source}")]
    Check {
        /// The check's name.
        check: &'static str,
        /// What went wrong.
        source: StageError,
    },
}

/// Ranks placements by an objective. Placements that do not fit below the rim are left out.
pub trait Evaluator: Send {
    /// Starts ranking the proposals of some candidates; `group` holds indices into the input's candidates.
    ///
    /// # Errors
    /// What kept the evaluator from answering.
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> Result<(), StageError>;

    /// The next placement by increasing value; equal values by candidate, yaw, x, y. `None` after the last.
    ///
    /// # Errors
    /// What kept the evaluator from answering.
    fn next_best(&mut self, input: &StepInput<'_>) -> Result<Option<Evaluated>, StageError>;

    /// The counts of a candidate of the last ranked group.
    fn counts(&self, candidate: usize) -> PlacementCounts;

    /// The placements of a candidate of the last ranked group that were left out because a check refused them, per
    /// check: of evaluators that ask checks themselves.
    fn refusals(&self, _candidate: usize) -> &[(&'static str, u64)] {
        &[]
    }
}

/// Why no placement of an item was valid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "reason", content = "check")]
#[non_exhaustive]
pub enum Reason {
    /// Its footprint is larger than the container at every yaw, or it is taller than the container.
    TooLarge,
    /// None of its possible placements was proposed.
    NotProposed,
    /// Wherever it was proposed it would stick out above the rim.
    NoFit,
    /// Where it fits, this check refused it; of several checks the one that refused most.
    Rejected(&'static str),
}

impl std::fmt::Display for Reason {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooLarge => formatter.write_str("too large for the container"),
            Self::NotProposed => formatter.write_str("no placement proposed"),
            Self::NoFit => formatter.write_str("would stick out above the rim everywhere"),
            Self::Rejected(check) => write!(formatter, "{check} wherever it fits"),
        }
    }
}

/// What became of a candidate in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CandidateReport {
    /// Placements before the checks; all zero where the step was decided before the candidate was looked at.
    pub counts: PlacementCounts,
    /// Whether every placement was looked at and none was valid; then it has a reason.
    pub reason: Option<Reason>,
    /// Placements that the checks refused before the step was decided.
    pub rejected: u64,
}

/// Time spent in the stages of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Timings {
    /// Proposing.
    pub propose: Duration,
    /// Ranking by the objective.
    pub evaluate: Duration,
    /// Validity checks.
    pub check: Duration,
}

impl Timings {
    /// All stages together.
    pub fn total(&self) -> Duration {
        self.propose + self.evaluate + self.check
    }
}

/// The outcome of planning one step.
#[derive(Debug, Clone, Default)]
pub struct Plan {
    ranked: Vec<Evaluated>,
    candidates: Vec<CandidateReport>,
    /// Candidate, check, and how many placements of the one the other refused.
    refusals: Vec<(usize, &'static str, u64)>,
    timings: Timings,
    degraded: Option<String>,
    is_widened: bool,
}

impl Plan {
    /// The best valid placement; `None` where no candidate has one.
    pub fn choice(&self) -> Option<Evaluated> {
        self.ranked.first().copied()
    }

    /// The next best valid placements, as many as the planner was asked for.
    pub fn alternatives(&self) -> &[Evaluated] {
        self.ranked.get(1..).unwrap_or(&[])
    }

    /// What became of each candidate, in the input's order.
    pub fn candidates(&self) -> &[CandidateReport] {
        &self.candidates
    }

    /// How many placements of a candidate each check refused before the step was decided; those that refused none are
    /// left out.
    pub fn refusals(&self, candidate: usize) -> impl Iterator<Item = (&'static str, u64)> {
        let refusals = self.refusals.iter();
        refusals
            .filter(move |(refused, ..)| *refused == candidate)
            .map(|(_, check, count)| (*check, *count))
    }

    /// Why the step was not planned on the proposals that were wanted, where it was not: the answer is as good, but
    /// took longer.
    pub fn degraded(&self) -> Option<&str> {
        self.degraded.as_deref()
    }

    /// Whether none of the proposals was valid, so that all placements were searched.
    pub fn is_widened(&self) -> bool {
        self.is_widened
    }

    /// Time per stage.
    pub fn timings(&self) -> Timings {
        self.timings
    }
}

/// Plans steps by Algorithm 1: propose, rank, check from the best value down, take the first valid placement. Where no
/// proposal of any candidate is valid, all placements are searched before the buffer is given up.
pub struct Planner {
    proposer: Box<dyn Proposer>,
    evaluator: Box<dyn Evaluator>,
    filter: ValidityFilter,
    order: Order,
    seed: u64,
    alternatives: usize,
    proposals: Proposals,
    sequence: Vec<usize>,
    /// Per candidate of the input: the check that refuses all of its placements.
    ruled_out: Vec<Option<&'static str>>,
    plan: Plan,
}

impl Planner {
    /// A planner; checks are applied in the order of their cost. `seed` drives the shuffled order.
    pub fn new(
        proposer: Box<dyn Proposer>,
        evaluator: Box<dyn Evaluator>,
        checks: Vec<Box<dyn ValidityCheck>>,
        order: Order,
        seed: u64,
    ) -> Self {
        Self {
            proposer,
            evaluator,
            filter: ValidityFilter::new(checks),
            order,
            seed,
            alternatives: 0,
            proposals: Proposals::default(),
            sequence: Vec::new(),
            ruled_out: Vec::new(),
            plan: Plan::default(),
        }
    }

    /// Asks for up to `count` valid placements beside the best; each costs the checks down to it.
    #[must_use]
    pub fn with_alternatives(mut self, count: usize) -> Self {
        self.alternatives = count;
        self
    }

    /// Asks for up to `count` valid placements beside the best from now on.
    pub fn set_alternatives(&mut self, count: usize) {
        self.alternatives = count;
    }

    /// Plans one step. To learn why an item of the buffer cannot be placed although another can, plan with it as the
    /// only candidate.
    ///
    /// # Errors
    /// [`PlanError`] where the input does not match the grid or a stage failed.
    pub fn plan(&mut self, input: &StepInput<'_>) -> Result<&Plan, PlanError> {
        validate(input)?;
        let started = Instant::now();
        self.ruled_out.clear();
        for candidate in input.candidates {
            self.ruled_out
                .push(self.filter.ruled_out_by(input, candidate)?);
        }
        let took = started.elapsed();
        if self.ruled_out.iter().all(Option::is_none) {
            self.plan_for(input)?;
        } else {
            self.plan_for_others(input)?;
        }
        self.plan.timings.check += took;
        Ok(&self.plan)
    }

    /// Plans without the candidates that are ruled out: nothing is proposed for them or searched.
    fn plan_for_others(&mut self, input: &StepInput<'_>) -> Result<(), PlanError> {
        let candidates = || input.candidates.iter().zip(&self.ruled_out).enumerate();
        let others = || candidates().filter(|(_, (_, check))| check.is_none());
        let indices: Vec<usize> = others().map(|(index, _)| index).collect();
        let others: Vec<Candidate> = others().map(|(_, (held, _))| held.clone()).collect();
        if others.is_empty() {
            self.begin(0);
        } else {
            self.plan_for(&StepInput {
                candidates: &others,
                ..*input
            })?;
        }
        let ranked = self.plan.ranked.iter_mut();
        let ranked = ranked.map(|placement| &mut placement.candidate);
        let refused = self.plan.refusals.iter_mut();
        for candidate in ranked.chain(refused.map(|(candidate, ..)| candidate)) {
            if let Some(index) = indices.get(*candidate) {
                *candidate = *index;
            }
        }
        let mut reports = std::mem::take(&mut self.plan.candidates).into_iter();
        let report = |check: &Option<&'static str>| match check {
            None => reports.next().unwrap_or_default(),
            Some(check) => CandidateReport {
                reason: Some(Reason::Rejected(check)),
                ..CandidateReport::default()
            },
        };
        self.plan.candidates = self.ruled_out.iter().map(report).collect();
        Ok(())
    }

    fn begin(&mut self, candidates: usize) {
        self.plan.ranked.clear();
        self.plan.refusals.clear();
        self.plan.candidates.clear();
        self.plan
            .candidates
            .resize(candidates, CandidateReport::default());
        self.plan.timings = Timings::default();
        self.plan.degraded = None;
        self.plan.is_widened = false;
    }

    fn plan_for(&mut self, input: &StepInput<'_>) -> Result<(), PlanError> {
        self.begin(input.candidates.len());
        let started = Instant::now();
        self.proposer
            .propose(input, &mut self.proposals)
            .map_err(PlanError::Propose)?;
        self.plan.timings.propose = started.elapsed();
        self.plan.degraded = self.proposals.degraded().map(str::to_owned);

        self.arrange(input);
        self.search_all(input)?;
        if self.plan.choice().is_none() && self.proposals.is_pruned() {
            // Better late than not at all: an item is given up only where no placement is valid.
            self.proposals.widen();
            self.plan.is_widened = true;
            self.search_all(input)?;
        }
        Ok(())
    }

    /// Searches the candidates in their order until one has a valid placement.
    fn search_all(&mut self, input: &StepInput<'_>) -> Result<(), PlanError> {
        if self.order == Order::Balance {
            return self.search(input, 0..self.sequence.len());
        }
        for position in 0..self.sequence.len() {
            self.search(input, position..position + 1)?;
            if self.plan.choice().is_some() {
                break;
            }
        }
        Ok(())
    }

    /// Brings the candidates into the order in which they are searched.
    fn arrange(&mut self, input: &StepInput<'_>) {
        self.sequence.clear();
        self.sequence.extend(0..input.candidates.len());
        match self.order {
            Order::Balance | Order::Arrival => {}
            Order::BboxVolume => self.sequence.sort_unstable_by_key(|candidate| {
                let volume = input
                    .candidates
                    .get(*candidate)
                    .map_or(0, |held| held.item.box_voxel_count());
                (std::cmp::Reverse(volume), *candidate)
            }),
            Order::Shuffled => {
                let mut random =
                    ChaCha8Rng::seed_from_u64(crate::random::mix(self.seed, input.step));
                self.sequence.shuffle(&mut random);
            }
        }
    }

    /// Searches some of the candidates together and adds what is valid to the plan.
    fn search(
        &mut self,
        input: &StepInput<'_>,
        positions: std::ops::Range<usize>,
    ) -> Result<(), PlanError> {
        let group = self.sequence.get(positions).unwrap_or(&[]);
        let Plan {
            ranked,
            candidates,
            refusals,
            timings,
            ..
        } = &mut self.plan;
        let searched = self.filter.search(
            &mut *self.evaluator,
            input,
            group,
            &self.proposals,
            self.alternatives + 1,
            ranked,
        )?;
        timings.evaluate += searched.evaluate;
        timings.check += searched.check;
        for (position, candidate) in group.iter().enumerate() {
            let Some(report) = candidates.get_mut(*candidate) else {
                continue;
            };
            let refused = self.evaluator.refusals(*candidate).iter().copied();
            let refused = refused.chain(self.filter.refusals(position));
            report.counts = self.evaluator.counts(*candidate);
            report.rejected = refused.clone().map(|(_, count)| count).sum();
            refusals.retain(|(known, ..)| known != candidate);
            let of_checks = refused.clone().filter(|(_, count)| *count > 0);
            refusals.extend(of_checks.map(|(check, count)| (*candidate, check, count)));
            let placed = ranked.iter().any(|ranked| ranked.candidate == *candidate);
            if searched.is_exhausted && !placed {
                report.reason = Some(reason(&report.counts, refused));
            }
        }
        Ok(())
    }
}

fn validate(input: &StepInput<'_>) -> Result<(), PlanError> {
    let heightmap = input.scene.heightmap();
    let expected = (input.grid.nx(), input.grid.ny());
    let found = (heightmap.nx(), heightmap.ny());
    if found != expected {
        return Err(PlanError::SceneSize { expected, found });
    }
    for candidate in input.candidates {
        candidate.item.check_yaws(input.grid)?;
    }
    Ok(())
}

fn reason(counts: &PlacementCounts, refused: impl Iterator<Item = (&'static str, u64)>) -> Reason {
    if counts.possible == 0 {
        return Reason::TooLarge;
    }
    if counts.proposed == 0 {
        return Reason::NotProposed;
    }
    match refused.max_by_key(|(_, count)| *count) {
        Some((check, count)) if counts.fitting > 0 && count > 0 => Reason::Rejected(check),
        _ => Reason::NoFit,
    }
}
