//! `ppnpack`: packs objects in a simulated cell, shows the result, trains the network and runs the experiments.

mod commands;
mod drawing;
mod failure;
mod fastest;
pub mod launcher;
mod length;
pub mod network;
mod options;
mod output;
mod progress;
mod report;
mod sequence;
mod simulation;
mod stack;
mod workers;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tracing_subscriber::EnvFilter;

use crate::failure::Outcome;
use crate::network::Backend;

/// Packs general objects into a container, one at a time, compactly.
#[derive(Debug, Parser)]
#[command(name = "ppnpack", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Pack one sequence of objects in the simulated cell and report on it
    Pack(Box<commands::pack::PackArguments>),
    /// Run all services in one process, over Zenoh
    Up(Box<commands::up::UpArguments>),
    /// Show which services are alive, and whether they are ready
    Status(commands::status::StatusArguments),
    /// Watch the cells in the terminal
    Watch(commands::watch::WatchArguments),
    /// Send one request to a service by hand
    Call(commands::call::CallArguments),
    /// Reproduce the paper's tables and test the engine's models
    Experiment(Box<commands::experiment::ExperimentArguments>),
    /// Make training data for placement proposal networks
    Dataset(Box<commands::dataset::DatasetArguments>),
    /// Train a placement proposal network
    Train(Box<commands::train::TrainArguments>),
    /// Look at the objects of a folder or of the built-in set
    Catalogue(commands::catalogue::CatalogueArguments),
    /// Make a heightmap of point cloud files
    Perceive(commands::perceive::PerceiveArguments),
    /// Say which objects lie in a point cloud file, and how
    Recognise(Box<commands::recognise::RecogniseArguments>),
    /// Find the container's pose and size in a cloud of it empty
    Calibrate(commands::calibrate::CalibrateArguments),
    /// Evaluate one object on one container at every offset
    Evaluate(commands::evaluate::EvaluateArguments),
}

/// Runs the command line of this process; `backend` provides what needs libtorch.
pub fn main(backend: &dyn Backend) -> ExitCode {
    // Wrong use ends here, with exit code 2.
    let arguments = Arguments::parse();
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .init();
    match run(&arguments.command, backend) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("ppnpack: {failure}");
            failure.exit_code()
        }
    }
}

fn run(command: &Command, backend: &dyn Backend) -> Outcome {
    match command {
        Command::Pack(arguments) => commands::pack::run(arguments, backend),
        Command::Up(arguments) => commands::up::run(arguments, backend),
        Command::Status(arguments) => commands::status::run(arguments),
        Command::Watch(arguments) => commands::watch::run(arguments),
        Command::Call(arguments) => commands::call::run(arguments),
        Command::Experiment(arguments) => commands::experiment::run(arguments, backend),
        Command::Dataset(arguments) => commands::dataset::run(arguments),
        Command::Train(arguments) => {
            backend.prepare();
            commands::train::run(arguments, backend)
        }
        Command::Catalogue(arguments) => commands::catalogue::run(arguments),
        Command::Perceive(arguments) => commands::perceive::run(arguments),
        Command::Recognise(arguments) => commands::recognise::run(arguments),
        Command::Calibrate(arguments) => commands::calibrate::run(arguments),
        Command::Evaluate(arguments) => commands::evaluate::run(arguments),
    }
}
