//! `ppnpack train`: trains a placement proposal network.

use std::path::PathBuf;

use clap::Args;
use ppnpack_chart::{Curve, Lines};
use ppnpack_model::architecture::{Architecture, Fusion, Normalisation};
use ppnpack_model::card::{Accuracy, ModelCard};
use ppnpack_model::report::{EpochReport, TrainingEvent};
use ppnpack_model::settings::{Device, Loss, TrainingRequest, TrainingSettings};

use ppnpack_cli::failure::{OrInput, OrRun, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{Choice, one_of, parse_device, positive};
use ppnpack_cli::output::{print_json, print_line};
use ppnpack_cli::progress;
use ppnpack_files::write_whole;

use crate::{document, workers};

/// Trains a network on a dataset; leaves weights, model card, curves and a checkpoint.
#[derive(Debug, Args)]
pub struct TrainArguments {
    /// The folder that `ppnpack dataset` made
    #[arg(long, value_name = "DIR", default_value = "out/dataset")]
    dataset: PathBuf,

    /// Where the model and the checkpoint are written
    #[arg(long, value_name = "DIR", default_value = "out/train")]
    out: PathBuf,

    /// Go on from the checkpoint in --out
    #[arg(long)]
    resume: bool,

    #[command(flatten)]
    network: NetworkOptions,

    #[command(flatten)]
    training: TrainingOptions,

    /// Print the model card as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Network")]
struct NetworkOptions {
    /// Channels of the encoder blocks, from the finest; each block halves the resolution
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

    /// How the features of container and item meet
    #[arg(long, value_parser = one_of(&FUSIONS), default_value = "correlation")]
    fusion: Fusion,

    /// How activations are normalised
    #[arg(long, value_parser = one_of(&NORMALISATIONS), default_value = "batch")]
    normalisation: Normalisation,

    /// Leave out the exact resting heights: the network of the paper sees heightmaps alone
    #[arg(long)]
    no_resting_heights: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Training")]
struct TrainingOptions {
    /// What is minimised
    #[arg(long, value_parser = one_of(&LOSSES), default_value = "ranking")]
    loss: Loss,

    /// Passes over the training split
    #[arg(long, value_name = "COUNT", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    epochs: u32,

    /// Packing steps per batch
    #[arg(long, value_name = "COUNT", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    batch: u32,

    /// The learning rate at its peak
    #[arg(long, value_name = "RATE", default_value_t = 2e-3, value_parser = positive)]
    learning_rate: f64,

    /// AdamW's decay of the weights
    #[arg(long, value_name = "DECAY", default_value_t = 1e-2)]
    weight_decay: f64,

    /// The margin of the ranking loss within a yaw
    #[arg(long, value_name = "SCORE", default_value_t = 1.0, value_parser = positive)]
    margin: f64,

    /// Train on the data as recorded, without mirror images and quarter turns
    #[arg(long)]
    no_augment: bool,

    #[command(flatten)]
    run: RunOptions,
}

/// What every training is told.
#[derive(Debug, Args)]
pub(crate) struct RunOptions {
    /// Use only so many sequences of the training split
    #[arg(long, value_name = "COUNT")]
    pub(crate) sequences: Option<usize>,

    /// Seeds the initial weights and the order of the data
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    pub(crate) seed: u64,

    /// Where to train
    #[arg(long, value_parser = parse_device(), default_value = "cpu")]
    pub(crate) device: Device,

    /// Threads on the processor [default: one per core]
    #[arg(long, value_name = "COUNT")]
    threads: Option<usize>,
}

impl RunOptions {
    pub(crate) fn threads(&self) -> usize {
        self.threads.unwrap_or_else(workers::default_count)
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

const NORMALISATIONS: [Choice<Normalisation>; 2] = [
    ("batch", Normalisation::Batch, "Over the batch"),
    ("none", Normalisation::None, "Not at all"),
];

const LOSSES: [Choice<Loss>; 2] = [
    ("ranking", Loss::Ranking, "The optima rank above the rest"),
    (
        "mse",
        Loss::Mse,
        "Regression to the heuristic's values; needs a dataset made with --values",
    ),
];

impl TrainArguments {
    fn request(&self) -> Outcome<TrainingRequest> {
        let (network, training) = (&self.network, &self.training);
        let architecture = Architecture {
            widths: network.widths.clone(),
            head: network.head,
            fusion: network.fusion,
            normalisation: network.normalisation,
            resting_heights: !network.no_resting_heights,
        };
        architecture.validate().or_input()?;
        Ok(TrainingRequest {
            dataset: self.dataset.clone(),
            folder: self.out.clone(),
            settings: TrainingSettings {
                architecture,
                loss: training.loss,
                epochs: training.epochs as usize,
                batch: training.batch as usize,
                learning_rate: training.learning_rate,
                weight_decay: training.weight_decay,
                margin: training.margin,
                augment: !training.no_augment,
                seed: training.run.seed,
                sequences: training.run.sequences,
            },
            device: training.run.device,
            threads: training.run.threads(),
            resume: self.resume,
        })
    }
}

pub(crate) fn run(arguments: &TrainArguments, backend: &dyn Backend) -> Outcome {
    let card = train(&arguments.request()?, backend)?;
    if arguments.json {
        print_json(&card)?;
    } else {
        print_line(&format!(
            "{} parameters, {} epochs in {:.0} s; optimum among the top {}",
            card.parameters,
            card.epoch,
            card.training_s,
            shares(&card.accuracy)
        ))?;
        print_line(&format!("Written to {}", arguments.out.display()))?;
    }
    Ok(())
}

/// Trains with progress on standard error; the curves are drawn again after each epoch.
pub(crate) fn train(request: &TrainingRequest, backend: &dyn Backend) -> Outcome<ModelCard> {
    let bar = progress::bar("Reading the dataset", 0);
    let mut epochs: Vec<EpochReport> = Vec::new();
    let mut drawn = Ok(());
    let card = backend.train(request, &mut |event| match event {
        TrainingEvent::Reading { done, total } => {
            bar.set_length(total as u64);
            bar.set_position(done as u64);
        }
        TrainingEvent::Batch { done, total, loss } => {
            bar.set_length(total);
            bar.set_position(done);
            bar.set_message(format!("Training, loss {loss:.4}"));
        }
        TrainingEvent::Epoch(report) => {
            bar.suspend(|| eprintln!("{}", line(&report)));
            epochs.push(report);
            drawn = draw(request, &epochs);
        }
    });
    bar.finish_and_clear();
    let card = card.or_run()?;
    drawn?;
    Ok(card)
}

fn line(report: &EpochReport) -> String {
    format!(
        "epoch {}: loss {:.4}, test loss {:.4}, optimum among the top {}; {:.0} s, {:.0} % waiting for data",
        report.epoch,
        report.training_loss,
        report.test_loss,
        shares(&report.accuracy),
        report.training_s,
        100.0 * report.waiting_share
    )
}

/// Accuracies in words: `1 %: 80.0 %, ...`.
fn shares(accuracy: &[Accuracy]) -> String {
    let shares = accuracy.iter();
    let shares = shares.map(|it| format!("{} %: {:.1} %", it.percent, 100.0 * it.share));
    shares.collect::<Vec<_>>().join(", ")
}

/// Draws the curves of loss and accuracy.
fn draw(request: &TrainingRequest, epochs: &[EpochReport]) -> Outcome {
    let curve = |name: String, value: &dyn Fn(&EpochReport) -> f64| Curve {
        name,
        points: epochs
            .iter()
            .map(|report| [report.epoch as f64, value(report)])
            .collect(),
    };
    let losses = vec![
        curve("training".to_owned(), &|report| report.training_loss),
        curve("test".to_owned(), &|report| report.test_loss),
    ];
    let first = epochs.first().map_or(&[][..], |report| &report.accuracy);
    let accuracies = first.iter().enumerate().map(|(index, accuracy)| {
        curve(format!("K = {} %", accuracy.percent), &|report| {
            let accuracy = report.accuracy.get(index);
            accuracy.map_or(0.0, |accuracy| 100.0 * accuracy.share)
        })
    });
    let accuracies: Vec<Curve> = accuracies.collect();
    let optimum = "Optimum among the best-scored K %";
    for (name, title, y_label, curves) in [
        ("loss", "Loss", "Loss", losses),
        ("accuracy", optimum, "Test candidates (%)", accuracies),
    ] {
        let chart = Lines {
            title: title.to_owned(),
            x_label: "Epoch".to_owned(),
            y_label: y_label.to_owned(),
            curves,
        };
        document::figure(&request.folder, name, chart.to_svg([800, 500]))?;
    }
    let history = serde_json::to_vec_pretty(epochs).or_run()?;
    Ok(write_whole(&request.folder.join("epochs.json"), &history)?)
}
