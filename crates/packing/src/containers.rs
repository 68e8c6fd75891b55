//! A step over several containers that are open at the same time.
//!
//! Each has a planner of its own, and all plan for the same buffer. What a container offers stays known as long as its content is the
//! same: then only items that are new in the buffer are looked at. And a container is searched no further than to the value of what
//! another one offers.

use std::collections::BTreeSet;
use std::ops::AddAssign;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::check::Evidence;
use crate::grid::Grid;
use crate::heightmap::Scene;
use crate::plan::{Candidate, Plan, PlanError, Planner, StepInput, Timings};
use crate::refusal::Refusals;
use crate::step::Evaluated;

/// Which of the open containers an item goes into.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContainerChoice {
    /// The fullest in which an item of the buffer has a valid placement: gaps are filled before room is begun.
    #[default]
    Fullest,
    /// That of the valid placement with the best value of all; of equal ones the container that was opened first.
    Best,
}

/// An open container, as a step finds it.
#[derive(Debug, Clone, Copy)]
pub struct OpenContainer<'a> {
    /// Its grid.
    pub grid: &'a Grid,
    /// Its content.
    pub scene: &'a Scene,
    /// How much of it is filled, in percent of its volume.
    pub filled_percent: f64,
}

/// What a step over open containers is planned on, and what is asked of it.
#[derive(Clone, Copy)]
pub struct ContainersStep<'a> {
    /// The open containers, in the order in which they were opened.
    pub containers: &'a [OpenContainer<'a>],
    /// The buffer.
    pub candidates: &'a [Candidate],
    /// Which container, where several are possible.
    pub choice: ContainerChoice,
    /// Whether a container may take an item at all, wherever it would lie there.
    pub admits: &'a dyn Fn(usize, &Candidate) -> bool,
    /// Number of the step, which stochastic parts mix into their seed.
    pub step: u64,
    /// When the answer has to be there; `None` where it is waited for as long as it takes.
    pub deadline: Option<Instant>,
}

impl<'a> ContainersStep<'a> {
    /// The first step: every container may take every item, and the fullest that can takes one, however long that takes.
    pub fn new(containers: &'a [OpenContainer<'a>], candidates: &'a [Candidate]) -> Self {
        Self {
            containers,
            candidates,
            choice: ContainerChoice::default(),
            admits: &|_, _| true,
            step: 0,
            deadline: None,
        }
    }

    /// What a container may take.
    fn admitted(&self, container: usize) -> Vec<Candidate> {
        let candidates = self.candidates.iter();
        let admitted = candidates.filter(|held| (self.admits)(container, held));
        admitted.cloned().collect()
    }
}

/// What a step over open containers chooses.
#[derive(Debug, Clone)]
pub struct Chosen {
    /// The container, in the order of the step.
    pub container: usize,
    /// The placement; its candidate is an index into those of the step.
    pub placement: Evaluated,
    /// What the checks found out about it.
    pub evidence: Evidence,
    /// Why it was not planned as was asked for, where it was not.
    pub degraded: Vec<String>,
    /// Whether none of the proposals was valid, so that all placements were searched.
    pub is_widened: bool,
}

/// What planning a step took, over all containers.
#[derive(Debug, Clone, Default)]
pub struct Effort {
    /// Time per stage.
    pub timings: Timings,
    /// Placements that were refused before the step was decided.
    pub refusals: Refusals,
    /// Containers in which something was searched.
    pub searched: usize,
    /// Whether the time was over before everything was looked at.
    pub is_cut: bool,
}

impl Effort {
    fn add(&mut self, plan: &Plan) {
        self.timings += plan.timings();
        self.refusals.add(plan.refusals());
        self.searched += 1;
        self.is_cut |= plan.is_cut();
    }
}

impl AddAssign for Effort {
    fn add_assign(&mut self, other: Self) {
        self.timings += other.timings;
        self.refusals.add(&other.refusals);
        self.searched += other.searched;
        self.is_cut |= other.is_cut;
    }
}

/// The planners of the open containers, in the order in which those were opened.
#[derive(Default)]
pub struct OpenContainers {
    open: Vec<Known>,
}

impl OpenContainers {
    /// A container is opened; it stands behind the others.
    pub fn open(&mut self, planner: Planner) {
        self.open.push(Known {
            planner,
            items: BTreeSet::new(),
            least: f64::INFINITY,
            best: None,
        });
    }

    /// A container is closed. Those behind it move up.
    pub fn close(&mut self, container: usize) {
        if container < self.open.len() {
            self.open.remove(container);
        }
    }

    /// The content of a container has changed: what it offered is not known any more.
    pub fn changed(&mut self, container: usize) {
        if let Some(known) = self.open.get_mut(container) {
            known.forget();
        }
    }

    /// Plans a step over the open containers, each as it is now; `None` where no candidate has a valid placement in any that may take
    /// it.
    ///
    /// # Errors
    /// [`PlanError`] where a container does not match its grid or a stage failed.
    pub fn plan(
        &mut self,
        step: &ContainersStep<'_>,
    ) -> Result<(Option<Chosen>, Effort), PlanError> {
        let mut effort = Effort::default();
        let mut best = match step.choice {
            ContainerChoice::Best => self.best_known(step),
            ContainerChoice::Fullest => None,
        };
        for container in order(step.containers, step.choice) {
            let open = self.open.get_mut(container);
            let Some((known, at)) = open.zip(step.containers.get(container)) else {
                continue;
            };
            let admitted = step.admitted(container);
            let input = StepInput {
                step: step.step,
                deadline: step.deadline,
                below: best.as_ref().map(|best| best.below(container)),
                ..StepInput::new(at.grid, at.scene, &admitted)
            };
            if let Some(offer) = known.offer(&input, &mut effort)? {
                best = Some(Best { container, offer });
            }
            if best.is_some() && step.choice == ContainerChoice::Fullest {
                break;
            }
        }
        let chosen = best.and_then(|Best { container, offer }| {
            let candidate = offer.among(step.candidates)?;
            Some(Chosen {
                container,
                placement: Evaluated {
                    candidate,
                    ..offer.placement
                },
                evidence: offer.evidence,
                degraded: offer.degraded,
                is_widened: offer.is_widened,
            })
        });
        Ok((chosen, effort))
    }

    /// The best of what containers are known to offer of what they may take.
    fn best_known(&self, step: &ContainersStep<'_>) -> Option<Best> {
        let known = self.open.iter().enumerate();
        let offers = known.filter_map(|(container, known)| {
            let offer = known.offered(&step.admitted(container))?.clone();
            Some(Best { container, offer })
        });
        // Of equal ones, `min_by` gives the first.
        offers.min_by(|a, b| a.offer.placement.value.total_cmp(&b.offer.placement.value))
    }
}

/// In which order the containers are asked.
fn order(containers: &[OpenContainer<'_>], choice: ContainerChoice) -> Vec<usize> {
    let mut order: Vec<usize> = (0..containers.len()).collect();
    if choice == ContainerChoice::Fullest {
        let percent = |container: &usize| {
            let container = containers.get(*container);
            container.map_or(0.0, |container| container.filled_percent)
        };
        order.sort_by(|a, b| percent(b).total_cmp(&percent(a)));
    }
    order
}

/// The best offer so far.
struct Best {
    container: usize,
    offer: Offer,
}

impl Best {
    /// Below which value the offer of a container is better.
    fn below(&self, container: usize) -> f64 {
        let value = self.offer.placement.value;
        match container < self.container {
            true => value.next_up(),
            false => value,
        }
    }
}

/// What a container offers: the best valid placement of an item.
#[derive(Debug, Clone)]
struct Offer {
    arrival: usize,
    pose: usize,
    placement: Evaluated,
    evidence: Evidence,
    degraded: Vec<String>,
    is_widened: bool,
}

impl Offer {
    fn of(plan: &Plan, candidates: &[Candidate]) -> Option<Self> {
        let placement = plan.choice()?;
        let held = candidates.get(placement.candidate)?;
        Some(Self {
            arrival: held.arrival,
            pose: held.pose,
            placement,
            evidence: plan.evidence().cloned().unwrap_or_default(),
            degraded: plan.degraded().to_vec(),
            is_widened: plan.is_widened(),
        })
    }

    /// The index of its candidate among these.
    fn among(&self, candidates: &[Candidate]) -> Option<usize> {
        let is_it = |held: &Candidate| (held.arrival, held.pose) == (self.arrival, self.pose);
        candidates.iter().position(is_it)
    }
}

/// A container's planner, and what was found since the content changed.
struct Known {
    planner: Planner,
    /// The arrivals of the items that were looked at.
    items: BTreeSet<usize>,
    /// No valid placement of theirs has a lower value.
    least: f64,
    /// The best of their valid placements, where it was not taken for another container to be better.
    best: Option<Offer>,
}

impl Known {
    fn forget(&mut self) {
        self.items.clear();
        self.least = f64::INFINITY;
        self.best = None;
    }

    /// The best valid placement of the items that were looked at, where its item still waits.
    fn offered(&self, candidates: &[Candidate]) -> Option<&Offer> {
        let best = self.best.as_ref();
        best.filter(|best| best.among(candidates).is_some())
    }

    /// The best valid placement of the candidates with a value below that of the input.
    fn offer(
        &mut self,
        input: &StepInput<'_>,
        effort: &mut Effort,
    ) -> Result<Option<Offer>, PlanError> {
        if !self.planner.is_by_value() {
            return self.offer_anew(input, effort);
        }
        let kept = self.offered(input.candidates).cloned();
        let value = kept.as_ref().map(|kept| kept.placement.value);
        let below = [input.below, value].into_iter().flatten();
        let below = below.min_by(f64::total_cmp);
        // What was looked at only down to the offer of another container, which is gone by now, may have something between.
        let is_settled = below.unwrap_or(f64::INFINITY) <= self.least;
        if !is_settled {
            self.items.clear();
            self.least = f64::INFINITY;
        }
        let fresh = input.candidates.iter();
        let fresh = fresh.filter(|held| !self.items.contains(&held.arrival));
        let fresh: Vec<Candidate> = fresh.cloned().collect();
        let mut best = kept;
        if !fresh.is_empty() {
            let plan = self.planner.plan(&StepInput {
                candidates: &fresh,
                below,
                ..*input
            })?;
            effort.add(plan);
            let found = Offer::of(plan, &fresh);
            if !plan.is_cut() {
                let least = found.as_ref().map(|found| found.placement.value).or(below);
                self.least = self.least.min(least.unwrap_or(f64::INFINITY));
                self.items.extend(fresh.iter().map(|held| held.arrival));
                self.best = found.clone().or(best.clone());
            }
            best = found.or(best);
        }
        let wanted = input.below.unwrap_or(f64::INFINITY);
        Ok(best.filter(|offer| offer.placement.value < wanted))
    }

    /// As [`Self::offer`], of planners of which nothing can be kept.
    fn offer_anew(
        &mut self,
        input: &StepInput<'_>,
        effort: &mut Effort,
    ) -> Result<Option<Offer>, PlanError> {
        let plan = self.planner.plan(&StepInput {
            below: None,
            ..*input
        })?;
        effort.add(plan);
        let offer = Offer::of(plan, input.candidates);
        let below = input.below.unwrap_or(f64::INFINITY);
        Ok(offer.filter(|offer| offer.placement.value < below))
    }
}
