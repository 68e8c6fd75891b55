//! Options for where proposals come from, and the proposers they stand for.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, ValueEnum};
use ppnpack_model::settings::Device;
use ppnpack_model::weights::Model;
use ppnpack_packing::coarse::{CoarseGrid, CoarseToFine, Coarsening};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::item::Item;
use ppnpack_packing::proposals::{Percent, ProposeAll, ProposeRandom, Proposer};
use ppnpack_packing::search::SearchSettings;
use serde::{Deserialize, Serialize};

use crate::failure::{Failure, OrInput, OrRun, Outcome};
use crate::length::parse_length;
use crate::network::{Backend, Proposing};

/// The cell that proposals are made with on finer grids: the paper's, which the network is trained on.
const PROPOSAL_CELL_M: f64 = 0.01;

/// The yaws that proposals are made for on grids with more.
pub const PROPOSAL_YAWS: usize = 4;

/// Where proposals come from.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Proposals")]
pub(crate) struct ProposalOptions {
    /// Which placements are evaluated
    #[arg(long = "proposals", value_enum, default_value = "bounded")]
    from: ProposalsOption,

    /// The share of placements that is proposed, in percent
    #[arg(
        long = "k",
        value_name = "PERCENT",
        default_value_t = 5.0,
        allow_hyphen_values = true
    )]
    percent: f64,

    /// The cell of the grid that the network or the coarse search proposes on
    /// [default: 1 cm, and twice --cell for a coarse search on cells of 1 cm or more]
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, allow_hyphen_values = true)]
    proposal_cell: Option<f64>,

    /// How many yaws at most the network or the coarse search proposes for; the others follow the nearest
    #[arg(long, value_name = "COUNT", default_value_t = PROPOSAL_YAWS, value_parser = at_least_one)]
    proposal_yaws: usize,

    /// The network's weights, a .safetensors file with its .json card beside it [default: those that ship]
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,

    /// Where the network runs
    #[arg(long, value_enum, default_value = "cpu")]
    device: DeviceOption,
}

/// Where proposals come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ProposalsOption {
    /// Every placement: the exhaustive search
    All,
    /// Every placement that a bound does not rule out: the choices of `all`, in less time; on one thread
    Bounded,
    /// A random share of them, see --k
    Random,
    /// Those that the heuristic itself ranks best on a coarser grid, see --k and --proposal-cell
    Coarse,
    /// Those that the placement proposal network scores best, see --k and --model
    Network,
    /// What takes least time of `bounded`, `coarse` and `network` on this machine and for these objects: measured at the
    /// start
    Auto,
}

/// See [`Device`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DeviceOption {
    /// The processor
    Cpu,
    /// The first CUDA device; PPNPACK_TORCH names the folder of a full torch installation
    Cuda,
}

impl From<DeviceOption> for Device {
    fn from(option: DeviceOption) -> Self {
        match option {
            DeviceOption::Cpu => Self::Cpu,
            DeviceOption::Cuda => Self::Cuda,
        }
    }
}

/// The source of proposals, as results record it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "from")]
pub enum ProposalSource {
    /// Every placement.
    All,
    /// Every placement that a bound does not rule out.
    Bounded,
    /// A random share.
    Random {
        /// `K`.
        percent: f64,
    },
    /// The share that the heuristic ranks best on a coarser grid.
    Coarse {
        /// `K`.
        percent: f64,
        /// How coarse.
        coarsening: Coarsening,
    },
    /// The share that a network scores best.
    Network {
        /// `K`.
        percent: f64,
        /// How much coarser than the grid it scores.
        coarsening: Coarsening,
        /// The hash of its weights.
        model: String,
    },
}

impl ProposalSource {
    /// A coarse search of this share for so many yaws at most, with the default cell for a grid.
    pub fn coarse(grid: &Grid, percent: f64, yaws: usize) -> Self {
        Self::Coarse {
            percent,
            coarsening: coarse_search(grid, None, yaws),
        }
    }

    /// A network's share for so many yaws at most, with the default cell for a grid.
    pub fn network(grid: &Grid, percent: f64, yaws: usize, model: &Model) -> Self {
        Self::Network {
            percent,
            coarsening: Coarsening::towards(grid, PROPOSAL_CELL_M, yaws),
            model: model.card().weights_blake3.clone(),
        }
    }

    /// Whether a network proposes.
    pub fn is_network(&self) -> bool {
        matches!(self, Self::Network { .. })
    }

    /// The proposer of this source; `settings` are those of the search that decides, `network` the one that is named.
    ///
    /// # Errors
    /// Why it cannot be used on this grid or on this machine.
    pub fn open(
        &self,
        grid: &Grid,
        settings: &SearchSettings,
        network: Option<Network<'_>>,
    ) -> Outcome<Box<dyn Proposer>> {
        match (self, network) {
            (Self::All | Self::Bounded, _) => Ok(Box::new(ProposeAll)),
            (Self::Random { percent }, _) => {
                let share = Percent::new(*percent).or_input()?;
                Ok(Box::new(ProposeRandom::new(share, settings.seed)))
            }
            (
                Self::Coarse {
                    percent,
                    coarsening,
                },
                _,
            ) => {
                let share = Percent::new(*percent).or_input()?;
                let grids = CoarseGrid::new(grid, *coarsening).or_input()?;
                let coarse = CoarseToFine::searching(grids, settings, share).or_input()?;
                Ok(Box::new(coarse))
            }
            (
                Self::Network {
                    percent,
                    coarsening,
                    ..
                },
                Some(network),
            ) => network.open(grid, settings, *coarsening, *percent),
            (Self::Network { .. }, None) => Err(Failure::input(
                "the method needs a network, but none is given",
            )),
        }
    }
}

impl std::fmt::Display for ProposalSource {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::All => formatter.write_str("all"),
            Self::Bounded => formatter.write_str("bounded"),
            Self::Random { percent } => write!(formatter, "random, K = {percent} %"),
            Self::Coarse { percent, .. } => write!(formatter, "coarse, K = {percent} %"),
            Self::Network { percent, .. } => write!(formatter, "network, K = {percent} %"),
        }
    }
}

/// Parses a number of yaws.
///
/// # Errors
/// What is wrong with it, in words.
pub fn at_least_one(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if count > 0 => Ok(count),
        _ => Err("must be a whole number of at least 1".to_owned()),
    }
}

/// The coarsening of a coarse search: at least two cells in one, or it would be the exhaustive search twice.
fn coarse_search(grid: &Grid, cell_m: Option<f64>, yaws: usize) -> Coarsening {
    let twice_m = 2.0 * grid.resolution().cell_m();
    let cell_m = cell_m.unwrap_or(PROPOSAL_CELL_M.max(twice_m));
    Coarsening::towards(grid, cell_m, yaws)
}

/// A model, and what can run it.
#[derive(Clone, Copy)]
pub struct Network<'a> {
    /// What runs it.
    pub backend: &'a dyn Backend,
    /// Its weights.
    pub model: &'a Model,
    /// Where it runs.
    pub device: Device,
    /// The items that are known ahead of time.
    pub items: &'a [Arc<Item>],
}

impl Network<'_> {
    /// A proposer of the best-scored `percent`, which scores placements on a coarser grid where there is one; there,
    /// the heuristic of `settings` chooses among a wider share for all candidates together.
    ///
    /// # Errors
    /// Why it cannot run here.
    pub fn open(
        &self,
        grid: &Grid,
        settings: &SearchSettings,
        coarsening: Coarsening,
        percent: f64,
    ) -> Outcome<Box<dyn Proposer>> {
        let share = Percent::new(percent).or_input()?;
        let open = |grid: &Grid, share, items: &[Arc<Item>]| {
            let how = Proposing {
                grid,
                share,
                device: self.device,
                items,
            };
            self.backend.open(self.model, &how).or_run()
        };
        if coarsening.is_none() {
            return open(grid, share, self.items);
        }
        let grids = CoarseGrid::new(grid, coarsening).or_input()?;
        let coarse = self
            .items
            .iter()
            .map(|item| Ok(Arc::new(grids.item(item).or_input()?)));
        let coarse = coarse.collect::<Outcome<Vec<_>>>()?;
        let wide = open(grids.coarse(), CoarseToFine::wider(share), &coarse)?;
        let narrowed = CoarseToFine::narrowing(grids, settings, share, wide).or_input()?;
        let shapes = self.items.iter().map(|item| item.shape());
        Ok(Box::new(narrowed.with_items(shapes.zip(coarse))))
    }
}

/// The model of a file, or the one that ships.
///
/// # Errors
/// Why the file cannot be used.
pub fn read_model(file: Option<&Path>) -> Outcome<Model> {
    file.map_or_else(Model::shipped, Model::read).or_input()
}

impl ProposalOptions {
    /// Whether a network may be used.
    pub(crate) fn uses_network(&self) -> bool {
        matches!(self.from, ProposalsOption::Network | ProposalsOption::Auto)
    }

    /// The model to propose with, where a network may be used.
    pub(crate) fn read_model(&self) -> Outcome<Option<Model>> {
        if self.uses_network() {
            read_model(self.model.as_deref()).map(Some)
        } else {
            Ok(None)
        }
    }

    pub(crate) fn device(&self) -> Device {
        self.device.into()
    }

    /// The sources among which the fastest is wanted; one, but for `auto`.
    pub(crate) fn sources(
        &self,
        grid: &Grid,
        model: Option<&Model>,
    ) -> Outcome<Vec<ProposalSource>> {
        let percent = Percent::new(self.percent).or_input()?.percent();
        let coarse = ProposalSource::Coarse {
            percent,
            coarsening: coarse_search(grid, self.proposal_cell, self.proposal_yaws),
        };
        let cell_m = self.proposal_cell.unwrap_or(PROPOSAL_CELL_M);
        let network = model.map(|model| ProposalSource::Network {
            percent,
            coarsening: Coarsening::towards(grid, cell_m, self.proposal_yaws),
            model: model.card().weights_blake3.clone(),
        });
        Ok(match self.from {
            ProposalsOption::All => vec![ProposalSource::All],
            ProposalsOption::Bounded => vec![ProposalSource::Bounded],
            ProposalsOption::Random => vec![ProposalSource::Random { percent }],
            ProposalsOption::Coarse => vec![coarse],
            ProposalsOption::Network => network.into_iter().collect(),
            ProposalsOption::Auto => [ProposalSource::Bounded, coarse]
                .into_iter()
                .chain(network)
                .collect(),
        })
    }
}
