//! Options for where proposals come from, and the network that may make them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::builder::TypedValueParser;
use clap::{Args, ValueEnum};
use ppnpack_model::settings::Device;
use ppnpack_model::weights::Model;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::item::Item;
use ppnpack_packing::method::{OpenNetwork, ProposalSource};
use ppnpack_packing::proposals::{Percent, Proposer};
use ppnpack_packing::step::StageError;

use super::choice::{Choice, one_of};
use crate::failure::{OrInput, Outcome};
use crate::network::{Backend, Proposing};

/// The yaws that proposals are made for on grids with more.
pub const PROPOSAL_YAWS: usize = 4;

/// Where proposals come from.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Proposals")]
pub(crate) struct ProposalOptions {
    /// Which placements are evaluated
    /// [default: bounded under robot conditions, all under the reference's]
    #[arg(long = "proposals", value_enum)]
    from: Option<ProposalsOption>,

    /// The share of placements that is proposed, in percent
    #[arg(
        long = "k",
        value_name = "PERCENT",
        default_value_t = 5.0,
        allow_hyphen_values = true
    )]
    percent: f64,

    /// The network's weights, a .safetensors file with its .json card beside it [default: those that ship]
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,

    /// Where the network runs
    #[arg(long, value_parser = parse_device(), default_value = "cpu")]
    device: Device,
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
    /// Those that the placement proposal network scores best, see --k and --model
    Network,
}

const DEVICES: [Choice<Device>; 2] = [
    ("cpu", Device::Cpu, "The processor"),
    (
        "cuda",
        Device::Cuda,
        "The first CUDA device; PPNPACK_TORCH names the folder of a full torch installation",
    ),
];

/// Parses the name of a device that networks run on.
pub fn parse_device() -> impl TypedValueParser<Value = Device> {
    one_of(&DEVICES)
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

impl OpenNetwork for Network<'_> {
    fn open(
        &self,
        grid: &Grid,
        share: Percent,
        items: &[Arc<Item>],
    ) -> Result<Box<dyn Proposer>, StageError> {
        let how = Proposing {
            grid,
            share,
            device: self.device,
            items,
        };
        Ok(self.backend.open(self.model, &how)?)
    }

    fn items(&self) -> &[Arc<Item>] {
        self.items
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
        self.from == Some(ProposalsOption::Network)
    }

    /// The model to propose with, where a network may be used.
    pub(crate) fn read_model(&self) -> Outcome<Option<Model>> {
        if self.uses_network() {
            read_model(self.model.as_deref()).map(Some)
        } else {
            Ok(None)
        }
    }

    /// What opens the network of the model, where there is one.
    pub(crate) fn network<'a>(
        &self,
        backend: &'a dyn Backend,
        model: Option<&'a Model>,
        items: &'a [Arc<Item>],
    ) -> Option<Network<'a>> {
        Some(Network {
            backend,
            model: model?,
            device: self.device,
            items,
        })
    }

    /// Where proposals come from, where that is said; `model` is what [`Self::read_model`] gave.
    pub(crate) fn source(
        &self,
        grid: &Grid,
        model: Option<&Model>,
    ) -> Outcome<Option<ProposalSource>> {
        let percent = Percent::new(self.percent).or_input()?.percent();
        let network = model.map(|model| {
            let weights = &model.card().weights_blake3;
            ProposalSource::network(grid, percent, None, PROPOSAL_YAWS, weights)
        });
        Ok(match self.from {
            None => None,
            Some(ProposalsOption::All) => Some(ProposalSource::All),
            Some(ProposalsOption::Bounded) => Some(ProposalSource::Bounded),
            Some(ProposalsOption::Random) => Some(ProposalSource::Random { percent }),
            Some(ProposalsOption::Network) => network,
        })
    }
}
