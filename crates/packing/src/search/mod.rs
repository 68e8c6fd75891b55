//! The local evaluator: a best-first search over placements that computes an objective only where it may matter.
//!
//! Placements are grouped into levels, one per view and resting height, each with a bound that no value in it is
//! below. Levels are expanded in the order of their bounds; a value is final once it is below every bound left. So
//! the expensive terms are computed for the few placements near the best alone, and the order of values, ties
//! included, is that of a full sort.

mod blocks;
mod evaluation;
mod passes;
mod propose;
mod proposed;

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

use pulp::Arch;
use rayon::prelude::*;

use crate::distance::DistanceLevels;
use crate::evaluator::Evaluator;
use crate::grid::{Grid, Units};
use crate::objective::{Heuristic, Objective, Order, ViewTerms, WeightError, Weights};
use crate::placement::{Placement, RestingPlacement};
use crate::proposals::{CandidateProposals, Proposals, YawRange, possible_count_at};
use crate::resting_maps::{RestingMap, RestingMaps};
use crate::step::{Candidate, Evaluated, PlacementCounts, StageError, StepInput};
use blocks::{BlockSearch, Ranking};
use evaluation::{EvaluateAll, Evaluation};
use passes::{Collect, Summarise, UpdateDistance};
pub use propose::ProposeBest;
use proposed::{ProposedView, ProposedViews};

/// Placements evaluated together when a second thread is at hand.
const PARALLEL_BATCH: usize = 1024;

/// Above every resting height.
const NO_HEIGHT: Units = Units::MAX;

/// Evaluates a heuristic over proposals on this machine.
#[derive(Debug)]
pub struct Search {
    grid: Grid,
    objective: Objective,
    seed: u64,
    arch: Arch,
    pool: Option<Arc<rayon::ThreadPool>>,
    resting: RestingMaps,
    distance: Option<DistanceLevels>,
    scene_is_stale: bool,
    views: Vec<ViewState>,
    proposed: ProposedViews,
    counts: Vec<PlacementCounts>,
    /// Where placements are not all looked at.
    blocks: Option<BlockSearch>,
    levels: BinaryHeap<Level>,
    pending: Vec<Pending>,
    ready: BinaryHeap<Ready>,
}

/// A view of a candidate that takes part in the current ranking.
#[derive(Debug, Clone, Copy)]
struct ViewState {
    candidate: usize,
    yaw: usize,
    terms: ViewTerms,
    /// The greatest resting height that fits below the rim.
    limit: Units,
    /// Index of its proposed placements, where those are not all.
    proposed: Option<usize>,
}

/// The placements of a view that take part.
#[derive(Clone, Copy)]
enum Placements<'a> {
    All(&'a RestingMap),
    Some(&'a ProposedView),
}

/// What a view's placements amount to.
#[derive(Debug, Clone, Copy, Default)]
struct Summary {
    proposed: u64,
    fitting: u64,
    lowest: Option<Units>,
}

/// The placements of a view with one resting height.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Level {
    bound: f64,
    view: usize,
    height: Units,
}

#[derive(Debug, Clone, Copy)]
struct Pending {
    view: usize,
    x: usize,
    y: usize,
    height: Units,
    value: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Ready(Evaluated);

// Both heaps give the least first.
impl Eq for Level {}
impl Ord for Level {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |level: &Self| (level.view, level.height);
        other
            .bound
            .total_cmp(&self.bound)
            .then_with(|| key(other).cmp(&key(self)))
    }
}
impl PartialOrd for Level {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Eq for Ready {}
impl Ord for Ready {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |ready: &Self| (ready.0.candidate, ready.0.resting.placement);
        other
            .0
            .value
            .total_cmp(&self.0.value)
            .then_with(|| key(other).cmp(&key(self)))
    }
}
impl PartialOrd for Ready {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// What a search is made for.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchSettings {
    /// What placements are judged by.
    pub heuristic: Heuristic,
    /// Whether the items of the buffer compete together: the Balance order adds its term to the objective.
    pub order: Order,
    /// The weights of the objective's terms.
    pub weights: Weights,
    /// Drives [`Heuristic::Random`].
    pub seed: u64,
}

/// The paper's: SDFM, the items of the buffer together.
impl Default for SearchSettings {
    fn default() -> Self {
        Self {
            heuristic: Heuristic::Sdfm,
            order: Order::Balance,
            weights: Weights::default(),
            seed: 0,
        }
    }
}

impl Search {
    /// A search on one thread.
    ///
    /// # Errors
    /// [`WeightError`] where a weight is negative or not finite.
    pub fn new(grid: &Grid, settings: &SearchSettings) -> Result<Self, WeightError> {
        settings.weights.validate()?;
        let balanced = settings.order == Order::Balance;
        let needs_distance = settings.heuristic == Heuristic::Sdfm;
        Ok(Self {
            grid: grid.clone(),
            objective: Objective::new(grid, settings.heuristic, &settings.weights, balanced),
            seed: settings.seed,
            arch: Arch::new(),
            pool: None,
            resting: RestingMaps::new(grid),
            distance: needs_distance.then(|| DistanceLevels::new(grid)),
            scene_is_stale: true,
            views: Vec::new(),
            proposed: ProposedViews::new(grid),
            counts: Vec::new(),
            blocks: None,
            levels: BinaryHeap::new(),
            pending: Vec::new(),
            ready: BinaryHeap::new(),
        })
    }

    /// Spreads the work over the threads of a pool; the result is the same, bit for bit.
    #[must_use]
    pub fn with_pool(mut self, pool: Arc<rayon::ThreadPool>) -> Self {
        self.pool = Some(pool);
        self
    }

    /// Where all placements of a candidate are proposed, looks only where a bound does not rule out that the best is
    /// there. The ranking is the same, bit for bit, but [`PlacementCounts::fitting`] counts only what was looked at until
    /// the ranking is at its end. SDFM, DBL and HM have such bounds; with others this changes nothing.
    ///
    /// It pays on fine grids; it runs on one thread.
    #[must_use]
    pub fn bounded(mut self) -> Self {
        self.blocks = BlockSearch::new(&self.grid, self.objective.heuristic);
        self
    }

    /// Makes everything that depends on the container alone current.
    fn update_scene(&mut self, input: &StepInput<'_>) {
        if self.resting.update(input.scene.heightmap()) {
            self.scene_is_stale = true;
        }
        if !self.scene_is_stale {
            return;
        }
        if let Some(distance) = &mut self.distance {
            let heightmap = input.scene.heightmap();
            self.arch.dispatch(UpdateDistance {
                distance,
                heightmap,
            });
        }
        if let Some(blocks) = &mut self.blocks {
            blocks.update(self.resting.container(), self.distance.as_ref());
        }
        self.scene_is_stale = false;
    }

    /// Enters the views of a candidate that have a proposed placement below the rim.
    fn enter(
        &mut self,
        candidates: &[Candidate],
        candidate: usize,
        proposals: CandidateProposals<'_>,
    ) {
        let Some(held) = candidates.get(candidate) else {
            return;
        };
        let mut counts = PlacementCounts::default();
        let yaws = match proposals {
            CandidateProposals::AllAt(yaws) => yaws,
            _ => YawRange::all(&held.item),
        };
        let views = held.item.views();
        if views.iter().any(|view| view.height() <= self.grid.rim()) {
            counts.possible = possible_count_at(&self.grid, &held.item, yaws);
        }
        let first_proposed = match proposals {
            CandidateProposals::All | CandidateProposals::AllAt(_) => None,
            CandidateProposals::Some(placements) => {
                let container = self.resting.container();
                Some(self.proposed.add(container, &held.item, placements))
            }
        };
        let is_bounded = self.blocks.is_some() && first_proposed.is_none();
        if is_bounded {
            counts.proposed = possible_count_at(&self.grid, &held.item, yaws);
        }
        let searched = views.iter().enumerate().take(yaws.end).skip(yaws.first);
        for (yaw, view) in searched {
            let limit = self.grid.rim() - view.height().min(self.grid.rim() + 1);
            if is_bounded {
                self.views.push(ViewState {
                    candidate,
                    yaw,
                    terms: ViewTerms::new(&self.objective, view),
                    limit,
                    proposed: None,
                });
                counts.fitting += self.enter_blocks(candidates);
                continue;
            }
            let proposed = first_proposed.map(|first| first + yaw);
            let Some(found) = self
                .placements(held, yaw, proposed)
                .map(|placements| self.summary(placements, limit))
            else {
                continue;
            };
            counts.proposed += found.proposed;
            counts.fitting += found.fitting;
            let Some(height) = found.lowest else { continue };
            let terms = ViewTerms::new(&self.objective, view);
            let bound = self.objective.lower_bound(view, &terms, height);
            self.levels.push(Level {
                bound,
                view: self.views.len(),
                height,
            });
            self.views.push(ViewState {
                candidate,
                yaw,
                terms,
                limit,
                proposed,
            });
        }
        if let Some(entry) = self.counts.get_mut(candidate) {
            *entry = counts;
        }
    }

    /// Enters the last view with all its placements, as blocks; see [`BlockSearch::enter`].
    fn enter_blocks(&mut self, candidates: &[Candidate]) -> u64 {
        let ranking = Ranking {
            objective: &self.objective,
            container: self.resting.container(),
            views: &self.views,
            candidates,
        };
        match (&mut self.blocks, self.views.len().checked_sub(1)) {
            (Some(blocks), Some(last)) => blocks.enter(ranking, last),
            _ => 0,
        }
    }

    /// Cuts blocks until a placement comes up, or the blocks left are beyond what is known of others.
    fn expand_blocks(&mut self, input: &StepInput<'_>) {
        let best = self.ready.peek().map_or(f64::INFINITY, |best| best.0.value);
        let level = self
            .levels
            .peek()
            .map_or(f64::INFINITY, |level| level.bound);
        let ranking = Ranking {
            objective: &self.objective,
            container: self.resting.container(),
            views: &self.views,
            candidates: input.candidates,
        };
        if let Some(blocks) = &mut self.blocks {
            blocks.expand(
                ranking,
                best.min(level),
                &mut self.counts,
                &mut self.pending,
            );
        }
        self.evaluate_pending(input);
    }

    /// The least bound of what is not evaluated yet, and whether it is that of a block.
    fn open_bound(&self) -> Option<(f64, bool)> {
        let level = self.levels.peek().map(|level| (level.bound, false));
        let block = self.blocks.as_ref().and_then(BlockSearch::bound);
        let block = block.map(|bound| (bound, true));
        match (level, block) {
            (Some(level), Some(block)) => Some(if block.0 <= level.0 { block } else { level }),
            (level, block) => level.or(block),
        }
    }

    /// The placements of a view that take part.
    fn placements(
        &self,
        held: &Candidate,
        yaw: usize,
        proposed: Option<usize>,
    ) -> Option<Placements<'_>> {
        match proposed {
            Some(index) => self.proposed.get(index).map(Placements::Some),
            None => {
                let maps = self.resting.views(held.item.shape());
                maps.get(yaw).map(Placements::All)
            }
        }
    }

    fn summary(&self, placements: Placements<'_>, limit: Units) -> Summary {
        match placements {
            Placements::All(map) => self.arch.dispatch(Summarise { map, limit }),
            Placements::Some(proposed) => proposed.summary(limit),
        }
    }

    /// Expands levels until the least value found is below every bound left, or a batch is full.
    fn expand(&mut self, input: &StepInput<'_>) {
        let batch = if self.pool.is_some() {
            PARALLEL_BATCH
        } else {
            1
        };
        while let Some(level) = self.levels.peek().copied() {
            let is_settled = self
                .ready
                .peek()
                .is_some_and(|best| best.0.value < level.bound);
            if is_settled || self.pending.len() >= batch {
                break;
            }
            self.levels.pop();
            let Some(state) = self.views.get(level.view).copied() else {
                continue;
            };
            let Some(held) = input.candidates.get(state.candidate) else {
                continue;
            };
            let Some(view) = held.item.views().get(state.yaw) else {
                continue;
            };
            let mut pending = std::mem::take(&mut self.pending);
            let next = match self.placements(held, state.yaw, state.proposed) {
                Some(Placements::All(map)) => self.arch.dispatch(Collect {
                    map,
                    level,
                    limit: state.limit,
                    pending: &mut pending,
                }),
                Some(Placements::Some(proposed)) => {
                    proposed.collect(level, state.limit, &mut pending)
                }
                None => None,
            };
            self.pending = pending;
            if let Some(height) = next {
                let bound = self.objective.lower_bound(view, &state.terms, height);
                self.levels.push(Level {
                    bound,
                    height,
                    ..level
                });
            }
        }
        self.evaluate_pending(input);
    }

    fn evaluate_pending(&mut self, input: &StepInput<'_>) {
        let mut pending = std::mem::take(&mut self.pending);
        let evaluation = Evaluation {
            search: self,
            input,
        };
        match &self.pool {
            Some(pool) if pending.len() > PARALLEL_BATCH / 4 => pool.install(|| {
                let share = pending
                    .len()
                    .div_ceil(2 * pool.current_num_threads())
                    .max(1);
                pending
                    .par_chunks_mut(share)
                    .for_each(|chunk| self.arch.dispatch(EvaluateAll { evaluation, chunk }));
            }),
            _ => self.arch.dispatch(EvaluateAll {
                evaluation,
                chunk: &mut pending,
            }),
        }
        let views = &self.views;
        self.ready.extend(pending.drain(..).filter_map(|found| {
            let state = views.get(found.view)?;
            let placement = Placement {
                yaw: state.yaw,
                x: found.x,
                y: found.y,
            };
            let resting = RestingPlacement {
                placement,
                resting_height: found.height,
            };
            Some(Ready(Evaluated {
                candidate: state.candidate,
                resting,
                value: found.value,
            }))
        }));
        self.pending = pending;
    }
}

impl Evaluator for Search {
    fn rank(
        &mut self,
        input: &StepInput<'_>,
        group: &[usize],
        proposals: &Proposals,
    ) -> Result<(), StageError> {
        self.update_scene(input);
        self.views.clear();
        self.levels.clear();
        self.ready.clear();
        self.proposed.clear();
        if let Some(blocks) = &mut self.blocks {
            blocks.clear();
        }
        self.counts.clear();
        self.counts
            .resize(input.candidates.len(), PlacementCounts::default());
        let held = |candidate: &usize| input.candidates.get(*candidate);
        self.resting
            .keep(input.candidates.iter().map(|held| &*held.item));
        for candidate in group {
            let Some(held) = held(candidate) else {
                continue;
            };
            let proposals = proposals.of(*candidate);
            let whole = match proposals {
                CandidateProposals::All => Some(YawRange::all(&held.item)),
                CandidateProposals::AllAt(yaws) => Some(yaws),
                CandidateProposals::Some(_) => None,
            };
            if let Some(yaws) = whole
                && self.blocks.is_none()
            {
                self.resting.prepare(&held.item, yaws, self.pool.as_deref());
            }
            self.enter(input.candidates, *candidate, proposals);
        }
        Ok(())
    }

    fn next_best(&mut self, input: &StepInput<'_>) -> Result<Option<Evaluated>, StageError> {
        loop {
            let best = self.ready.peek().map(|best| best.0.value);
            match (best, self.open_bound()) {
                (None, None) => return Ok(None),
                (Some(_), None) => break,
                (Some(best), Some((bound, _))) if best < bound => break,
                (_, Some((_, true))) => self.expand_blocks(input),
                (_, Some((_, false))) => self.expand(input),
            }
        }
        Ok(self.ready.pop().map(|best| best.0))
    }

    fn counts(&self, candidate: usize) -> PlacementCounts {
        self.counts.get(candidate).copied().unwrap_or_default()
    }
}
