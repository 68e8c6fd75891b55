//! What `experiment tune` is asked for.

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::failure::{Failure, OrInput, Outcome};
use ppnpack_cli::options::{CatalogueOptions, GridOptions, Objective};
use ppnpack_numbers::within;

use super::results::Settings;
use crate::runs::RunsOption;
use crate::workers;

/// The sequences before this one are the tests': what is tuned is measured on them.
const FIRST_FOR_TUNING: u32 = 100;

/// Packs sequences in robot conditions with ever better weights of the objective.
#[derive(Debug, Args)]
pub(crate) struct TuneArguments {
    #[command(flatten)]
    pub(super) catalogue: CatalogueOptions,

    #[command(flatten)]
    pub(super) grid: GridOptions,

    /// A .npy file of sequences, int64 [sequences, length], of object indices
    #[arg(long, value_name = "FILE")]
    pub(super) sequences: PathBuf,

    /// The first sequence; 0 to 99 are the tests'
    #[arg(long, value_name = "NUMBER", default_value_t = 1000)]
    pub(super) first: u32,

    /// How many sequences
    #[arg(long, value_name = "COUNT", default_value_t = 96, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) cases: u32,

    /// The weights to tune, by name
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "top_height,distance,balance,box_share"
    )]
    pub(super) weights: Vec<String>,

    /// The weights to start from, which the others are compared with
    #[arg(long, value_enum, default_value_t)]
    pub(super) start: Objective,

    /// How many items may be set aside
    #[arg(long, value_name = "COUNT", default_value_t = 0)]
    pub(super) set_aside: usize,

    /// How many generations of candidates are tried
    #[arg(long, value_name = "COUNT", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(super) generations: u32,

    /// How many candidates a generation has
    #[arg(long, value_name = "COUNT", default_value_t = 8, value_parser = clap::value_parser!(u32).range(4..=1000))]
    pub(super) population: u32,

    /// How many placements may be unsteady, in percent; each percent more costs 2 % of volume
    #[arg(long, value_name = "PERCENT", default_value_t = 2.0)]
    pub(super) unsteady_limit: f64,

    /// The seed of the candidates
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    pub(super) seed: u64,

    /// Sequences packed at once, by default one per core
    #[arg(long, value_name = "COUNT", default_value_t = workers::default_count())]
    pub(super) workers: usize,

    /// Where report.html, tune.md, tune.json and methods.json are written
    #[arg(long, value_name = "DIR", default_value = "out/tune")]
    pub(super) out: PathBuf,

    #[command(flatten)]
    pub(super) runs: RunsOption,

    /// Print the results as JSON instead of tables
    #[arg(long)]
    pub(super) json: bool,
}

impl TuneArguments {
    /// Checks what the parser cannot.
    pub(super) fn validate(&self) -> Outcome {
        if self.first < FIRST_FOR_TUNING {
            return Err(Failure::input(format_args!(
                "--first {}: sequences 0 to {} are the tests', which nothing may be tuned on; give {FIRST_FOR_TUNING} or more",
                self.first,
                FIRST_FOR_TUNING - 1
            )));
        }
        let percent = within("0 to 100", 0.0..=100.0);
        percent("--unsteady-limit", self.unsteady_limit).or_input()
    }

    /// What the results follow from.
    pub(super) fn settings(&self) -> Settings {
        Settings {
            start: self.start,
            weights: self.weights.clone(),
            first_case: self.first,
            cases: self.cases,
            population: self.population,
            unsteady_limit_percent: self.unsteady_limit,
            seed: self.seed,
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use ppnpack_packing::objective::Weights;

    use super::super::space::Space;
    use super::*;

    #[derive(Debug, Parser)]
    struct Command {
        #[command(flatten)]
        arguments: TuneArguments,
    }

    fn arguments(more: &[&str]) -> TuneArguments {
        let words = ["tune", "--sequences", "sequences.npy"];
        let words = words.iter().chain(more).copied();
        Command::try_parse_from(words).unwrap().arguments
    }

    #[test]
    fn the_defaults_are_possible() {
        let arguments = arguments(&[]);
        arguments.validate().unwrap();
        assert_eq!(arguments.start.weights(), Weights::default());
        let space = Space::new(arguments.start.weights(), &arguments.weights).unwrap();
        assert_eq!(space.start_point().len(), 4);
        assert_eq!(arguments.catalogue.settings().poses, 1);
    }

    #[test]
    fn the_tests_sequences_are_refused() {
        let refused = |first| {
            let arguments = arguments(&["--first", first]);
            arguments.validate().map_err(|failure| failure.to_string())
        };
        for first in ["0", "99"] {
            let message = refused(first).unwrap_err();
            assert!(message.contains("0 to 99 are the tests'"), "{message}");
        }
        assert_eq!(refused("100"), Ok(()));
    }

    #[test]
    fn a_limit_that_is_no_percentage_is_refused() {
        for limit in ["101", "NaN", "inf"] {
            let arguments = arguments(&["--unsteady-limit", limit]);
            let message = arguments.validate().unwrap_err().to_string();
            assert!(message.contains("--unsteady-limit"), "{message}");
        }
    }

    #[test]
    fn poses_and_start_are_chosen() {
        let arguments = arguments(&["--poses", "4", "--start", "dense"]);
        assert_eq!(arguments.catalogue.settings().poses, 4);
        assert_eq!(arguments.start.weights(), Weights::dense());
    }
}
