//! `ppnpack`: packs objects in a simulated cell and shows the result. The commands of `ppnpack`,
//! and what programs with further commands build on: options, output, sequences, the simulated
//! cell, all services in one process.

mod commands;
pub mod drawing;
pub mod failure;
pub mod launcher;
pub mod network;
pub mod options;
pub mod output;
pub mod progress;
pub mod quantity;
pub mod report;
pub mod sequence;
pub mod stack;
mod text;

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer};

use crate::failure::Outcome;
use crate::network::Backend;

/// Commands that a program has beside those of this crate.
pub trait Commands: Subcommand {
    /// Runs the command; `backend` provides what needs libtorch.
    fn run(&self, backend: &dyn Backend) -> Outcome;
}

/// Packs general objects into a container, one at a time, compactly.
#[derive(Debug, Parser)]
#[command(name = "ppnpack", bin_name = "ppnpack", version, max_term_width = 100)]
struct Arguments<More: Commands> {
    #[command(subcommand)]
    command: Command<More>,
}

#[derive(Debug, Subcommand)]
enum Command<More: Commands> {
    /// Pack one sequence of objects in the simulated cell and report on it
    Pack(Box<commands::pack::PackArguments>),
    /// Find the smallest carton that takes an order whole
    Carton(Box<commands::carton::CartonArguments>),
    /// Run all services in one process, over Zenoh
    Up(Box<commands::up::UpArguments>),
    /// Show which services are alive, and whether they are ready
    Status(commands::status::StatusArguments),
    /// Watch the cells in the terminal
    Watch(commands::watch::WatchArguments),
    /// Send one request to a service by hand
    Call(commands::call::CallArguments),
    /// Serve the cells to Foxglove, as they work
    View(commands::view::ViewArguments),
    /// Record what the cells do, with all that each decision depends on
    Record(commands::record::RecordArguments),
    /// Say what is in a recording
    Inspect(commands::inspect::InspectArguments),
    /// Plan the decisions of a recording again, and compare
    Replay(commands::replay::ReplayArguments),
    #[command(flatten)]
    More(More),
    /// Look at the objects of a folder or of the built-in set
    Catalogue(commands::catalogue::CatalogueArguments),
    /// Make a heightmap of point cloud files
    Perceive(commands::perceive::PerceiveArguments),
    /// Say which objects lie in a point cloud file, and how
    Recognise(Box<commands::recognise::RecogniseArguments>),
    /// Find the container's pose and size in a cloud of it empty
    Calibrate(commands::calibrate::CalibrateArguments),
}

/// Runs the command line of this process; `backend` provides what needs libtorch.
pub fn main<More: Commands>(backend: &dyn Backend) -> ExitCode {
    // Wrong use ends here, with exit code 2.
    let arguments = Arguments::<More>::parse();
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal());
    tracing_subscriber::registry()
        .with(lines.with_filter(filter))
        .init();
    match run(&arguments.command, backend) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("ppnpack: {failure}");
            failure.exit_code()
        }
    }
}

fn run<More: Commands>(command: &Command<More>, backend: &dyn Backend) -> Outcome {
    match command {
        Command::Pack(arguments) => commands::pack::run(arguments, backend),
        Command::Carton(arguments) => commands::carton::run(arguments),
        Command::Up(arguments) => commands::up::run(arguments, backend),
        Command::Status(arguments) => commands::status::run(arguments),
        Command::Watch(arguments) => commands::watch::run(arguments),
        Command::Call(arguments) => commands::call::run(arguments),
        Command::View(arguments) => commands::view::run(arguments),
        Command::Record(arguments) => commands::record::run(arguments),
        Command::Inspect(arguments) => commands::inspect::run(arguments),
        Command::Replay(arguments) => commands::replay::run(arguments),
        Command::More(more) => more.run(backend),
        Command::Catalogue(arguments) => commands::catalogue::run(arguments),
        Command::Perceive(arguments) => commands::perceive::run(arguments),
        Command::Recognise(arguments) => commands::recognise::run(arguments),
        Command::Calibrate(arguments) => commands::calibrate::run(arguments),
    }
}
