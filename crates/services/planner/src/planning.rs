//! Algorithm 1 for one cell, over the services that are alive.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_packing::coarse::{CoarseGrid, CoarseToFine};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::plan::{CandidateReport, Evaluated, PlanError, Planner, Timings};
use ppnpack_packing::proposals::{OrExhaustive, Percent, ProposeAll, ProposeRandom, Proposer};
use ppnpack_packing::search::Search;
use ppnpack_packing::step::{Candidate, StepInput};
use ppnpack_packing::valid::ValidSearch;
use ppnpack_robot::refusal::Refusal;
use ppnpack_robot::station::ArmStation;
use ppnpack_service::alive::Alive;
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::arm::{self, ArmInTime};
use crate::remote::{Judgement, RemoteProposer, SharedEvaluator, StepContext};
use crate::rules;
use crate::session::{Lying, Rules};
use crate::settings::{CellSettings, ProposalSettings, Where};

/// How many more placements are asked for where rules may refuse some.
const WANTED_WITH_RULES: usize = 64;

/// How many placements are asked for where an arm may refuse some.
const WANTED_WITH_ARM: usize = 16;

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
    context: Arc<StepContext>,
    station: Option<ArmStation>,
}

/// A planned step.
#[derive(Debug, Clone)]
pub(crate) struct Planned {
    pub(crate) choice: Option<Evaluated>,
    pub(crate) alternatives: Vec<Evaluated>,
    pub(crate) reports: Vec<CandidateReport>,
    /// Per candidate: how many placements each check refused.
    pub(crate) refusals: Vec<Vec<(&'static str, u64)>>,
    pub(crate) timings: Timings,
    pub(crate) is_widened: bool,
    pub(crate) degraded: Vec<String>,
    /// Whether there was no time to search everything: that there is no choice does not mean that nothing fits.
    pub(crate) is_cut: bool,
}

/// What is asked of a step.
pub(crate) struct Wanted {
    pub(crate) step: u64,
    pub(crate) alternatives: usize,
    pub(crate) deadline: Instant,
    /// By arrival.
    pub(crate) rules: HashMap<usize, Rules>,
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
        let context = Arc::new(StepContext::new());
        let remote = Remote {
            cell,
            settings,
            helpers,
            context: &context,
        };
        let proposer = remote.proposer(&grid)?;
        let mut checks = rules::checks(&context);
        let station = settings.station().map_err(|error| error.to_string())?;
        if let Some(station) = &station {
            checks.push(Box::new(ArmInTime::new(station, &context)));
        }
        let evaluator: Box<dyn ppnpack_packing::plan::Evaluator> = match settings.evaluate {
            Where::Fastest => Box::new(remote.evaluator(&grid)?.sooner_way()),
            Where::Services => Box::new(remote.evaluator(&grid)?),
            Where::InProcess => {
                checks.extend(settings.stability.checks());
                let search = Search::new(&grid, &settings.search());
                Box::new(search.map_err(|error| error.to_string())?.bounded())
            }
        };
        let planner = Planner::new(proposer, evaluator, checks, settings.order, settings.seed);
        Ok(Self {
            grid,
            planner,
            context,
            station,
        })
    }

    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The arm, where there is one.
    pub(crate) fn station(&self) -> Option<&ArmStation> {
        self.station.as_ref()
    }

    /// How the arm carries out a choice of the last step; `None` where there is no arm.
    ///
    /// # Errors
    /// [`Refusal`] where it cannot: never for what its check has accepted.
    pub(crate) fn cycle(
        &self,
        scene: &Scene,
        candidate: &Candidate,
        choice: &Evaluated,
        lying: &Lying,
    ) -> Result<Option<v1::ArmCycle>, Refusal> {
        let Some(station) = &self.station else {
            return Ok(None);
        };
        let input = StepInput {
            grid: &self.grid,
            scene,
            candidates: &[],
            step: 0,
        };
        let mut cycle = station.cycle(&input, candidate, &choice.resting)?;
        let from = &mut cycle.from.container_from_item;
        *from = lying.own_frame(from);
        Ok(Some(arm::write(station, &cycle)))
    }

    /// Plans a step.
    ///
    /// # Errors
    /// [`PlanError`] where the input does not match the grid or a stage failed.
    pub(crate) fn plan(
        &mut self,
        scene: &Scene,
        candidates: &[Candidate],
        wanted: Wanted,
    ) -> Result<Planned, PlanError> {
        let has_rules = wanted
            .rules
            .values()
            .any(|rules| rules.is_bottom_only || rules.is_upright);
        let spare = match (has_rules, &self.station) {
            (true, _) => WANTED_WITH_RULES,
            (false, Some(_)) => WANTED_WITH_ARM,
            (false, None) => 1,
        };
        let at_first = spare.max(wanted.alternatives + 1);
        self.context.begin(wanted.deadline, at_first, wanted.rules);
        self.planner.set_alternatives(wanted.alternatives);
        let input = StepInput {
            grid: &self.grid,
            scene,
            candidates,
            step: wanted.step,
        };
        let plan = self.planner.plan(&input)?;
        let mut degraded = self.context.take_degraded();
        degraded.extend(plan.degraded().map(str::to_owned));
        Ok(Planned {
            choice: plan.choice(),
            alternatives: plan.alternatives().to_vec(),
            reports: plan.candidates().to_vec(),
            refusals: (0..candidates.len())
                .map(|candidate| plan.refusals(candidate).collect())
                .collect(),
            timings: plan.timings(),
            is_widened: plan.is_widened(),
            degraded,
            is_cut: self.context.is_cut(),
        })
    }
}

/// Makes the stages of one cell.
struct Remote<'a> {
    cell: &'a Cell,
    settings: &'a CellSettings,
    helpers: &'a Helpers,
    context: &'a Arc<StepContext>,
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
            Arc::clone(self.context),
            share,
            Duration::from_secs_f64(self.settings.propose_limit_s),
        )
    }

    fn evaluator(&self, grid: &Grid) -> Result<SharedEvaluator, String> {
        let search = self.settings.search();
        let local = ValidSearch::new(grid, &search, self.settings.stability.checks())
            .map_err(|error| error.to_string())?;
        let judgement = Judgement {
            settings: search,
            checks: self.settings.stability.to_messages(),
            local,
        };
        Ok(SharedEvaluator::new(
            self.cell.clone(),
            self.helpers.client.clone(),
            Arc::clone(&self.helpers.heuristic),
            Arc::clone(self.context),
            Duration::from_secs_f64(self.settings.evaluate_limit_s),
            judgement,
        ))
    }
}
