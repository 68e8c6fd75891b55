//! Algorithm 1 for one cell, over the services that are alive.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_packing::coarse::{CoarseGrid, CoarseToFine};
use ppnpack_packing::evaluator::Evaluator;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::plan::{Plan, PlanError, Planner};
use ppnpack_packing::proposals::{OrExhaustive, Percent, ProposeAll, ProposeRandom, Proposer};
use ppnpack_packing::rules;
use ppnpack_packing::search::Search;
use ppnpack_packing::step::{Candidate, StepInput};
use ppnpack_service::alive::Alive;
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::Cell;

use crate::remote::{Judgement, RemoteProposer, SharedEvaluator};
use crate::settings::{CellSettings, ProposalSettings, Where};

/// The services that take part in planning.
#[derive(Clone)]
pub(crate) struct Helpers {
    pub(crate) client: Client,
    pub(crate) ppn: Arc<Alive>,
    pub(crate) heuristic: Arc<Alive>,
}

/// Plans the steps of one cell.
pub(crate) struct Planning {
    grid: Grid,
    planner: Planner,
}

impl Planning {
    /// Planning by a cell's settings.
    ///
    /// # Errors
    /// What is not possible in the settings.
    pub(crate) fn new(
        cell: &Cell,
        settings: &CellSettings,
        helpers: &Helpers,
    ) -> Result<Self, String> {
        let grid = settings.grid.build().map_err(|error| error.to_string())?;
        let remote = Remote {
            cell,
            settings,
            helpers,
        };
        let proposer = remote.proposer(&grid)?;
        let mut checks = rules::checks();
        if let Some(station) = settings.station().map_err(|error| error.to_string())? {
            // The planner asks the arm itself, last, going through the placements by increasing value: it is asked for
            // a handful of placements, and a heuristic service would need the arm, what is around it and the items'
            // meshes.
            checks.push(Box::new(station.check()));
        }
        let evaluator: Box<dyn Evaluator> = match settings.evaluate {
            Where::Fastest => Box::new(remote.evaluator(&grid)?.sooner_way()),
            Where::Services => Box::new(remote.evaluator(&grid)?),
            Where::InProcess => {
                checks.extend(settings.stability.checks());
                let search = Search::new(&grid, &settings.search());
                Box::new(search.map_err(|error| error.to_string())?.bounded())
            }
        };
        let planner = Planner::new(proposer, evaluator, checks, settings.order, settings.seed);
        Ok(Self { grid, planner })
    }

    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Plans a step.
    ///
    /// # Errors
    /// [`PlanError`] where the input does not match the grid or a stage failed.
    pub(crate) fn plan(&mut self, step: &Step<'_>) -> Result<&Plan, PlanError> {
        self.planner.plan(&StepInput {
            step: step.number,
            alternatives: step.alternatives,
            deadline: Some(step.deadline),
            ..StepInput::new(&self.grid, step.scene, step.candidates)
        })
    }
}

/// A step of a cell, to be planned on its grid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) candidates: &'a [Candidate],
    pub(crate) number: u64,
    pub(crate) alternatives: usize,
    pub(crate) deadline: Instant,
}

/// Makes the stages of one cell.
struct Remote<'a> {
    cell: &'a Cell,
    settings: &'a CellSettings,
    helpers: &'a Helpers,
}

impl Remote<'_> {
    fn proposer(&self, grid: &Grid) -> Result<Box<dyn Proposer>, String> {
        let share = |percent: f64| Percent::new(percent).map_err(|error| error.to_string());
        Ok(match &self.settings.proposals {
            ProposalSettings::All => Box::new(ProposeAll),
            ProposalSettings::Random { percent } => {
                Box::new(ProposeRandom::new(share(*percent)?, self.settings.seed))
            }
            ProposalSettings::Coarse {
                percent,
                coarsening,
            } => {
                let grids =
                    CoarseGrid::new(grid, *coarsening).map_err(|error| error.to_string())?;
                let search = self.settings.search();
                let coarse = CoarseToFine::searching(grids, &search, share(*percent)?);
                Box::new(coarse.map_err(|error| error.to_string())?)
            }
            ProposalSettings::Network {
                percent,
                coarsening,
            } => {
                let share = share(*percent)?;
                let proposer: Box<dyn Proposer> = if coarsening.is_none() {
                    Box::new(self.network(share))
                } else {
                    let grids =
                        CoarseGrid::new(grid, *coarsening).map_err(|error| error.to_string())?;
                    let wide = Box::new(self.network(CoarseToFine::wider(share)));
                    let search = self.settings.search();
                    let narrowed = CoarseToFine::narrowing(grids, &search, share, wide);
                    Box::new(narrowed.map_err(|error| error.to_string())?)
                };
                Box::new(OrExhaustive::new(proposer))
            }
        })
    }

    fn network(&self, share: Percent) -> RemoteProposer {
        RemoteProposer::new(
            self.cell.clone(),
            self.helpers.client.clone(),
            Arc::clone(&self.helpers.ppn),
            share,
            Duration::from_secs_f64(self.settings.propose_limit_s),
        )
    }

    fn evaluator(&self, grid: &Grid) -> Result<SharedEvaluator, String> {
        let stability = self.settings.stability;
        let judgement = Judgement {
            settings: self.settings.search(),
            checks: Box::new(move || stability.checks()),
            checks_on_wire: stability.to_messages(),
        };
        let evaluator = SharedEvaluator::new(
            self.cell.clone(),
            self.helpers.client.clone(),
            Arc::clone(&self.helpers.heuristic),
            Duration::from_secs_f64(self.settings.evaluate_limit_s),
            grid,
            judgement,
        );
        evaluator.map_err(|error| error.to_string())
    }
}
