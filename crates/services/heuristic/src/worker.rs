//! The worker that answers requests.

use std::collections::VecDeque;
use std::sync::Arc;

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::planning::valid::{SearchError, ValidSearch};
use ppnpack_packing::ranking::search::{Search, SearchSettings, TooMuchMemory};
use ppnpack_service::one_worker::Refusal;
use ppnpack_wire::convert;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::item_store::ItemStore;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::settings::Settings;

/// Says why a search led to nothing.
pub(crate) fn search_failed(error: SearchError) -> Refusal {
    match error {
        SearchError::Evaluate(error) if error.is::<TooMuchMemory>() => too_much(&*error),
        error => Refusal::Failed(error.to_string()),
    }
}

/// Refuses what would need as much if it was asked for again.
fn too_much(error: &dyn std::error::Error) -> Refusal {
    Refusal::Invalid(format!("{error}; or set searches_mib"))
}

pub(crate) struct Worker {
    items: ItemStore,
    /// The last used first.
    searches: VecDeque<KeptSearch>,
    searches_kept: usize,
    /// Maximum bytes of all searches together.
    searches_bytes: usize,
    most_placements: usize,
}

struct KeptSearch {
    of: SearchKey,
    search: ValidSearch,
}

/// The cell, grid, settings and checks that a search is for.
type SearchKey = (Cell, Grid, SearchSettings, Vec<i32>);

impl Worker {
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            items: ItemStore::new(settings.items_kept_mib << 20),
            searches: VecDeque::new(),
            searches_kept: settings.searches_kept.max(1),
            searches_bytes: settings.searches_mib << 20,
            most_placements: settings.most_placements,
        }
    }

    /// Gives the most work of one request: cells times yaws.
    pub(crate) fn most_placements(&self) -> usize {
        self.most_placements
    }

    pub(crate) fn items(
        &mut self,
        given: &[v1::Item],
        ids: &[ItemId],
        grid: &Grid,
    ) -> Result<Vec<Arc<Item>>, Refusal> {
        let items = self.items.resolve(given, ids)?;
        let items = items.map_err(Refusal::Missing)?;
        for item in &items {
            item.check_yaws(grid)?;
        }
        Ok(items)
    }

    /// Gives the search that this cell used last with these settings, or a new one.
    pub(crate) fn search(
        &mut self,
        cell: &Cell,
        grid: &Grid,
        settings: &SearchSettings,
        checks: &[i32],
    ) -> Result<&mut ValidSearch, Refusal> {
        let of = (
            cell.clone(),
            grid.clone(),
            settings.clone(),
            checks.to_vec(),
        );
        let kept = self.searches.iter().position(|kept| kept.of == of);
        let kept = kept.and_then(|index| self.searches.remove(index));
        self.searches.truncate(self.searches_kept - 1);
        self.make_room();
        let kept = match kept {
            Some(kept) => kept,
            None => self.new_search(of)?,
        };
        self.searches.push_front(kept);
        match self.searches.front_mut() {
            Some(kept) => Ok(&mut kept.search),
            None => Err(Refusal::Failed("the search was lost".to_owned())),
        }
    }

    /// Gives the most that one search may take: half of the memory, as the rest is for those kept.
    fn bytes_of_one(&self) -> usize {
        self.searches_bytes / 2
    }

    /// Lets kept searches go, those longest unused first, until one more has room.
    fn make_room(&mut self) {
        let room = self.searches_bytes - self.bytes_of_one();
        let mut held = 0;
        let mut fits = |kept: &KeptSearch| {
            held += kept.search.held_bytes();
            held <= room
        };
        let left = self.searches.iter().take_while(|kept| fits(kept)).count();
        self.searches.truncate(left);
    }

    fn new_search(&self, of: SearchKey) -> Result<KeptSearch, Refusal> {
        let (_, grid, settings, checks) = &of;
        let checks = convert::check::read_all(checks)?;
        let limit_bytes = self.bytes_of_one();
        if Search::least_bytes(grid, settings.heuristic) > limit_bytes {
            return Err(too_much(&TooMuchMemory { limit_bytes }));
        }
        let search = Search::new(grid, settings)?
            .bounded()
            .within_bytes(limit_bytes);
        let search = ValidSearch::new(Box::new(search), checks);
        Ok(KeptSearch { of, search })
    }
}
