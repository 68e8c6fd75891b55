//! Options of the source of proposals, and of the network that may make them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use clap::builder::TypedValueParser;
use ppnpack_model::settings::Device;
use ppnpack_model::weights::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::planning::method::{OpenNetwork, ProposalSource};
use ppnpack_packing::ranking::proposals::{Percent, Proposer};
use ppnpack_packing::ranking::step::StageError;

use super::{Choice, one_of};
use crate::failure::{OrInput, Outcome};
use crate::launcher::TORCH_FOLDER;
use crate::network::{Backend, Proposing};

/// Number of yaws that proposals are made for on grids with more.
pub const PROPOSAL_YAWS: usize = 4;

/// The source of proposals.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct ProposalOptions {
    /// The placements that are evaluated: `bounded`, every one that a bound does not rule out;
    /// `all`, which chooses the same in more time; `random`, a share of them; `network`, those that
    /// the placement proposal network scores best. K is the share in percent, 5 where it is left
    /// out [default: bounded under robot conditions, all under the reference's]
    #[arg(long = "proposals", value_name = "bounded|all|random[:K]|network[:K]", value_parser = parse_source)]
    source: Option<Source>,

    /// The network's weights, a .safetensors file with its .json card beside it [default: those
    /// that ship]
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
}

/// The source of proposals.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    All,
    Bounded,
    Random(Percent),
    Network(Percent),
}

/// Default share that is proposed, in percent.
const USUAL_PERCENT: f64 = 5.0;

fn parse_source(text: &str) -> Result<Source, String> {
    let percent = text.split_once(':').map(|(_, percent)| percent);
    let name = text.split(':').next().unwrap_or_default();
    let none = |percent| format!("'{percent}' is no number of percent");
    let given = percent.map(|percent| percent.parse().map_err(|_| none(percent)));
    let given = given.transpose()?;
    let share = Percent::new(given.unwrap_or(USUAL_PERCENT)).map_err(|error| error.to_string())?;
    match (name, given) {
        ("all", None) => Ok(Source::All),
        ("bounded", None) => Ok(Source::Bounded),
        ("random", _) => Ok(Source::Random(share)),
        ("network", _) => Ok(Source::Network(share)),
        _ => Err("bounded, all, random and network are possible, the last two with a share, such as random:20".to_owned()),
    }
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

/// Gives CUDA where a full installation of torch is named for it, else the processor.
fn usual_device() -> Device {
    match std::env::var_os(TORCH_FOLDER) {
        Some(_) => Device::Cuda,
        None => Device::Cpu,
    }
}

/// A model, and what can run it.
#[derive(Clone, Copy)]
pub struct Network<'a> {
    /// The backend that runs it.
    pub backend: &'a dyn Backend,
    /// Its weights.
    pub model: &'a Model,
    /// The device that it runs on.
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

/// Reads the model of a file, or the one that ships.
pub fn read_model(file: Option<&Path>) -> Outcome<Model> {
    file.map_or_else(Model::shipped, Model::read).or_input()
}

impl ProposalOptions {
    /// Says whether a network may be used.
    pub(crate) fn uses_network(&self) -> bool {
        matches!(self.source, Some(Source::Network(_)))
    }

    /// Reads the model to propose with, where a network may be used.
    pub(crate) fn read_model(&self) -> Outcome<Option<Model>> {
        let read = self
            .uses_network()
            .then(|| read_model(self.model.as_deref()));
        read.transpose()
    }

    /// Gives the network of the model, where there is one.
    pub(crate) fn network<'a>(
        &self,
        backend: &'a dyn Backend,
        model: Option<&'a Model>,
        items: &'a [Arc<Item>],
    ) -> Option<Network<'a>> {
        Some(Network {
            backend,
            model: model?,
            device: usual_device(),
            items,
        })
    }

    /// Gives the source of proposals, where one is named; `model` is what [`Self::read_model`]
    /// gave.
    pub(crate) fn source(&self, grid: &Grid, model: Option<&Model>) -> Option<ProposalSource> {
        Some(match self.source? {
            Source::All => ProposalSource::All,
            Source::Bounded => ProposalSource::Bounded,
            Source::Random(share) => ProposalSource::Random {
                percent: share.percent(),
            },
            Source::Network(share) => {
                let weights = &model?.card().weights_blake3;
                ProposalSource::network(grid, share.percent(), None, PROPOSAL_YAWS, weights)
            }
        })
    }
}
