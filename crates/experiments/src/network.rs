//! The network that an experiment compares.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use ppnpack_model::weights::Model;
use ppnpack_packing::coarse::Coarsening;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::item::Item;
use ppnpack_packing::search::SearchSettings;

use ppnpack_cli::failure::{Failure, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{DeviceOption, Network, PROPOSAL_YAWS, ProposalSource, read_model};

/// Which network proposes.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Network")]
pub(crate) struct NetworkOptions {
    /// The network's weights, a .safetensors file with its .json card beside it [default: those that ship]
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,

    /// Where the network runs
    #[arg(long, value_enum, default_value = "cpu")]
    device: DeviceOption,

    /// The share of placements that the network proposes, in percent [default: the paper's: 5, and 20 in its robot cell]
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

    pub(crate) fn percent(&self) -> f64 {
        self.percent.unwrap_or(DEFAULT_PERCENT)
    }

    /// The model; or, where nothing here can run a network, the reason. Files that cannot be used are an error.
    pub(crate) fn find(
        &self,
        backend: &dyn Backend,
        grid: &Grid,
    ) -> Outcome<Result<Model, String>> {
        let model = read_model(self.model.as_deref())?;
        let network = self.of(backend, &model, &[]);
        let not_coarser = Coarsening { cells: 1, yaws: 1 };
        match network.open(
            grid,
            &SearchSettings::default(),
            not_coarser,
            self.percent(),
        ) {
            Ok(_) => Ok(Ok(model)),
            Err(Failure::Run(error)) => {
                let reason = format!("{error:#}");
                tracing::warn!(reason, "comparing without the network");
                Ok(Err(reason))
            }
            Err(error) => Err(error),
        }
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
            device: self.device.into(),
            items,
        }
    }

    /// The network as a source of proposals.
    pub(crate) fn source(&self, grid: &Grid, model: &Model) -> ProposalSource {
        ProposalSource::network(grid, self.percent(), PROPOSAL_YAWS, model)
    }
}
