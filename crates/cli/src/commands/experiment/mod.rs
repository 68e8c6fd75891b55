//! `ppnpack experiment`: the paper's tables, and tests of the engine's models.

mod document;
mod runs;
mod stability;
mod statistics;
mod table1;
mod workers;

use clap::{Args, Subcommand};

use crate::failure::Outcome;

/// Reproduce the paper's tables and test the engine's models.
#[derive(Debug, Args)]
pub(crate) struct ExperimentArguments {
    #[command(subcommand)]
    experiment: Experiment,
}

#[derive(Debug, Subcommand)]
enum Experiment {
    /// Packing heuristics compared: compactness, volume, items and decision time (Table I of the paper)
    Table1(table1::Table1Arguments),
    /// Both stability tests against what the simulated cell does
    Stability(stability::StabilityArguments),
}

pub(crate) fn run(arguments: &ExperimentArguments) -> Outcome {
    match &arguments.experiment {
        Experiment::Table1(arguments) => table1::run(arguments),
        Experiment::Stability(arguments) => stability::run(arguments),
    }
}
