//! The options of trainings.

use clap::Args;
use ppnpack_cli::failure::{Failure, OrInput, Outcome};
use ppnpack_cli::options::{Choice, one_of, parse_device, positive};
use ppnpack_model::architecture::{Architecture, Fusion};
use ppnpack_model::settings::{
    Device, Loss, LossOver, MOST_VALIDATION_TENTHS, Schedule, TrainingSettings,
};

use crate::workers;

/// The network to train.
#[derive(Debug, Args)]
#[command(next_help_heading = "Network")]
pub(super) struct NetworkOptions {
    /// Channels of the encoder blocks, from the finest; each block halves the resolution. The paper
    /// has 64,128,256,512
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "8,16,16,16"
    )]
    widths: Vec<usize>,

    /// Channels at the container's resolution
    #[arg(long, value_name = "COUNT", default_value_t = 8)]
    head: usize,

    /// Meeting of the features of container and item
    #[arg(long, value_parser = one_of(&FUSIONS), default_value = "correlation")]
    fusion: Fusion,

    /// Leave out the exact resting heights: the network of the paper sees heightmaps alone
    #[arg(long)]
    no_resting_heights: bool,
}

impl NetworkOptions {
    fn architecture(&self) -> Outcome<Architecture> {
        let architecture = Architecture {
            widths: self.widths.clone(),
            head: self.head,
            fusion: self.fusion,
            resting_heights: !self.no_resting_heights,
        };
        architecture.validate().or_input()?;
        Ok(architecture)
    }
}

/// Training of the network.
#[derive(Debug, Args)]
#[command(next_help_heading = "Training")]
pub(super) struct TrainingOptions {
    /// Loss that is minimised
    #[arg(long, value_parser = one_of(&LOSSES), default_value = "ranking")]
    loss: Loss,

    /// Placements that the loss is over
    #[arg(long, value_parser = one_of(&LOSS_OVERS), default_value = "fitting")]
    loss_over: LossOver,

    /// How much a placement that does not fit counts in --loss-over all, at most 1 [default: 1, as
    /// in the paper]
    #[arg(long, value_name = "WEIGHT", value_parser = misfit_weight)]
    misfit_weight: Option<f64>,

    /// Up to where --loss mse tells values apart, in units of the objective above the optimum
    /// [default: 10]
    #[arg(long, value_name = "VALUE", value_parser = positive, allow_hyphen_values = true)]
    cut_off: Option<f64>,

    /// Passes over the training split
    #[arg(long, value_name = "COUNT", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    epochs: u32,

    /// Packing steps per batch
    #[arg(long, value_name = "COUNT", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    batch: u32,

    /// The learning rate at its peak
    #[arg(long, value_name = "RATE", default_value_t = 2e-3, value_parser = positive)]
    learning_rate: f64,

    /// Change of the learning rate
    #[arg(long, value_parser = one_of(&SCHEDULES), default_value = "cosine")]
    schedule: Schedule,

    /// Use only so many sequences of the training split, after those held out for validation
    #[arg(long, value_name = "COUNT")]
    sequences: Option<usize>,

    /// Tenths of the sequences that are held out of the training split for validation: those whose
    /// number ends in 8, in 7 and so on. They choose the epoch; with 0 it is the last
    #[arg(long, value_name = "TENTHS", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..=i64::from(MOST_VALIDATION_TENTHS)))]
    validation: u32,

    /// Seeds the initial weights and the order of the data
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,

    /// Device to train on
    #[arg(long, value_parser = parse_device(), default_value = "cpu")]
    pub(super) device: Device,

    /// Threads on the processor: of its arithmetic, or, where a GPU trains, of what prepares the
    /// batches [default: one per core]
    #[arg(long, value_name = "COUNT")]
    threads: Option<usize>,
}

impl TrainingOptions {
    pub(super) fn threads(&self) -> usize {
        self.threads.unwrap_or_else(workers::default_count)
    }

    pub(super) fn settings(&self, network: &NetworkOptions) -> Outcome<TrainingSettings> {
        if self.misfit_weight.is_some() && self.loss_over == LossOver::Fitting {
            let what = "--misfit-weight is for --loss-over all: a loss over what fits leaves the others out";
            return Err(Failure::input(what));
        }
        let usual = TrainingSettings::default();
        Ok(TrainingSettings {
            architecture: network.architecture()?,
            loss: self.loss,
            loss_over: self.loss_over,
            misfit_weight: self.misfit_weight.unwrap_or(usual.misfit_weight),
            cut_off: self.cut_off.unwrap_or(usual.cut_off),
            epochs: self.epochs as usize,
            batch: self.batch as usize,
            learning_rate: self.learning_rate,
            schedule: self.schedule,
            sequences: self.sequences,
            validation_tenths: self.validation,
            seed: self.seed,
            ..usual
        })
    }
}

fn misfit_weight(text: &str) -> Result<f64, String> {
    match positive(text) {
        Ok(weight) if weight <= 1.0 => Ok(weight),
        _ => Err("must be a number above 0, 1 at most".to_owned()),
    }
}

const FUSIONS: [Choice<Fusion>; 2] = [
    (
        "correlation",
        Fusion::Correlation,
        "Cross-correlation: the item's features are the kernel",
    ),
    ("concat", Fusion::Concatenation, "Side by side"),
];

const LOSSES: [Choice<Loss>; 2] = [
    ("ranking", Loss::Ranking, "The optima rank above the rest"),
    (
        "mse",
        Loss::Mse,
        "Regression to how far the heuristic's values lie above the optimum; needs a dataset made with --values",
    ),
];

const LOSS_OVERS: [Choice<LossOver>; 2] = [
    (
        "all",
        LossOver::All,
        "All, as in the paper: what does not fit is to be scored worse as well",
    ),
    (
        "fitting",
        LossOver::Fitting,
        "Those that fit: the planner leaves out the others anyhow",
    ),
];

const SCHEDULES: [Choice<Schedule>; 2] = [
    ("constant", Schedule::Constant, "Not at all"),
    (
        "cosine",
        Schedule::WarmUpAndCosine,
        "It rises over the first 3 % of the batches, then falls to 0 as a cosine",
    ),
];
