//! `ppnpack experiment table3`: how often the optimum is among the best-scored placements, and what that owes to.

use std::path::PathBuf;

use clap::Args;
use ppnpack_model::architecture::{Architecture, Fusion};
use ppnpack_model::card::ModelCard;
use ppnpack_model::settings::{Loss, TrainingRequest, TrainingSettings};
use serde::Serialize;

use crate::document;
use crate::shares::{self, SHARES};
use crate::statistics::Mean;
use crate::train::{RunOptions, train};
use ppnpack_cli::failure::Outcome;
use ppnpack_cli::network::Backend;

/// Trains the network and its ablations in the same way, and compares their accuracy on the test split.
#[derive(Debug, Args)]
pub(crate) struct Table3Arguments {
    /// The folder that `ppnpack dataset --values` made
    #[arg(long, value_name = "DIR", default_value = "out/dataset")]
    dataset: PathBuf,

    /// Passes over the training split, for each network
    #[arg(long, value_name = "COUNT", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    epochs: u32,

    #[command(flatten)]
    training: RunOptions,

    /// Where table3.md, table3.json, table3.svg and the trained networks are written; a killed run goes on there
    #[arg(long, value_name = "DIR", default_value = "out/table3")]
    out: PathBuf,

    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
}

struct Variant {
    name: &'static str,
    key: &'static str,
    loss: Loss,
    fusion: Fusion,
    resting_heights: bool,
    /// Table III of the paper, in percent at the shares of [`SHARES`].
    paper: Option<[f64; 5]>,
}

const FULL: Variant = Variant {
    name: "full",
    key: "full",
    loss: Loss::Ranking,
    fusion: Fusion::Correlation,
    resting_heights: true,
    paper: None,
};

const HEIGHTMAPS: Variant = Variant {
    name: "heightmaps alone (the paper's inputs)",
    key: "heightmaps",
    resting_heights: false,
    paper: Some([81.0, 94.9, 97.2, 98.0, 99.4]),
    ..FULL
};

const NO_RANKING: Variant = Variant {
    name: "heightmaps alone, without ranking",
    key: "no-ranking",
    loss: Loss::Mse,
    paper: Some([62.1, 72.9, 77.0, 79.2, 86.1]),
    ..HEIGHTMAPS
};

const NO_CORRELATION: Variant = Variant {
    name: "heightmaps alone, without ranking and correlation",
    key: "no-ranking-no-correlation",
    fusion: Fusion::Concatenation,
    paper: Some([57.9, 66.9, 70.2, 72.5, 80.8]),
    ..NO_RANKING
};

/// Each but the first lacks one thing more.
const VARIANTS: [Variant; 4] = [FULL, HEIGHTMAPS, NO_RANKING, NO_CORRELATION];

#[derive(Debug, Serialize)]
struct Line {
    network: &'static str,
    card: ModelCard,
    /// In percent, at the shares of the card's accuracy.
    accuracy_percent: Vec<Mean>,
    #[serde(skip_serializing_if = "Option::is_none")]
    paper_percent: Option<[f64; 5]>,
}

#[derive(Debug, Serialize)]
struct Results {
    machine: String,
    shares_percent: [f64; 5],
    lines: Vec<Line>,
}

pub(crate) fn run(arguments: &Table3Arguments, backend: &dyn Backend) -> Outcome {
    let mut lines = Vec::new();
    for variant in &VARIANTS {
        eprintln!("{}:", variant.name);
        let card = train(&request(arguments, variant), backend)?;
        lines.push(line(variant, card));
    }
    let results = Results {
        machine: document::machine(),
        shares_percent: SHARES,
        lines,
    };
    let folder = &arguments.out;
    let lines = results.lines.iter();
    shares::draw(
        (folder, "table3"),
        "Optimum among the best-scored K %",
        "Test candidates",
        lines.map(|line| (line.network, &line.accuracy_percent)),
    )?;
    let markdown = markdown(&results);
    document::publish(folder, "table3", &results, &markdown, arguments.json)
}

/// A training goes on from its own checkpoint; one that is finished is not repeated.
fn request(arguments: &Table3Arguments, variant: &Variant) -> TrainingRequest {
    TrainingRequest {
        dataset: arguments.dataset.clone(),
        folder: arguments.out.join("networks").join(variant.key),
        settings: TrainingSettings {
            architecture: Architecture {
                fusion: variant.fusion,
                resting_heights: variant.resting_heights,
                ..Architecture::default()
            },
            loss: variant.loss,
            epochs: arguments.epochs as usize,
            seed: arguments.training.seed,
            sequences: arguments.training.sequences,
            ..TrainingSettings::default()
        },
        device: arguments.training.device,
        threads: arguments.training.threads(),
        resume: true,
    }
}

fn line(variant: &Variant, card: ModelCard) -> Line {
    let count = card.data.test_candidates as usize;
    let of_share = |share| Mean::of_share(share, count).scaled(100.0);
    let accuracy = card.accuracy.iter();
    let accuracy_percent = accuracy.map(|accuracy| of_share(accuracy.share));
    Line {
        network: variant.name,
        accuracy_percent: accuracy_percent.collect(),
        paper_percent: variant.paper,
        card,
    }
}

fn markdown(results: &Results) -> String {
    let mut text = "# Table 3: how often the optimum is among the best-scored K %\n\n".to_owned();
    if let Some(Line { card, .. }) = results.lines.first() {
        let sequences = card.training.sequences.map_or_else(
            || "the training split".to_owned(),
            |count| format!("{count} sequences of the training split"),
        );
        text += &format!(
            "Each network is trained alike: {sequences}, {} epochs of {} candidates, batches of {} steps, seed {}. \
             Accuracy on {} candidates of the test split (one in ten sequences); intervals are 95 % and take candidates \
             as independent, although those of a sequence are alike. In brackets the paper's Table III, whose network \
             is wider and was trained on its own data. Machine: {}.\n\n",
            card.epoch,
            card.data.training_candidates,
            card.training.batch,
            card.training.seed,
            card.data.test_candidates,
            results.machine,
        );
    }
    text += &format!("| network |{} parameters | training |\n", shares::head());
    text += "|---|---|---|---|---|---|---|---|\n";
    for line in &results.lines {
        text += &format!("| {} |", line.network);
        for (index, accuracy) in line.accuracy_percent.iter().enumerate() {
            text += &format!(" {}", accuracy.shown(1));
            if let Some(paper) = line.paper_percent.and_then(|it| it.get(index).copied()) {
                text += &format!(" [{paper:.1}]");
            }
            text += " |";
        }
        let Line { card, .. } = line;
        text += &format!(" {} | {:.0} s |\n", card.parameters, card.training_s);
    }
    text + "\n![Accuracy against K](table3.svg)\n"
}
