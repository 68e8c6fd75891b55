//! `ppnpack experiment`: the paper's tables, and tests of the engine's models.

use clap::{Args, Subcommand};
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;

use crate::{boxes, filling, loads, pareto, physical, stream, tables, value};

/// Reproduce the paper's tables and test the engine's models.
#[derive(Debug, Args)]
pub struct ExperimentArguments {
    #[command(subcommand)]
    experiment: Experiment,
}

#[derive(Debug, Subcommand)]
enum Experiment {
    /// Packing heuristics compared: compactness, volume, items, decision time (the paper's Table I)
    Table1(tables::Table1Arguments),
    /// Objects of regular and of irregular shape (the paper's Table II; its objects are
    /// unpublished)
    Table2(tables::Table2Arguments),
    /// Objects that the network was not trained on (Table IV of the paper)
    Table4(tables::Table4Arguments),
    /// Boxes packed one by one into a bin of 10 x 10 x 10, beside published results
    Boxes(boxes::BoxesArguments),
    /// Decision time against packed volume, for every way to propose placements, on several grids
    Pareto(pareto::ParetoArguments),
    /// Volume and unsteadiness, with placements tried in a simulation, resting poses, setting aside
    Filling(filling::FillingArguments),
    /// Volume in containers packed from one stream, with one and with several open at a time
    Stream(Box<stream::StreamArguments>),
    /// Loads of items measured in the cell, against limits and estimates, for several margins
    Loads(loads::LoadsArguments),
    /// The value of what a placement leaves, learned from packings on sequences that no table uses
    Value(value::ValueArguments),
    /// The paper's robot cell, simulated with its sensors: a tray, an arm, recognition, noise
    Physical(physical::PhysicalArguments),
}

pub(crate) fn run(arguments: &ExperimentArguments, backend: &dyn Backend) -> Outcome {
    let prepared = || {
        backend.prepare();
        backend
    };
    match &arguments.experiment {
        Experiment::Table1(arguments) => tables::table1(arguments, prepared()),
        Experiment::Table2(arguments) => tables::table2(arguments, prepared()),
        Experiment::Table4(arguments) => tables::table4(arguments, prepared()),
        Experiment::Boxes(arguments) => boxes::run(arguments),
        Experiment::Pareto(arguments) => pareto::run(arguments, prepared()),
        Experiment::Filling(arguments) => filling::run(arguments),
        Experiment::Stream(arguments) => stream::run(arguments),
        Experiment::Loads(arguments) => loads::run(arguments),
        Experiment::Value(arguments) => value::run(arguments),
        Experiment::Physical(arguments) => physical::run(arguments, prepared()),
    }
}
