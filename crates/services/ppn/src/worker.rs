//! The worker that owns the network.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::ranking::proposals::Percent;
use ppnpack_packing::ranking::step::StageError;
use ppnpack_packing::scene::Scene;
use ppnpack_service::one_worker::{self, Refusal};
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::item_store::ItemStore;
use ppnpack_wire::{convert, header, v1};

use crate::settings::Settings;
use crate::{Network, ScoredStep, Scorer};

const MAX_CANDIDATES: usize = 1_000;

/// Runs the network for requests.
pub(crate) struct Worker {
    network: Box<dyn Network>,
    model: String,
    scorers: VecDeque<(Grid, Box<dyn Scorer>)>,
    items: ItemStore,
    grids_kept: usize,
    most_cells: usize,
    most_placements: usize,
}

/// A request as it was read: container, candidates, and how many placements are wanted.
type Step = (Grid, Scene, Vec<Arc<Item>>, Percent);

impl one_worker::Worker for Worker {
    type Request = v1::ProposeRequest;

    fn work(
        &mut self,
        incoming: &Incoming<v1::ProposeRequest>,
    ) -> Result<(v1::ProposeReply, Done), Refusal> {
        let began = Instant::now();
        let (grid, scene, items, share) = self.read(incoming.message())?;
        let read = began.elapsed();
        let items: Vec<&Item> = items.iter().map(|item| &**item).collect();
        let scored = ScoredStep {
            heightmap: scene.heightmap(),
            items: &items,
            share,
        };
        let scorer = self.scorer(&grid);
        let best = scorer.and_then(|scorer| scorer.best(&scored));
        let best = best.map_err(|error| Refusal::Failed(error.to_string()))?;
        let proposals = best
            .into_iter()
            .map(|of_item| convert::placement::write_all(of_item.into_iter()));
        let reply = v1::ProposeReply {
            proposals: proposals.collect(),
            ..v1::ProposeReply::default()
        };
        let stages = vec![
            header::stage("read", read),
            header::stage("network", began.elapsed().saturating_sub(read)),
        ];
        let model = Some(self.model.clone());
        Ok((reply, Done { stages, model }))
    }
}

impl Worker {
    pub(crate) fn new(network: Box<dyn Network>, settings: &Settings) -> Self {
        Self {
            model: network.model().to_owned(),
            network,
            scorers: VecDeque::new(),
            items: ItemStore::new(settings.items_kept_mib << 20),
            grids_kept: settings.grids_kept.max(1),
            most_cells: settings.most_cells,
            most_placements: settings.most_placements,
        }
    }

    /// Runs the network once, so that the first request does not wait for it.
    pub(crate) fn warm_up(&mut self) -> Result<(), StageError> {
        self.scorer(&Grid::reference()).map(|_| ())
    }

    fn read(&mut self, request: &v1::ProposeRequest) -> Result<Step, Refusal> {
        if !(1..=MAX_CANDIDATES).contains(&request.item_ids.len()) {
            return Err(Refusal::Invalid(format!(
                "item_ids: {} where 1 to {MAX_CANDIDATES} are possible",
                request.item_ids.len()
            )));
        }
        let share = Percent::new(request.percent)?;
        let (grid, scene) = convert::scene::read_required("scene", request.scene.as_ref())?;
        self.check_work(&grid, request.item_ids.len())?;
        let ids = request.item_ids.iter();
        let ids = ids.map(|id| ItemId::from_bytes("item_ids", id));
        let ids = ids.collect::<Result<Vec<_>, _>>()?;
        let items = self.items.resolve(&request.items, &ids)?;
        let items = items.map_err(Refusal::Missing)?;
        for item in &items {
            item.check_yaws(&grid)?;
        }
        Ok((grid, scene, items, share))
    }

    /// Refuses what is more work, or takes more memory, than may be asked for at once.
    fn check_work(&self, grid: &Grid, candidates: usize) -> Result<(), Refusal> {
        let cells = grid.nx() * grid.ny();
        if cells > self.most_cells {
            let most = self.most_cells;
            return Err(Refusal::Invalid(format!(
                "scene.grid: {cells} cells where {most} are possible: propose on a coarser grid, or set most_cells"
            )));
        }
        let yaws = grid.resolution().yaws().count();
        let work = cells.saturating_mul(yaws).saturating_mul(candidates);
        if work > self.most_placements {
            let most = self.most_placements;
            return Err(Refusal::Invalid(format!(
                "item_ids: {cells} cells, {yaws} yaws and {candidates} candidates are {work} placements where {most} are \
                 possible: ask for fewer candidates, propose on a coarser grid, or set most_placements"
            )));
        }
        Ok(())
    }

    /// Gives the network for a grid; those longest unused go first.
    fn scorer(&mut self, grid: &Grid) -> Result<&mut dyn Scorer, StageError> {
        let kept = self.scorers.iter().position(|(of, _)| of == grid);
        let entry = match kept.and_then(|index| self.scorers.remove(index)) {
            Some(entry) => entry,
            None => (grid.clone(), self.network.open(grid)?),
        };
        self.scorers.truncate(self.grids_kept - 1);
        self.scorers.push_front(entry);
        match self.scorers.front_mut() {
            Some((_, scorer)) => Ok(scorer.as_mut()),
            None => Err("the network was lost".into()),
        }
    }
}
