//! Algorithm 1 for one cell, over the services that are alive.

use std::sync::Arc;
use std::time::Duration;

use ppnpack_packing::checks::rules;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::planning::method::OpenNetwork;
use ppnpack_packing::planning::plan::{Plan, PlanError, Planner};
use ppnpack_packing::ranking::evaluator::Evaluator;
use ppnpack_packing::ranking::proposals::{Percent, Proposer};
use ppnpack_packing::ranking::search::Search;
use ppnpack_packing::ranking::step::{StageError, StepInput};
use ppnpack_physics::trial;
use ppnpack_service::alive::Alive;
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::Cell;

use crate::remote::{Peers, RemoteProposer, ServiceEvaluator};
use crate::settings::{CellSettings, Where};

/// The services that take part in planning.
#[derive(Clone)]
pub(crate) struct Helpers {
    pub(crate) client: Client,
    pub(crate) ppn: Arc<Alive>,
    pub(crate) heuristic: Arc<Alive>,
    /// The threads that try placements, for all cells together.
    pub(crate) threads: Option<Arc<rayon::ThreadPool>>,
}

/// Plans the steps of one cell.
pub(crate) struct Planning {
    grid: Grid,
    planner: Planner,
}

impl Planning {
    /// Makes the planning of a cell by its settings.
    ///
    /// # Errors
    /// What is not possible in the settings.
    pub(crate) fn new(
        cell: &Cell,
        settings: &CellSettings,
        helpers: &Helpers,
    ) -> Result<Self, String> {
        let peers = |alive: &Arc<Alive>, limit_s: f64| Peers {
            cell: cell.clone(),
            client: helpers.client.clone(),
            alive: Arc::clone(alive),
            limit: Duration::from_secs_f64(limit_s),
        };
        let network = PpnServices(peers(&helpers.ppn, settings.propose_limit_s));
        let parts = Parts {
            settings,
            threads: helpers.threads.clone(),
            network: Some(&network),
        };
        match settings.evaluate {
            Where::Services => {
                let peers = peers(&helpers.heuristic, settings.evaluate_limit_s);
                let own = parts.search()?;
                let evaluator = ServiceEvaluator::new(peers, &settings.method, own);
                parts.build(Box::new(evaluator))
            }
            Where::InProcess => parts.build(Box::new(parts.search()?)),
        }
    }

    /// Makes the planning of a cell in this process alone, to the same decisions.
    ///
    /// # Errors
    /// What is not possible in the settings, or cannot be done without other services.
    pub(crate) fn alone(
        settings: &CellSettings,
        threads: Option<Arc<rayon::ThreadPool>>,
    ) -> Result<Self, String> {
        let parts = Parts {
            settings,
            threads,
            network: None,
        };
        parts.build(Box::new(parts.search()?))
    }

    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Plans a step.
    ///
    /// # Errors
    /// [`PlanError`] where the input does not match the grid or a stage failed.
    pub(crate) fn plan(&mut self, input: &StepInput<'_>) -> Result<&Plan, PlanError> {
        self.planner.plan(&StepInput {
            grid: &self.grid,
            ..*input
        })
    }
}

/// The parts that planning is made of.
struct Parts<'a> {
    settings: &'a CellSettings,
    threads: Option<Arc<rayon::ThreadPool>>,
    network: Option<&'a dyn OpenNetwork>,
}

impl Parts<'_> {
    fn grid(&self) -> Result<Grid, String> {
        self.settings
            .grid
            .build()
            .map_err(|error| error.to_string())
    }

    /// Makes a search in this process.
    fn search(&self) -> Result<Search, String> {
        let settings = self.settings.method.search_settings();
        let search = Search::new(&self.grid()?, &settings).map_err(|error| error.to_string())?;
        Ok(search.bounded().within_bytes(self.settings.search_bytes()))
    }

    fn build(&self, evaluator: Box<dyn Evaluator>) -> Result<Planning, String> {
        let Self { settings, .. } = *self;
        let (grid, method) = (self.grid()?, &settings.method);
        let proposer = method.proposer_or_exhaustive(&grid, self.network);
        let proposer = proposer.map_err(|error| error.to_string())?;
        let mut checks = rules::checks();
        checks.extend(method.loads.checks());
        if let Some(station) = settings.station().map_err(|error| error.to_string())? {
            // The planner asks the arm itself, last, going through the placements by increasing
            // value: it is asked for a handful of placements, and a heuristic service would need
            // the arm, what is around it and the items' meshes.
            checks.push(Box::new(station.check()));
        }
        let mut twin = settings.twin.clone();
        twin.cell.container = grid.container();
        let trial = trial::check(method.trial, &method.loads, twin, self.threads.clone());
        checks.extend(trial.map_err(|error| error.to_string())?);
        checks.extend(method.stability.checks());
        let evaluator = method.farsighted(evaluator);
        let planner = Planner::new(proposer, evaluator, checks, method.order, method.seed);
        Ok(Planning { grid, planner })
    }
}

/// The ppn services, any of which has the network.
struct PpnServices(Peers);

impl OpenNetwork for PpnServices {
    fn open(
        &self,
        _grid: &Grid,
        share: Percent,
        _items: &[Arc<Item>],
    ) -> Result<Box<dyn Proposer>, StageError> {
        Ok(Box::new(RemoteProposer::new(self.0.clone(), share)))
    }
}
