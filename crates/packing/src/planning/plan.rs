//! Algorithm 1: planning one step over whoever proposes, evaluates and checks.

use std::cmp::Reverse;
use std::sync::Arc;
use std::time::Instant;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::checks::check::{BoxedCheck, Evidence};
use crate::kernel::item::YawsMismatch;
use crate::kernel::objective::Order;
use crate::kernel::random;
use crate::planning::valid::{SearchError, ValidPlacement, ValidSearch};
use crate::ranking::evaluator::Evaluator;
use crate::ranking::proposals::{Proposals, Proposer};
use crate::ranking::refusal::{Refusal, Refusals};
use crate::ranking::step::{
    Candidate, Evaluated, PlacementCounts, Shortfall, StageError, StepInput, Timings,
};
use crate::scene::Scene;

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
    /// The evaluator or a check failed.
    #[error(transparent)]
    Search(#[from] SearchError),
}

/// Why no placement of an item was valid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Reason {
    /// Its footprint is larger than the container at every yaw, or it is taller than the container.
    #[error("too large for the container")]
    TooLarge,
    /// None of its possible placements was proposed.
    #[error("no placement proposed")]
    NotProposed,
    /// Wherever it was proposed it would stick out above the rim.
    #[error("would stick out above the rim everywhere")]
    NoFit,
    /// None that was proposed was valid, and nothing else may be placed ([`Proposals::finish`]).
    #[error("none of the placements that were tried is valid")]
    NoneTried,
    /// Refused wherever it fits: the most frequent refusal.
    #[error("{} wherever it fits{}", .0.cause, .0.explanation())]
    Rejected(Refusal),
}

/// Outcome of a candidate in a step.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CandidateReport {
    /// Placements before the checks; all zero where the candidate was not looked at.
    pub counts: PlacementCounts,
    /// Refusals of its last search before the step was decided; of all: [`Plan::refusals`].
    pub refusals: Refusals,
    /// Why none was valid; `None` where one was, or not all possible ones were looked at.
    pub reason: Option<Reason>,
}

impl CandidateReport {
    fn clear(&mut self) {
        self.counts = PlacementCounts::default();
        self.refusals.clear();
        self.reason = None;
    }
}

/// The outcome of planning one step.
#[derive(Debug, Clone, Default)]
pub struct Plan {
    ranked: Vec<ValidPlacement>,
    candidates: Vec<CandidateReport>,
    refusals: Refusals,
    timings: Timings,
    shortfall: Shortfall,
    is_widened: bool,
}

impl Plan {
    /// The best valid placement; `None` where no candidate has one.
    pub fn choice(&self) -> Option<Evaluated> {
        self.ranked.first().map(|best| best.placement)
    }

    /// Gives the findings of the checks about the choice.
    pub fn evidence(&self) -> Option<&Evidence> {
        self.ranked.first().map(|best| &best.evidence)
    }

    /// The next best valid placements, as many as the step was asked for.
    pub fn alternatives(&self) -> impl Iterator<Item = &Evaluated> {
        self.ranked.iter().skip(1).map(|next| &next.placement)
    }

    /// Gives the outcome of each candidate, in the input's order.
    pub fn candidates(&self) -> &[CandidateReport] {
        &self.candidates
    }

    /// Placements of all candidates that were refused before the step was decided. Where it was
    /// widened, first proposals may count twice, as the checks were asked twice.
    pub fn refusals(&self) -> &Refusals {
        &self.refusals
    }

    /// Why the step was not planned as was asked for, where it was not: it took longer, or a check
    /// knew less of the choice than it could.
    pub fn degraded(&self) -> &[String] {
        &self.shortfall.degraded
    }

    /// Whether the time was over before everything was looked at: something may fit all the same.
    pub fn is_cut(&self) -> bool {
        self.shortfall.is_cut
    }

    /// Whether none of the proposals was valid, so that all placements were searched.
    pub fn is_widened(&self) -> bool {
        self.is_widened
    }

    /// Time per stage.
    pub fn timings(&self) -> Timings {
        self.timings
    }

    fn begin(&mut self, candidates: usize) {
        self.ranked.clear();
        self.candidates.iter_mut().for_each(CandidateReport::clear);
        self.candidates
            .resize(candidates, CandidateReport::default());
        self.refusals.clear();
        self.timings = Timings::default();
        self.shortfall.clear();
        self.is_widened = false;
    }
}

/// Plans steps by Algorithm 1: propose, rank, check from the best value down, take the first valid
/// placement. Where no proposal is valid, all placements are searched, unless the proposer says
/// that nothing else may be placed ([`Proposals::finish`]).
pub struct Planner {
    proposer: Box<dyn Proposer>,
    search: ValidSearch,
    order: Order,
    seed: u64,
    proposals: Proposals,
    sequence: Vec<usize>,
    /// Per candidate of the input: why all of its placements are refused.
    ruled_out: Vec<Option<Refusal>>,
    /// Candidates of the last call, where none of them had a valid placement.
    unplaced: Option<Unplaced>,
    plan: Plan,
}

/// Candidates that have no valid placement in a scene. As long as nothing has changed there, such
/// as while items are set aside, they are not searched again.
struct Unplaced {
    step: u64,
    scene: Scene,
    reports: Vec<(Candidate, CandidateReport)>,
}

impl Unplaced {
    fn is_of(&self, input: &StepInput<'_>) -> bool {
        self.step == input.step && self.scene == *input.scene
    }

    fn report(&self, candidate: &Candidate) -> Option<&CandidateReport> {
        let mut reports = self.reports.iter();
        let known = reports.find(|(known, _)| is_same(known, candidate));
        known.map(|(_, report)| report)
    }
}

/// Says whether two candidates are one, with the same rules.
fn is_same(one: &Candidate, other: &Candidate) -> bool {
    let model = |candidate: &Candidate| candidate.model.as_ref().map(Arc::as_ptr);
    Arc::ptr_eq(&one.item, &other.item)
        && (one.arrival, one.pose, one.stop) == (other.arrival, other.pose, other.stop)
        && (one.mass_kg, one.lying, one.rules) == (other.mass_kg, other.lying, other.rules)
        && model(one) == model(other)
}

impl Planner {
    /// A planner; checks are applied in the order of their cost. `seed` drives the shuffled order.
    pub fn new(
        proposer: Box<dyn Proposer>,
        evaluator: Box<dyn Evaluator>,
        checks: Vec<BoxedCheck>,
        order: Order,
        seed: u64,
    ) -> Self {
        Self {
            proposer,
            search: ValidSearch::new(evaluator, checks),
            order,
            seed,
            proposals: Proposals::default(),
            sequence: Vec::new(),
            ruled_out: Vec::new(),
            unplaced: None,
            plan: Plan::default(),
        }
    }

    /// Plans one step. To learn why an item of the buffer cannot be placed although another can,
    /// plan with it as the only candidate.
    ///
    /// # Errors
    /// [`PlanError`] where the input does not match the grid or a stage failed.
    pub fn plan(&mut self, input: &StepInput<'_>) -> Result<&Plan, PlanError> {
        validate(input)?;
        let started = Instant::now();
        self.search.begin(input)?;
        self.ruled_out.clear();
        for candidate in input.candidates {
            self.ruled_out
                .push(self.search.ruled_out(input, candidate)?);
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
        let others = || candidates().filter(|(_, (_, refusal))| refusal.is_none());
        let indices: Vec<usize> = others().map(|(index, _)| index).collect();
        let others: Vec<Candidate> = others().map(|(_, (held, _))| held.clone()).collect();
        if others.is_empty() {
            self.plan.begin(0);
        } else {
            self.plan_for(&StepInput {
                candidates: &others,
                ..*input
            })?;
        }
        for ranked in &mut self.plan.ranked {
            let candidate = &mut ranked.placement.candidate;
            if let Some(index) = indices.get(*candidate) {
                *candidate = *index;
            }
        }
        let mut reports = std::mem::take(&mut self.plan.candidates).into_iter();
        let report = |refusal: &Option<Refusal>| match refusal {
            None => reports.next().unwrap_or_default(),
            Some(refusal) => CandidateReport {
                reason: Some(Reason::Rejected(refusal.clone())),
                ..CandidateReport::default()
            },
        };
        self.plan.candidates = self.ruled_out.iter().map(report).collect();
        Ok(())
    }

    fn plan_for(&mut self, input: &StepInput<'_>) -> Result<(), PlanError> {
        self.plan.begin(input.candidates.len());
        let started = Instant::now();
        self.proposer
            .propose(input, &mut self.proposals)
            .map_err(PlanError::Propose)?;
        self.plan.timings.propose = started.elapsed();

        self.arrange(input);
        let unplaced = self.unplaced.take().filter(|it| it.is_of(input));
        let report = |index: &usize| {
            let candidate = input.candidates.get(*index)?;
            unplaced.as_ref()?.report(candidate)
        };
        self.sequence.retain(|index| report(index).is_none());
        for (index, entry) in self.plan.candidates.iter_mut().enumerate() {
            if let Some(report) = report(&index) {
                entry.clone_from(report);
            }
        }
        self.search_all(input)?;
        if self.plan.choice().is_none() && !self.plan.is_cut() {
            // Better late than not at all: an item is given up only where no placement is valid.
            self.plan.is_widened = self.proposals.may_be_widened();
            if self.plan.is_widened {
                self.proposals.widen();
                self.search.widen();
                self.search_all(input)?;
            }
            if self.plan.choice().is_none() {
                self.plan.ranked.extend(self.search.last_resort(input)?);
            }
        }
        if self.plan.choice().is_none() && self.plan.is_cut() && input.takes_untried {
            self.plan.ranked.extend(self.search.take_untried());
        }
        // Only where all placements were looked at.
        if self.plan.choice().is_none() && !self.plan.is_cut() && !self.proposals.is_final() {
            let reports = input.candidates.iter().zip(&self.plan.candidates);
            self.unplaced = Some(Unplaced {
                step: input.step,
                scene: input.scene.clone(),
                reports: reports
                    .map(|(candidate, report)| (candidate.clone(), report.clone()))
                    .collect(),
            });
        }
        if let Some(reason) = self.proposals.degraded() {
            self.plan.shortfall.degrade(reason.to_owned());
        }
        if let Some(best) = self.plan.ranked.first() {
            for reason in &best.evidence.degraded {
                self.plan.shortfall.degrade(reason.clone());
            }
        }
        Ok(())
    }

    /// Searches the candidates, all together or in their order, until one has a valid placement.
    fn search_all(&mut self, input: &StepInput<'_>) -> Result<(), PlanError> {
        let count = self.sequence.len();
        let together = match self.order {
            Order::Balance => count.max(1),
            _ => 1,
        };
        for start in (0..count).step_by(together) {
            self.search_group(input, start..start + together)?;
            if self.plan.choice().is_some() || self.plan.is_cut() {
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
                let held = input.candidates.get(*candidate);
                let volume = held.map_or(0, |held| held.item.box_voxel_count());
                (Reverse(volume), *candidate)
            }),
            Order::Shuffled => {
                let seed = random::mix(self.seed, input.step);
                self.sequence.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
            }
        }
    }

    /// Searches some of the candidates together and adds what is valid to the plan.
    fn search_group(
        &mut self,
        input: &StepInput<'_>,
        positions: std::ops::Range<usize>,
    ) -> Result<(), PlanError> {
        let group = self.sequence.get(positions).unwrap_or(&[]);
        let (search, plan) = (&mut self.search, &mut self.plan);
        search.rank(input, group, &self.proposals)?;
        let mut is_exhausted = false;
        while plan.ranked.len() < input.wanted() && !is_exhausted {
            let next = search.next_valid(input)?;
            is_exhausted = next.is_none();
            plan.ranked.extend(next);
        }
        plan.timings.evaluate += search.timings().evaluate;
        plan.timings.check += search.timings().check;
        for shortfall in search.shortfalls() {
            plan.shortfall.add(shortfall);
        }
        let is_decided = is_exhausted && !search.is_cut();
        for candidate in group {
            let Some(report) = plan.candidates.get_mut(*candidate) else {
                continue;
            };
            report.clear();
            report.counts = search.counts(*candidate);
            search.add_refusals(*candidate, &mut report.refusals);
            plan.refusals.add(&report.refusals);
            let mut ranked = plan.ranked.iter();
            let is_placed = ranked.any(|ranked| ranked.placement.candidate == *candidate);
            if is_decided && !is_placed {
                report.reason = Some(reason(report, self.proposals.is_final()));
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

fn reason(
    CandidateReport {
        counts, refusals, ..
    }: &CandidateReport,
    is_final: bool,
) -> Reason {
    match refusals.most() {
        _ if counts.possible == 0 => Reason::TooLarge,
        _ if is_final => Reason::NoneTried,
        _ if counts.proposed == 0 => Reason::NotProposed,
        Some(most) if counts.fitting > 0 => Reason::Rejected(most.clone()),
        _ => Reason::NoFit,
    }
}
