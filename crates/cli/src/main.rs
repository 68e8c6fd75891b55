//! `ppnpack`: packs objects in a simulated cell, shows the result, and runs the experiments.

mod commands;
mod failure;
mod length;
mod options;
mod output;
mod progress;
mod report;
mod sequence;
mod simulation;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tracing_subscriber::EnvFilter;

use crate::failure::Outcome;

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
    /// Reproduce the paper's tables and test the engine's models
    Experiment(Box<commands::experiment::ExperimentArguments>),
    /// Look at the objects of a folder or of the built-in set
    Catalogue(commands::catalogue::CatalogueArguments),
    /// Evaluate one object on one container at every offset
    Evaluate(commands::evaluate::EvaluateArguments),
}

fn main() -> ExitCode {
    // Wrong use ends here, with exit code 2.
    let arguments = Arguments::parse();
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .init();
    match run(&arguments.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("ppnpack: {failure}");
            failure.exit_code()
        }
    }
}

fn run(command: &Command) -> Outcome {
    match command {
        Command::Pack(arguments) => commands::pack::run(arguments),
        Command::Experiment(arguments) => commands::experiment::run(arguments),
        Command::Catalogue(arguments) => commands::catalogue::run(arguments),
        Command::Evaluate(arguments) => commands::evaluate::run(arguments),
    }
}
