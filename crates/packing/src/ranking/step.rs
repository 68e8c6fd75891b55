//! Types that the parts of Algorithm 1 exchange in a step.

use std::ops::AddAssign;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::kernel::grid::Grid;
use crate::kernel::placement::RestingPlacement;
pub use crate::ranking::candidate::Candidate;
use crate::scene::Scene;

/// An error of a proposer, an evaluator or a check, local or remote.
pub type StageError = Box<dyn std::error::Error + Send + Sync>;

/// Answer of a proposer, an evaluator or a check.
pub type StageResult<T = ()> = Result<T, StageError>;

/// Input of a step: all that its stages need to know, so that they keep nothing of it beside. A
/// step over several containers is one input each ([`containers`](crate::planning::containers)).
///
/// All that its stages need to know of a step is in here: they keep nothing of it beside. A step
/// over several containers is one input each ([`containers`](crate::planning::containers)).
#[derive(Debug, Clone, Copy)]
pub struct StepInput<'a> {
    /// The container's grid.
    pub grid: &'a Grid,
    /// The container's content.
    pub scene: &'a Scene,
    /// The buffer.
    pub candidates: &'a [Candidate],
    /// Number of the step, which stochastic parts mix into their seed.
    pub step: u64,
    /// How many valid placements are wanted beside the best; each costs the checks down to it.
    pub alternatives: usize,
    /// When the answer has to be there; `None` where it is waited for as long as it takes.
    pub deadline: Option<Instant>,
    /// Whether a placement that there was no time to simulate is better than none.
    pub takes_untried: bool,
}

impl<'a> StepInput<'a> {
    /// The first step: the best valid placement is wanted, however long that takes.
    pub fn new(grid: &'a Grid, scene: &'a Scene, candidates: &'a [Candidate]) -> Self {
        Self {
            grid,
            scene,
            candidates,
            step: 0,
            alternatives: 0,
            deadline: None,
            takes_untried: false,
        }
    }

    /// How many valid placements are wanted.
    pub fn wanted(&self) -> usize {
        self.alternatives + 1
    }
}

/// A placement with the value of the objective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluated {
    /// Index into [`StepInput::candidates`].
    pub candidate: usize,
    /// Place and height.
    pub resting: RestingPlacement,
    /// `F(b, p)`; lower is better.
    pub value: f64,
}

impl Evaluated {
    /// The order of rankings: by value; equal values by candidate, yaw, x, y.
    pub fn rank_cmp(&self, other: &Self) -> std::cmp::Ordering {
        let key = |found: &Self| (found.candidate, found.resting.placement);
        self.value
            .total_cmp(&other.value)
            .then_with(|| key(self).cmp(&key(other)))
    }
}

/// How many placements of a candidate there were before any validity check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PlacementCounts {
    /// Placements whose footprint lies within the container, over all yaws, proposed or not.
    pub possible: u64,
    /// Proposed ones among them.
    pub proposed: u64,
    /// Proposed ones below the rim; of a bounded search, those looked at: all where none was valid.
    pub fitting: u64,
}

/// Deviation of a stage from what was asked for.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Shortfall {
    /// Deviations with their reasons, for people; each once.
    pub degraded: Vec<String>,
    /// Whether the time left some placements out: that none is valid is then no proof.
    pub is_cut: bool,
}

impl Shortfall {
    /// Says that something was done in another way.
    pub fn degrade(&mut self, reason: String) {
        if !self.degraded.contains(&reason) {
            self.degraded.push(reason);
        }
    }

    /// Says that some placements were left out for want of time.
    pub fn cut(&mut self, what: String) {
        self.degrade(what);
        self.is_cut = true;
    }

    /// Adds another stage's.
    pub fn add(&mut self, other: &Self) {
        for reason in &other.degraded {
            self.degrade(reason.clone());
        }
        self.is_cut |= other.is_cut;
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.degraded.clear();
        self.is_cut = false;
    }
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

impl AddAssign for Timings {
    fn add_assign(&mut self, other: Self) {
        self.propose += other.propose;
        self.evaluate += other.evaluate;
        self.check += other.check;
    }
}

impl Timings {
    /// All stages together.
    pub fn total(&self) -> Duration {
        self.propose + self.evaluate + self.check
    }
}
