//! Options for how placements are found and judged.

use std::sync::Arc;

use clap::{Args, ValueEnum};
use ppnpack_packing::check::BoxedCheck;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::objective::{Heuristic, Order, Weights};
use ppnpack_packing::plan::Planner;
use ppnpack_packing::proposals::Proposer;
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::{
    PhysicalStability, PhysicalStabilitySettings, PublishedStability,
};
use ppnpack_robot::station::{ArmStation, StationSettings};
use serde::{Deserialize, Serialize};

use super::arm::ArmOptions;
use super::proposals::{Network, ProposalOptions, ProposalSource};
use crate::failure::{Failure, OrInput, Outcome};

/// How placements are found and judged.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodOptions {
    /// What placements are judged by
    #[arg(long, value_enum, default_value = "sdfm")]
    pub(crate) heuristic: HeuristicOption,

    /// How the items of the buffer compete for a step
    #[arg(long, value_enum, default_value = "balance")]
    pub(crate) order: OrderOption,

    #[command(flatten)]
    pub(crate) proposals: ProposalOptions,

    /// The stability test: `physical` for real cells, `published` for comparisons with the paper
    #[arg(long, value_enum, default_value = "physical")]
    pub(crate) stability: StabilityOption,

    #[command(flatten)]
    pub(crate) arm: ArmOptions,

    /// A weight of the objective, such as distance=2.5 (may be repeated)
    #[arg(long = "weight", value_name = "NAME=VALUE")]
    pub(crate) weights: Vec<String>,

    /// How many items the robot may choose among
    #[arg(long, value_name = "COUNT", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) buffer: u32,

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    pub(crate) seed: u64,

    /// Threads for one step; the result is the same with any number. The bounded search runs on one
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(crate) threads: u32,
}

/// See [`Heuristic`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum HeuristicOption {
    /// Low, close to content, compact (SDF minimisation)
    Sdfm,
    /// Deepest bottom-left
    Dbl,
    /// Heightmap minimisation
    Hm,
    /// Maximum touching area
    Mta,
    /// The first valid placement
    FirstFit,
    /// A valid placement at random
    Random,
}

impl From<HeuristicOption> for Heuristic {
    fn from(option: HeuristicOption) -> Self {
        match option {
            HeuristicOption::Sdfm => Self::Sdfm,
            HeuristicOption::Dbl => Self::Dbl,
            HeuristicOption::Hm => Self::Hm,
            HeuristicOption::Mta => Self::Mta,
            HeuristicOption::FirstFit => Self::FirstFit,
            HeuristicOption::Random => Self::Random,
        }
    }
}

/// See [`Order`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OrderOption {
    /// All together, large items early
    Balance,
    /// By decreasing volume of the bounding box
    Bbox,
    /// As they arrived
    Arrival,
    /// In random order
    Shuffled,
}

impl From<OrderOption> for Order {
    fn from(option: OrderOption) -> Self {
        match option {
            OrderOption::Balance => Self::Balance,
            OrderOption::Bbox => Self::BboxVolume,
            OrderOption::Arrival => Self::Arrival,
            OrderOption::Shuffled => Self::Shuffled,
        }
    }
}

/// Which stability test placements must pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StabilityOption {
    /// On the real surfaces, in metres
    Physical,
    /// The paper's
    Published,
    /// None: only the fit is checked
    None,
}

impl StabilityOption {
    /// The checks that it stands for.
    pub fn checks(self) -> Vec<BoxedCheck> {
        match self {
            Self::Physical => {
                vec![Box::new(PhysicalStability::new(
                    PhysicalStabilitySettings::default(),
                ))]
            }
            Self::Published => vec![Box::new(PublishedStability::default())],
            Self::None => vec![],
        }
    }
}

/// A packing method, as results record it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Method {
    /// What placements are judged by.
    pub heuristic: Heuristic,
    /// How the items of the buffer compete.
    pub order: Order,
    /// Which placements are evaluated.
    pub proposals: ProposalSource,
    /// The stability test that they must pass.
    pub stability: StabilityOption,
    /// The arm that has to make the placements, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<StationSettings>,
    /// The objective's weights.
    pub weights: Weights,
    /// How many items there are to choose among.
    pub buffer: usize,
    /// Seeds everything that is random.
    pub seed: u64,
}

impl MethodOptions {
    /// The method with these proposals.
    pub(crate) fn method(&self, proposals: ProposalSource) -> Outcome<Method> {
        Ok(Method {
            heuristic: self.heuristic.into(),
            order: self.order.into(),
            proposals,
            stability: self.stability,
            arm: self.arm.settings()?,
            weights: weights(&self.weights)?,
            buffer: self.buffer as usize,
            seed: self.seed,
        })
    }
}

impl Method {
    /// The planner that follows this method on `threads` threads; `network` is the one that it names, if any.
    ///
    /// # Errors
    /// What of the method cannot be used on this grid or on this machine.
    pub fn planner(
        &self,
        grid: &Grid,
        threads: u32,
        network: Option<Network<'_>>,
    ) -> Outcome<Planner> {
        let proposer = self.proposer(grid, network)?;
        let station = self.station()?;
        self.planner_with(proposer, grid, threads, station.as_ref())
    }

    /// The arm at work, where there is one.
    pub(crate) fn station(&self) -> Outcome<Option<ArmStation>> {
        self.arm
            .as_ref()
            .map(ArmStation::new)
            .transpose()
            .or_input()
    }

    /// Where this method's proposals come from.
    ///
    /// # Errors
    /// Why that cannot be used on this grid or on this machine.
    pub fn proposer(
        &self,
        grid: &Grid,
        network: Option<Network<'_>>,
    ) -> Outcome<Box<dyn Proposer>> {
        self.proposals.open(grid, &self.search_settings(), network)
    }

    /// What its search is made for.
    pub fn search_settings(&self) -> SearchSettings {
        SearchSettings {
            heuristic: self.heuristic,
            order: self.order,
            weights: self.weights,
            seed: self.seed,
        }
    }

    /// The planner that follows this method on other proposals, with its arm.
    ///
    /// # Errors
    /// What of the method cannot be used on this grid.
    pub fn planner_with(
        &self,
        proposer: Box<dyn Proposer>,
        grid: &Grid,
        threads: u32,
        station: Option<&ArmStation>,
    ) -> Outcome<Planner> {
        let mut search = Search::new(grid, &self.search_settings()).or_input()?;
        if self.proposals != ProposalSource::All {
            search = search.bounded();
        }
        if threads > 1 {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads as usize)
                .build();
            search = search.with_pool(Arc::new(pool.or_input()?));
        }
        let mut checks = self.stability.checks();
        checks.extend(station.map(|station| Box::new(station.check()) as BoxedCheck));
        Ok(Planner::new(
            proposer,
            Box::new(search),
            checks,
            self.order,
            self.seed,
        ))
    }
}

fn weights(assignments: &[String]) -> Outcome<Weights> {
    let mut named = match serde_json::to_value(Weights::default()).or_input()? {
        serde_json::Value::Object(named) => named,
        _ => serde_json::Map::new(),
    };
    for assignment in assignments {
        let wrong = |why: &str| {
            let names: Vec<&str> = named.keys().map(String::as_str).collect();
            Failure::input(format_args!(
                "--weight {assignment}: {why}; give NAME=VALUE with one of {}",
                names.join(", ")
            ))
        };
        let Some((name, value)) = assignment.split_once('=') else {
            return Err(wrong("there is no '='"));
        };
        if !named.contains_key(name) {
            return Err(wrong("there is no such weight"));
        }
        let value = value.parse().ok().filter(|value: &f64| value.is_finite());
        let value = value.ok_or_else(|| wrong("the value is no finite number"))?;
        named.insert(name.to_owned(), serde_json::json!(value));
    }
    let weights: Weights = serde_json::from_value(serde_json::Value::Object(named)).or_input()?;
    weights.validate().or_input()?;
    Ok(weights)
}
