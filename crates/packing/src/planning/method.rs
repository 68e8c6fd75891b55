//! Packing methods, as they stand in configurations and results.

use std::sync::Arc;

use ppnpack_numbers::{SettingError, settings, within};
use serde::{Deserialize, Serialize};

use crate::checks::check::{BoxedCheck, Cost};
use crate::checks::loads::LoadSettings;
use crate::checks::sequence::Sequence;
use crate::checks::stability::{PhysicalStability, PhysicalStabilitySettings, PublishedStability};
use crate::checks::trial::TrialSettings;
use crate::kernel::grid::Grid;
use crate::kernel::item::{Item, ItemError};
use crate::kernel::objective::{Heuristic, Order, Weights};
use crate::planning::plan::Planner;
use crate::ranking::coarse::{CoarseGrid, CoarseGridError, CoarseToFine, Coarsening};
use crate::ranking::evaluator::Evaluator;
use crate::ranking::proposals::{
    OrExhaustive, Percent, ProposeAll, ProposeRandom, ProposeTries, Proposer,
};
use crate::ranking::scene_value::{Farsighted, SceneValue};
use crate::ranking::search::{Search, SearchSettings};
use crate::ranking::step::StageError;

/// Cell that proposals are made with on finer grids: the paper's, which the network learnt.
const PROPOSAL_CELL_M: f64 = 0.01;

/// The number of items that may be set aside for the next container where nothing is said.
pub const SET_ASIDE: usize = 20;

settings! {
    /// A packing method: which placements are evaluated, how judged, and what they must pass.
    ///
    /// The default is what commands, services, bindings and experiments do where nothing is said,
    /// on the default [`GridSettings`](crate::kernel::grid::GridSettings) and with [`SET_ASIDE`].
    pub struct Method {
        /// Objective.
        pub heuristic: Heuristic = Heuristic::Sdfm,
        /// Competition among the items of the buffer.
        pub order: Order = Order::Balance,
        /// Placements that are evaluated.
        pub proposals: ProposalSource = ProposalSource::Bounded,
        /// The stability test that they must pass.
        pub stability: Stability = Stability::None,
        /// Tries in a simulation of the cell, which placements must pass too.
        pub trial: TrialSettings = TrialSettings::default(),
        /// Limits of loads and balance.
        pub loads: LoadSettings = LoadSettings::default(),
        /// The weights of the objective; `None` for [`Weights::for_poses`].
        #[serde(skip_serializing_if = "Option::is_none")]
        pub weights: Option<Weights> = None,
        /// How much the value of what a placement leaves counts beside the objective.
        pub scene_value: SceneValue = SceneValue::default(),
        /// How many of the waiting items may be chosen from.
        pub buffer: usize = 5,
        /// The seed of everything that is random.
        pub seed: u64 = 0,
    }
}

/// Stability test that placements must pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stability {
    /// On the real surfaces, in metres.
    Physical,
    /// The paper's.
    Published,
    /// None: only the fit is checked.
    None,
}

/// Source of the placements that are evaluated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "from", deny_unknown_fields)]
pub enum ProposalSource {
    /// Every placement.
    All,
    /// Every placement that a bound does not rule out.
    Bounded,
    /// A random share, in percent.
    Random {
        /// `K`.
        percent: f64,
    },
    /// Some random positions at some random yaws of each item. Where none is valid for any item of
    /// the buffer, nothing is placed: see [`ProposalSource::PUBLISHED_TRIES`].
    Tries {
        /// How many yaws, each drawn from all.
        yaws: u8,
        /// How many positions at each of them.
        positions: u8,
    },
    /// The share that a network scores best.
    Network {
        /// `K`.
        percent: f64,
        /// How much coarser the grid is that it scores on; 1 and 1 for the same.
        coarsening: Coarsening,
        /// The hash of its weights, where that is known.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        model: Option<String>,
    },
}

/// Opens the network that a method names.
pub trait OpenNetwork {
    /// A proposer of the best-scored `share` of each item's placements; `items` are known ahead.
    fn open(
        &self,
        grid: &Grid,
        share: Percent,
        items: &[Arc<Item>],
    ) -> Result<Box<dyn Proposer>, StageError>;

    /// The items that are known ahead of time.
    fn items(&self) -> &[Arc<Item>] {
        &[]
    }
}

/// Why a method cannot be followed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MethodError {
    /// There is no such coarse grid.
    #[error(transparent)]
    Coarse(#[from] CoarseGridError),
    /// An item has no place on the coarse grid.
    #[error(transparent)]
    Item(#[from] ItemError),
    /// A number is not possible.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Placements are to be tried.
    #[error("the method tries placements in a simulation, but none is given")]
    NoSimulation,
    /// A network is to propose.
    #[error("the method needs a network, but none is given")]
    NoNetwork,
    /// The network does not run here.
    #[error(transparent)]
    Network(StageError),
}

impl Method {
    /// The paper's: every placement is evaluated, its stability test decides, and nothing is tried.
    pub fn published() -> Self {
        Self {
            proposals: ProposalSource::All,
            stability: Stability::Published,
            trial: TrialSettings::off(),
            weights: Some(Weights::default()),
            scene_value: SceneValue::off(),
            ..Self::default()
        }
    }

    /// Gives it the weights that suit items in so many poses, where it has none.
    #[must_use]
    pub fn for_poses(self, poses: usize) -> Self {
        Self {
            weights: Some(self.weights.unwrap_or(Weights::for_poses(poses))),
            ..self
        }
    }

    /// Checks every number; what a grid or a network has to do with it is seen where it is built.
    pub fn validate(&self) -> Result<(), MethodError> {
        if let Some(weights) = self.weights {
            weights.validate()?;
        }
        self.trial.validate()?;
        self.loads.validate()?;
        self.scene_value.validate()?;
        let buffer = within("between 1 and 1000", 1.0..=1e3);
        buffer("the buffer", self.buffer as f64)?;
        if let ProposalSource::Tries { yaws, positions } = self.proposals {
            let count = within("at least 1", 1.0..=f64::from(u8::MAX));
            count("the number of yaws that are tried", f64::from(yaws))?;
            count(
                "the number of positions that are tried",
                f64::from(positions),
            )?;
        }
        Ok(())
    }

    /// Gives the settings of its search.
    pub fn search_settings(&self) -> SearchSettings {
        SearchSettings {
            heuristic: self.heuristic,
            order: self.order,
            weights: self.weights.unwrap_or(Weights::for_poses(1)),
            seed: self.seed,
            above_rim_m: match self.trial.is_on() {
                true => self.trial.above_rim_m,
                false => 0.0,
            },
        }
    }

    /// The planner that follows the method; `network` opens the method's network.
    ///
    /// # Errors
    /// [`MethodError`] where it cannot be followed on this grid, or the network does not run.
    pub fn build(
        &self,
        grid: &Grid,
        network: Option<&dyn OpenNetwork>,
    ) -> Result<Planner, MethodError> {
        self.build_with(grid, self.proposer(grid, network)?, [])
    }

    /// The planner that follows the method by what `proposer` proposes; placements must pass `checks`
    /// too, such as the simulation.
    ///
    /// # Errors
    /// [`MethodError`] where a weight is not possible, or the simulation is missing.
    pub fn build_with(
        &self,
        grid: &Grid,
        proposer: Box<dyn Proposer>,
        checks: impl IntoIterator<Item = BoxedCheck>,
    ) -> Result<Planner, MethodError> {
        let mut search = Search::new(grid, &self.search_settings())?;
        if self.proposals != ProposalSource::All {
            search = search.bounded();
        }
        let evaluator = self.farsighted(Box::new(search));
        let mut all = self.stability.checks();
        all.extend(self.loads.checks());
        all.push(Box::new(Sequence));
        all.extend(checks);
        let is_simulated = all.iter().any(|check| check.cost() == Cost::Simulation);
        if self.trial.is_on() && !is_simulated {
            return Err(MethodError::NoSimulation);
        }
        Ok(Planner::new(
            proposer, evaluator, all, self.order, self.seed,
        ))
    }

    /// An evaluator whose best placements are ranked anew by what they leave, where that counts.
    pub fn farsighted(&self, evaluator: Box<dyn Evaluator>) -> Box<dyn Evaluator> {
        match self.scene_value.is_on() && self.order == Order::Balance {
            true => Box::new(Farsighted::new(evaluator, &self.scene_value)),
            false => evaluator,
        }
    }

    /// Makes the proposer; `network` opens the network that the method may name.
    ///
    /// # Errors
    /// [`MethodError`] where it cannot be used on this grid, or the network does not run.
    pub fn proposer(
        &self,
        grid: &Grid,
        network: Option<&dyn OpenNetwork>,
    ) -> Result<Box<dyn Proposer>, MethodError> {
        Ok(match &self.proposals {
            ProposalSource::All | ProposalSource::Bounded => Box::new(ProposeAll),
            ProposalSource::Random { percent } => {
                Box::new(ProposeRandom::new(Percent::new(*percent)?, self.seed))
            }
            ProposalSource::Tries { yaws, positions } => {
                Box::new(ProposeTries::new(*yaws, *positions, self.seed))
            }
            ProposalSource::Network {
                percent,
                coarsening,
                ..
            } => {
                let network = network.ok_or(MethodError::NoNetwork)?;
                let share = Percent::new(*percent)?;
                if coarsening.is_none() {
                    let opened = network.open(grid, share, network.items());
                    opened.map_err(MethodError::Network)?
                } else {
                    let grids = CoarseGrid::new(grid, *coarsening)?;
                    Box::new(self.narrowing(grids, share, network)?)
                }
            }
        })
    }

    /// Makes the proposer; but a network that does not run, now or later, gives way to all
    /// placements.
    ///
    /// # Errors
    /// [`MethodError`] where the method cannot be followed on this grid.
    pub fn proposer_or_exhaustive(
        &self,
        grid: &Grid,
        network: Option<&dyn OpenNetwork>,
    ) -> Result<Box<dyn Proposer>, MethodError> {
        match self.proposer(grid, network) {
            Ok(proposer) if self.proposals.is_network() => {
                Ok(Box::new(OrExhaustive::new(proposer)))
            }
            Err(MethodError::Network(error)) => {
                Ok(Box::new(OrExhaustive::instead(with_causes(&*error))))
            }
            other => other,
        }
    }

    /// A network on a coarser grid, where the heuristic chooses among a wider share for all
    /// together.
    fn narrowing(
        &self,
        grids: CoarseGrid,
        share: Percent,
        network: &dyn OpenNetwork,
    ) -> Result<CoarseToFine, MethodError> {
        let items = network.items();
        let coarse = items.iter().map(|item| grids.item(item).map(Arc::new));
        let coarse = coarse.collect::<Result<Vec<_>, _>>()?;
        let wide = network
            .open(grids.coarse(), CoarseToFine::wider(share), &coarse)
            .map_err(MethodError::Network)?;
        let narrowed = CoarseToFine::new(grids, &self.search_settings(), share, wide)?;
        let shapes = items.iter().map(|item| item.shape());
        Ok(narrowed.with_items(shapes.zip(coarse)))
    }
}

fn with_causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(error.source(), |cause| cause.source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}

impl Stability {
    /// The checks that it stands for.
    pub fn checks(self) -> Vec<BoxedCheck> {
        match self {
            Self::Physical => {
                let settings = PhysicalStabilitySettings::default();
                vec![Box::new(PhysicalStability::new(settings))]
            }
            Self::Published => vec![Box::new(PublishedStability::default())],
            Self::None => Vec::new(),
        }
    }
}

impl ProposalSource {
    /// The baseline "Random" of the tables. The published code tries four yaws with three by three
    /// positions and takes the first valid one; the paper's text has "a feasible placement". With
    /// these numbers it packs as many items as the paper says (`docs/results/table1.md`).
    pub const PUBLISHED_TRIES: Self = Self::Tries {
        yaws: 3,
        positions: 9,
    };

    /// The network of these weights on cells of `cell_m`, else the paper's, with at most `yaws`
    /// yaws.
    pub fn network(
        grid: &Grid,
        percent: f64,
        cell_m: Option<f64>,
        yaws: usize,
        model: &str,
    ) -> Self {
        let cell_m = cell_m.unwrap_or(PROPOSAL_CELL_M);
        Self::Network {
            percent,
            coarsening: Coarsening::towards(grid, cell_m, yaws),
            model: Some(model.to_owned()),
        }
    }

    /// Whether a network proposes.
    pub fn is_network(&self) -> bool {
        matches!(self, Self::Network { .. })
    }

    /// Whether a step may have no choice although an item of the buffer has a valid placement.
    pub fn gives_up_early(&self) -> bool {
        matches!(self, Self::Tries { .. })
    }
}

impl std::fmt::Display for ProposalSource {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::All => formatter.write_str("all"),
            Self::Bounded => formatter.write_str("bounded"),
            Self::Random { percent } => write!(formatter, "random, K = {percent} %"),
            Self::Tries { yaws, positions } => {
                write!(
                    formatter,
                    "tries, {yaws} yaws with {positions} positions each"
                )
            }
            Self::Network { percent, .. } => write!(formatter, "network, K = {percent} %"),
        }
    }
}
