//! A worker: an actor that answers requests.

use std::collections::VecDeque;
use std::sync::Arc;

use ppnpack_packing::grid::Grid;
use ppnpack_packing::item::{Item, YawsMismatch};
use ppnpack_packing::search::{Search, SearchSettings, TooMuchMemory};
use ppnpack_packing::valid::{SearchError, ValidSearch};
use ppnpack_service::ServiceError;
use ppnpack_service::actor::Actor;
use ppnpack_service::alive::Alive;
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::convert;
use ppnpack_wire::error::WireError;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::item_store::{ItemStore, MissingItems};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Status};

use crate::evaluate;
use crate::settings::Settings;

/// A request as it waits.
pub(crate) type Evaluate = Incoming<v1::EvaluateRequest>;

/// Why a request is not answered as it was asked.
pub(crate) enum Refusal {
    Invalid(String),
    Missing(MissingItems),
    /// The time limit passed during the work.
    Late,
    Failed(String),
}

impl From<YawsMismatch> for Refusal {
    fn from(error: YawsMismatch) -> Self {
        Self::Invalid(error.to_string())
    }
}

impl From<SearchError> for Refusal {
    fn from(error: SearchError) -> Self {
        match error {
            SearchError::Evaluate(error) if error.is::<TooMuchMemory>() => too_much(&*error),
            error => Self::Failed(error.to_string()),
        }
    }
}

/// Refuses what would need as much if it was asked for again.
fn too_much(error: &dyn std::error::Error) -> Refusal {
    Refusal::Invalid(format!("{error}; or set searches_mib"))
}

impl From<WireError> for Refusal {
    fn from(error: WireError) -> Self {
        Self::Invalid(error.to_string())
    }
}

/// A reply, and how long the stages of the work on it took.
pub(crate) type Answer = (v1::EvaluateReply, Vec<v1::StageTiming>);

/// Answers requests one after another.
pub(crate) struct Worker {
    items: ItemStore,
    planners: Alive,
    pool: Option<Arc<rayon::ThreadPool>>,
    /// The last used first.
    searches: VecDeque<KeptSearch>,
    searches_kept: usize,
    /// The most that searches may hold together.
    searches_bytes: usize,
    most_placements: usize,
}

struct KeptSearch {
    cell: Cell,
    grid: Grid,
    settings: SearchSettings,
    checks: Vec<i32>,
    search: ValidSearch,
}

impl Actor for Worker {
    type Message = Evaluate;

    fn handle(&mut self, incoming: Evaluate) {
        let Some(incoming) = incoming.still_wanted(&self.planners) else {
            return;
        };
        match evaluate::evaluate(self, &incoming) {
            Ok((reply, stages)) => {
                let model = None;
                incoming.reply(reply, Done { stages, model });
            }
            Err(Refusal::Invalid(message)) => incoming.refuse(Status::Invalid, message),
            Err(Refusal::Late) => {
                let message =
                    "the time limit passed during the work: give it more time, or ask for less";
                incoming.refuse(Status::TimedOut, message);
            }
            Err(Refusal::Failed(message)) => incoming.refuse(Status::Failed, message),
            Err(Refusal::Missing(missing)) => {
                let message = missing.to_string();
                let missing_items = missing.0.into_iter().map(ItemId::to_bytes).collect();
                let reply = v1::EvaluateReply {
                    missing_items,
                    ..v1::EvaluateReply::default()
                };
                incoming.refuse_with(reply, Status::MissingItems, message);
            }
        }
    }
}

impl Worker {
    pub(crate) fn new(planners: Alive, settings: &Settings) -> Result<Self, ServiceError> {
        let pool = match settings.threads_per_search {
            0 | 1 => None,
            threads => Some(Arc::new(
                rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .map_err(|error| {
                        ServiceError::start(format_args!(
                            "the threads of the search cannot be started: {error}"
                        ))
                    })?,
            )),
        };
        Ok(Self {
            items: ItemStore::new(settings.items_kept_mib << 20),
            planners,
            pool,
            searches: VecDeque::new(),
            searches_kept: settings.searches_kept.max(1),
            searches_bytes: settings.searches_mib << 20,
            most_placements: settings.most_placements,
        })
    }

    /// The most work of one request: cells times yaws.
    pub(crate) fn most_placements(&self) -> usize {
        self.most_placements
    }

    /// The items that a request names.
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

    /// The search that this cell used last with these settings, or a new one.
    pub(crate) fn search(
        &mut self,
        cell: &Cell,
        grid: &Grid,
        settings: &SearchSettings,
        checks: &[i32],
    ) -> Result<&mut ValidSearch, Refusal> {
        let is_same = |kept: &KeptSearch| {
            kept.cell == *cell
                && kept.grid == *grid
                && kept.settings == *settings
                && kept.checks == checks
        };
        let kept = self.searches.iter().position(is_same);
        let kept = kept.and_then(|index| self.searches.remove(index));
        self.searches.truncate(self.searches_kept - 1);
        self.make_room();
        let kept = match kept {
            Some(kept) => kept,
            None => self.new_search(cell, grid, settings, checks)?,
        };
        self.searches.push_front(kept);
        match self.searches.front_mut() {
            Some(kept) => Ok(&mut kept.search),
            None => Err(Refusal::Failed("the search was lost".to_owned())),
        }
    }

    /// The most that one search may take: half of the memory, as the other half is for those that are kept.
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

    fn new_search(
        &self,
        cell: &Cell,
        grid: &Grid,
        settings: &SearchSettings,
        checks: &[i32],
    ) -> Result<KeptSearch, Refusal> {
        let boxed = convert::check::read_all(checks)?;
        let limit_bytes = self.bytes_of_one();
        if Search::least_bytes(grid, settings.heuristic) > limit_bytes {
            return Err(too_much(&TooMuchMemory { limit_bytes }));
        }
        let mut search = Search::new(grid, settings)
            .map_err(|error| Refusal::Invalid(error.to_string()))?
            .bounded()
            .within_bytes(limit_bytes);
        if let Some(pool) = &self.pool {
            search = search.with_pool(Arc::clone(pool));
        }
        Ok(KeptSearch {
            cell: cell.clone(),
            grid: grid.clone(),
            settings: settings.clone(),
            checks: checks.to_vec(),
            search: ValidSearch::new(Box::new(search), boxed),
        })
    }
}
