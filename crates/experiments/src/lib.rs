//! The commands that make and measure: training data, networks, the paper's tables.
//!
//! They are commands of `ppnpack`, which runs this crate's program: [`ppnpack_cli::launcher`].
//!
//! ```no_run
//! use ppnpack_cli::launcher::Launcher;
//! use ppnpack_experiments::Experiments;
//!
//! fn main() -> std::process::ExitCode {
//!     ppnpack_cli::main::<Experiments>(&Launcher::default())
//! }
//! ```

mod apart;
mod boxes;
mod cases;
mod comparison;
mod dataset;
mod experiment;
mod filling;
mod loads;
mod network;
mod origin;
mod packer;
mod pareto;
mod physical;
mod results;
mod runs;
mod stream;
mod tables;
mod train;
mod value;
mod way;
mod workers;

use clap::Subcommand;
use ppnpack_cli::Commands;
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;

pub use dataset::DatasetArguments;
pub use experiment::ExperimentArguments;
pub use train::TrainArguments;

/// The commands of this crate.
#[derive(Debug, Subcommand)]
pub enum Experiments {
    /// Reproduce the paper's tables and test the engine's models
    Experiment(Box<ExperimentArguments>),
    /// Make training data for placement proposal networks
    Dataset(Box<DatasetArguments>),
    /// Train a placement proposal network
    Train(Box<TrainArguments>),
}

impl Commands for Experiments {
    fn run(&self, backend: &dyn Backend) -> Outcome {
        match self {
            Self::Experiment(arguments) => experiment::run(arguments, backend),
            Self::Dataset(arguments) => dataset::run(arguments),
            Self::Train(arguments) => {
                backend.prepare();
                train::run(arguments, backend)
            }
        }
    }
}
