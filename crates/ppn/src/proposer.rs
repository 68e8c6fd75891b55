//! Proposing placements with a network.

use std::sync::Arc;

use ppnpack_model::settings::Device;
use ppnpack_model::weights::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::kernel::placement::Placement;
use ppnpack_packing::ranking::proposals::{Percent, Proposals, Proposer};
use ppnpack_packing::ranking::step::{StageError, StepInput};

use crate::error::NetworkError;
use crate::inference::Inference;

/// Proposes the placements that a network scores best: `K` % of all placements `|P|` of a
/// candidate, its yaws times the container's cells, among those that stay below the rim.
///
/// It owns the model and runs it on the thread that asks, which on the processor is the only one:
/// handing a step over to another thread was measured to cost 0.2 ms and more. Proposals are sorted
/// by increasing score.
#[derive(Debug)]
pub struct NetworkProposer {
    inference: Inference,
    share: Percent,
}

impl NetworkProposer {
    /// Loads a model for a grid and warms it up. Features of `items` are computed at once; others
    /// when first seen.
    ///
    /// # Errors
    /// [`NetworkError`] where the weights do not fit their architecture or the device is not there.
    pub fn new(
        model: &Model,
        grid: &Grid,
        share: Percent,
        device: Device,
        items: &[Arc<Item>],
    ) -> Result<Self, NetworkError> {
        let mut inference = Inference::new(model, grid, device)?.warmed_up()?;
        inference.prepare(items)?;
        Ok(Self { inference, share })
    }

    /// Gives the best-scored placements of some items, best first: `share` of all placements of
    /// each.
    ///
    /// # Errors
    /// [`NetworkError`] where the network fails or its scores are not finite.
    pub fn best(
        &mut self,
        heightmap: &Heightmap,
        items: &[&Item],
        share: Percent,
    ) -> Result<Vec<Vec<Placement>>, NetworkError> {
        self.inference.best(heightmap, items, share)
    }
}

impl Proposer for NetworkProposer {
    fn propose(
        &mut self,
        input: &StepInput<'_>,
        proposals: &mut Proposals,
    ) -> Result<(), StageError> {
        proposals.clear();
        let items = input.candidates.iter().map(|candidate| &*candidate.item);
        let items: Vec<&Item> = items.collect();
        let heightmap = input.scene.heightmap();
        for placements in self.inference.best(heightmap, &items, self.share)? {
            proposals.push(placements);
        }
        Ok(())
    }
}
