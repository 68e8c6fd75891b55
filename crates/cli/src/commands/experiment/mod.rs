//! `ppnpack experiment`: the paper's tables, and tests of the engine's models.

mod comparison;
mod document;
mod network;
mod pareto;
mod physical;
mod runs;
mod stability;
mod statistics;
mod table1;
mod table3;
mod table4;
mod transfer;

use clap::{Args, Subcommand};

use crate::failure::Outcome;
use crate::network::Backend;

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
    /// How often the network finds the optimum, and what that owes to (Table III of the paper)
    Table3(table3::Table3Arguments),
    /// Objects that the network was not trained on (Table IV of the paper)
    Table4(table4::Table4Arguments),
    /// How often the network finds the optimum on grids that it was not trained on
    Transfer(transfer::TransferArguments),
    /// Decision time against packed volume, for every way to propose placements, on several grids
    Pareto(pareto::ParetoArguments),
    /// The paper's robot cell, simulated with its sensors: a tray, an arm, recognition, noise
    Physical(physical::PhysicalArguments),
    /// Both stability tests against what the simulated cell does
    Stability(stability::StabilityArguments),
}

impl Experiment {
    fn uses_network(&self) -> bool {
        !matches!(self, Self::Stability(_))
    }
}

pub(crate) fn run(arguments: &ExperimentArguments, backend: &dyn Backend) -> Outcome {
    if arguments.experiment.uses_network() {
        backend.prepare();
    }
    match &arguments.experiment {
        Experiment::Table1(arguments) => table1::run(arguments, backend),
        Experiment::Table3(arguments) => table3::run(arguments, backend),
        Experiment::Table4(arguments) => table4::run(arguments, backend),
        Experiment::Transfer(arguments) => transfer::run(arguments, backend),
        Experiment::Pareto(arguments) => pareto::run(arguments, backend),
        Experiment::Physical(arguments) => physical::run(arguments, backend),
        Experiment::Stability(arguments) => stability::run(arguments),
    }
}
