//! `ppnpack experiment network`: how often a trained network has the optimum among its best-scored placements.

use std::path::PathBuf;

use clap::Args;
use ppnpack_cli::failure::{OrInput, OrRun, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{parse_device, read_model};
use ppnpack_cli::progress;
use ppnpack_dataset::Dataset;
use ppnpack_model::accuracy::{Accuracies, Question};
use ppnpack_model::report::TrainingEvent;
use ppnpack_model::settings::{Device, MeasurementRequest};
use serde::Serialize;

use crate::document::{self, Answer, Document};
use crate::origin;
use crate::shares::{self, PAPER_PERCENT};
use crate::train::ranked;
use crate::workers;

/// Measures on a dataset's test split how often a trained network has the optimum among its best-scored placements, by each
/// of the three questions that `experiment table3` asks.
#[derive(Debug, Args)]
pub(crate) struct NetworkArguments {
    /// The network's weights, a .safetensors file with its .json card beside it [default: those that ship]
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,

    /// The folder that `ppnpack dataset` made
    #[arg(long, value_name = "DIR", default_value = "out/dataset")]
    dataset: PathBuf,

    /// Where the network runs
    #[arg(long, value_parser = parse_device(), default_value = "cpu")]
    device: Device,

    /// Threads on the processor [default: one per core]
    #[arg(long, value_name = "COUNT")]
    threads: Option<usize>,

    /// Where report.html, network.md and network.json are written
    #[arg(long, value_name = "DIR", default_value = "out/network")]
    out: PathBuf,

    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Results {
    machine: String,
    version: &'static str,
    /// The hash of its weights.
    model: String,
    parameters: u64,
    test: Accuracies,
}

pub(crate) fn run(arguments: &NetworkArguments, backend: &dyn Backend) -> Outcome {
    // What is wrong with the dataset is the fault of who names it, not of the measurement.
    Dataset::open(&arguments.dataset).or_input()?;
    let model = read_model(arguments.model.as_deref())?;
    let request = MeasurementRequest {
        dataset: arguments.dataset.clone(),
        device: arguments.device,
        threads: arguments.threads.unwrap_or_else(workers::default_count),
    };
    let bar = progress::bar("Reading the dataset", 0);
    let test = backend.measure(&model, &request, &mut |event| {
        if let TrainingEvent::Reading { done, total } = event {
            bar.set_length(total as u64);
            bar.set_position(done as u64);
        }
    });
    bar.finish_and_clear();
    let card = model.card();
    let results = Results {
        machine: origin::machine(),
        version: env!("CARGO_PKG_VERSION"),
        model: card.weights_blake3.clone(),
        parameters: card.parameters,
        test: test.or_run()?,
    };
    draw(arguments, &results)?;
    let document = Document {
        name: "network",
        answer: Answer {
            question: "How often is the optimum among what a network scores best?",
            text: answer(&results),
            picture: "network.svg".to_owned(),
        },
        results: &results,
        asked: arguments,
        measured: &["test"],
        markdown: markdown(&results),
    };
    document.publish(&arguments.out, arguments.json)
}

fn draw(arguments: &NetworkArguments, results: &Results) -> Outcome {
    let percents = shares::percent(&[&results.test], Question::OverAll);
    let at_shares = shares::SHARES.iter().zip(percents);
    let bars = at_shares.map(|(share, mean)| (format!("K = {share} %"), mean.mean));
    let titles = [
        "Optimum among the best-scored K % of all placements",
        "Test candidates (%)",
    ];
    document::bars(&arguments.out, "network", titles, bars)
}

/// How often it is at the smallest share.
fn answer(results: &Results) -> String {
    let percents = shares::percent(&[&results.test], Question::OverAll);
    let first = percents.first().copied().unwrap_or_default();
    let [share, ..] = shares::SHARES;
    let [paper, ..] = PAPER_PERCENT;
    format!(
        "The optimum is among the best-scored {share} % of all placements for {} % of {} test candidates; the paper's network, on its \
         own data: {paper:.1} %.",
        first.shown(1),
        results.test.candidates
    )
}

fn markdown(results: &Results) -> String {
    let test = &results.test;
    let mut text = format!(
        "# How often a network has the optimum among its best-scored placements\n\n{} parameters, on {} candidates of {} test \
         sequences, where {:.1} % of all placements fit. Intervals are 95 % over the sequences. In brackets the paper's \
         network, on its own data. Machine: {}.\n\n| the optimum is |{}\n|---|---|---|---|---|---|\n",
        results.parameters,
        test.candidates,
        test.sequences,
        100.0 * test.fitting_share,
        results.machine,
        shares::head()
    );
    for question in Question::ALL {
        let paper: &[f64] = match question {
            Question::OverAll => &PAPER_PERCENT,
            Question::Proposed | Question::AmongFitting => &[],
        };
        let accuracy = shares::percent(&[test], question);
        text += &format!(
            "| {} |{}\n",
            ranked(question),
            shares::cells(&accuracy, paper)
        );
    }
    text
}
