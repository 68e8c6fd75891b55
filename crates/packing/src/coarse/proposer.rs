//! A proposer of the coarse grid that proposes for the fine one.

use std::collections::HashMap;
use std::sync::Arc;

use super::CoarseGrid;
use crate::heightmap::Scene;
use crate::item::{Item, ItemError, ShapeId};
use crate::objective::WeightError;
use crate::proposals::{CandidateProposals, Percent, Proposals, Proposer, possible_count};
use crate::search::{ProposeBest, SearchSettings};
use crate::step::{Candidate, StageResult, StepInput};

/// Maximum number of items whose coarse views are kept.
const KEPT_ITEMS: usize = 512;

/// How many times more a candidate may be proposed than is kept on average, so that one may get what others do not.
const WIDER: f64 = 4.0;

/// Proposes, for the fine grid, the regions of what another proposer proposes on the coarse one.
///
/// An item whose footprint does not fit the coarse container at any yaw has few placements; all are proposed.
pub struct CoarseToFine {
    grids: CoarseGrid,
    proposer: Box<dyn Proposer>,
    /// Coarse views of items, by the shape of the fine ones.
    items: HashMap<ShapeId, Arc<Item>>,
    proposals: Proposals,
}

impl CoarseToFine {
    /// `proposer` is one for the coarse grid.
    pub fn new(grids: CoarseGrid, proposer: Box<dyn Proposer>) -> Self {
        Self {
            grids,
            proposer,
            items: HashMap::new(),
            proposals: Proposals::default(),
        }
    }

    /// Among what `wide` proposes for each candidate on the coarse grid, `share` of the coarse placements of all
    /// candidates together, those that the heuristic ranks best. `wide` had best propose [`Self::wider`] shares.
    ///
    /// The heuristic costs little on the coarse grid, and spares evaluating on the fine one what other candidates beat.
    ///
    /// # Errors
    /// [`WeightError`] where a weight is negative or not finite.
    pub fn narrowing(
        grids: CoarseGrid,
        settings: &SearchSettings,
        share: Percent,
        wide: Box<dyn Proposer>,
    ) -> Result<Self, WeightError> {
        let best = ProposeBest::new(grids.coarse(), settings, share, wide)?;
        Ok(Self::new(grids, Box::new(best)))
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

    /// The coarse views of an item, always the same as long as they are kept.
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
        self.proposer.propose(&coarse, &mut self.proposals)?;
        proposals.clear();
        if let Some(reason) = self.proposals.degraded() {
            proposals.degrade(reason);
        }
        for (index, (fine, coarse)) in input.candidates.iter().zip(&candidates).enumerate() {
            match self.proposals.of(index) {
                CandidateProposals::Some(placements)
                    if possible_count(self.grids.coarse(), &coarse.item) > 0 =>
                {
                    let (fine, coarse) = (fine.item.views(), coarse.item.views());
                    let regions = placements.iter();
                    proposals.push(regions.flat_map(|at| self.grids.region(fine, coarse, *at)));
                }
                _ => proposals.push_all(),
            }
        }
        Ok(())
    }
}
