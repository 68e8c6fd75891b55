//! The network that an experiment compares.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use ppnpack_model::settings::Device;
use ppnpack_model::weights::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::planning::method::{OpenNetwork, ProposalSource};
use ppnpack_packing::ranking::proposals::Percent;

use ppnpack_cli::failure::{OrInput, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{Network, PROPOSAL_YAWS, parse_device, read_model};

/// Network that proposes.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub(crate) struct NetworkOptions {
    /// The network's weights, a .safetensors file with its .json card beside it [default: those
    /// that ship]
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,

    /// Device that the network runs on
    #[arg(long, value_parser = parse_device(), default_value = "cpu")]
    device: Device,

    /// The share of placements that the network proposes, in percent [default: the paper's: 5, and
    /// 20 in its robot cell]
    #[arg(long = "k", value_name = "PERCENT", allow_hyphen_values = true)]
    percent: Option<f64>,
}

/// The share that the paper's network proposes in its tables, in percent.
const DEFAULT_PERCENT: f64 = 5.0;

impl NetworkOptions {
    /// The same with another share where none is given, in percent.
    pub(crate) fn with_default(&self, percent: f64) -> Self {
        Self {
            percent: self.percent.or(Some(percent)),
            ..self.clone()
        }
    }

    /// The same with the weights of another file where one is given.
    pub(crate) fn with_file(&self, file: Option<&Path>) -> Self {
        let given = file.map(Path::to_owned);
        Self {
            model: given.or_else(|| self.model.clone()),
            ..self.clone()
        }
    }

    pub(crate) fn percent(&self) -> f64 {
        self.percent.unwrap_or(DEFAULT_PERCENT)
    }

    /// The model, or why nothing here can run a network. Files that cannot be used are an error.
    pub(crate) fn find(
        &self,
        backend: &dyn Backend,
        grid: &Grid,
    ) -> Outcome<Result<Model, String>> {
        let model = read_model(self.model.as_deref())?;
        let network = self.of(backend, &model, &[]);
        let share = Percent::new(self.percent()).or_input()?;
        Ok(match network.open(grid, share, &[]) {
            Ok(_) => Ok(model),
            Err(error) => {
                let reason = format!("{:#}", anyhow::Error::from_boxed(error));
                tracing::warn!(reason, "comparing without the network");
                Err(reason)
            }
        })
    }

    pub(crate) fn of<'a>(
        &self,
        backend: &'a dyn Backend,
        model: &'a Model,
        items: &'a [Arc<Item>],
    ) -> Network<'a> {
        Network {
            backend,
            model,
            device: self.device,
            items,
        }
    }
}

/// The proposals of a model, of so many percent of all placements.
pub(crate) fn source(grid: &Grid, percent: f64, model: &Model) -> ProposalSource {
    let weights = &model.card().weights_blake3;
    ProposalSource::network(grid, percent, None, PROPOSAL_YAWS, weights)
}
