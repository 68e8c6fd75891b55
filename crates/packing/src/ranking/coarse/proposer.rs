//! A proposer of the coarse grid that proposes for the fine one.

use std::collections::HashMap;
use std::sync::Arc;

use super::CoarseGrid;
use crate::kernel::item::{Item, ItemError, ShapeId};
use crate::kernel::objective::{Order, SettingError};
use crate::kernel::placement::Placement;
use crate::ranking::evaluator::Evaluator;
use crate::ranking::proposals::{Percent, Proposals, Proposer, all_count, possible_count};
use crate::ranking::search::{Search, SearchSettings};
use crate::ranking::step::{Candidate, StageResult, StepInput};
use crate::scene::Scene;

/// Maximum number of items whose coarse views are kept.
const KEPT_ITEMS: usize = 512;

/// Factor of a candidate's proposals over the mean share: one may get what others do not.
const WIDER: f64 = 4.0;

/// Proposes, for the fine grid, the regions of those placements of a coarse proposer that the
/// heuristic ranks best on the coarse grid.
///
/// The heuristic costs little there, and spares the fine grid what other candidates beat. Under
/// [`Order::Balance`], where values of items compare, the candidates have one share together, else
/// each its own. An item that does not fit the coarse container has few placements; all are
/// proposed.
pub struct CoarseToFine {
    grids: CoarseGrid,
    wide: Box<dyn Proposer>,
    search: Search,
    share: Percent,
    is_shared: bool,
    items: HashMap<ShapeId, Arc<Item>>,
    proposals: Proposals,
    /// The best coarse placements of each candidate.
    best: Vec<Vec<Placement>>,
}

impl CoarseToFine {
    /// Keeps `share` of all coarse placements, out of what `wide` proposes for each candidate on
    /// the coarse grid. `wide` had best propose [`Self::wider`] shares.
    pub fn new(
        grids: CoarseGrid,
        settings: &SearchSettings,
        share: Percent,
        wide: Box<dyn Proposer>,
    ) -> Result<Self, SettingError> {
        Ok(Self {
            search: Search::new(grids.coarse(), settings)?,
            grids,
            wide,
            share,
            is_shared: settings.order == Order::Balance,
            items: HashMap::new(),
            proposals: Proposals::default(),
            best: Vec::new(),
        })
    }

    /// The share that is proposed for each candidate where `share` is kept of all together.
    pub fn wider(share: Percent) -> Percent {
        share.times(WIDER)
    }

    /// Takes over the coarse views of items that are known ahead of time.
    #[must_use]
    pub fn with_items(mut self, items: impl Iterator<Item = (ShapeId, Arc<Item>)>) -> Self {
        self.items.extend(items.take(KEPT_ITEMS));
        self
    }

    fn coarse(&mut self, item: &Item) -> Result<Arc<Item>, ItemError> {
        if let Some(kept) = self.items.get(&item.shape()) {
            return Ok(Arc::clone(kept));
        }
        let coarse = Arc::new(self.grids.item(item)?);
        if self.items.len() >= KEPT_ITEMS {
            self.items.clear();
        }
        self.items.insert(item.shape(), Arc::clone(&coarse));
        Ok(coarse)
    }
}

impl Proposer for CoarseToFine {
    fn propose(&mut self, input: &StepInput<'_>, proposals: &mut Proposals) -> StageResult {
        let candidates = input.candidates.iter().map(|candidate| {
            Ok(Candidate {
                item: self.coarse(&candidate.item)?,
                ..candidate.clone()
            })
        });
        let candidates = candidates.collect::<Result<Vec<_>, ItemError>>()?;
        let scene = Scene::from_heightmap(self.grids.pool(input.scene.heightmap()));
        let coarse = StepInput {
            grid: self.grids.coarse(),
            scene: &scene,
            candidates: &candidates,
            ..*input
        };
        self.wide.propose(&coarse, &mut self.proposals)?;
        self.best.resize_with(candidates.len(), Vec::new);
        self.best.iter_mut().for_each(Vec::clear);
        let wanted = |index: &usize| {
            let held = candidates.get(*index);
            held.map_or(0, |held| self.share.of(all_count(coarse.grid, &held.item)))
        };
        let all: Vec<usize> = (0..candidates.len()).collect();
        let together = if self.is_shared { all.len() } else { 1 };
        for group in all.chunks(together.max(1)) {
            self.search.rank(&coarse, group, &self.proposals)?;
            for _ in 0..group.iter().map(wanted).sum() {
                let Some(next) = self.search.next_best(&coarse)? else {
                    break;
                };
                if let Some(best) = self.best.get_mut(next.candidate) {
                    best.push(next.resting.placement);
                }
            }
        }
        proposals.clear();
        if let Some(reason) = self.proposals.degraded() {
            proposals.degrade(reason);
        }
        for ((fine, coarse), best) in input.candidates.iter().zip(&candidates).zip(&self.best) {
            if possible_count(self.grids.coarse(), &coarse.item) > 0 {
                let (fine, coarse) = (fine.item.views(), coarse.item.views());
                let regions = best.iter();
                proposals.push(regions.flat_map(|at| self.grids.region(fine, coarse, *at)));
            } else {
                proposals.push_all();
            }
        }
        Ok(())
    }
}
