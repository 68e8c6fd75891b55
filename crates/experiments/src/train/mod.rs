//! `ppnpack train`: trains a placement proposal network.

mod options;

use std::path::PathBuf;

use clap::Args;
use ppnpack_dataset::Dataset;
use ppnpack_files::write_whole;
use ppnpack_model::accuracy::{Accuracy, Question};
use ppnpack_model::card::ModelCard;
use ppnpack_model::report::{EpochReport, TrainingEvent};
use ppnpack_model::settings::TrainingRequest;

use ppnpack_cli::failure::{OrInput, OrRun, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::output::{print_json, print_line};
use ppnpack_cli::progress;

use options::{NetworkOptions, TrainingOptions};

/// Trains a network on a dataset; leaves weights, card, epochs and a checkpoint.
#[derive(Debug, Args)]
pub struct TrainArguments {
    /// The folder that `ppnpack dataset` made
    #[arg(long, value_name = "DIR", default_value = "out/dataset")]
    dataset: PathBuf,

    /// Folder of the model and the checkpoint
    #[arg(long, value_name = "DIR", default_value = "out/train")]
    out: PathBuf,

    /// Go on from the checkpoint in --out
    #[arg(long)]
    resume: bool,

    #[command(flatten)]
    network: NetworkOptions,

    #[command(flatten)]
    training: TrainingOptions,

    /// Do not look at the test split at the end: for trainings among which validation is to choose
    #[arg(long)]
    no_test: bool,

    /// Print the model card as JSON
    #[arg(long)]
    json: bool,
}

impl TrainArguments {
    fn request(&self) -> Outcome<TrainingRequest> {
        Ok(TrainingRequest {
            dataset: self.dataset.clone(),
            folder: self.out.clone(),
            settings: self.training.settings(&self.network)?,
            device: self.training.device,
            threads: self.training.threads(),
            resume: self.resume,
            look_at_test: !self.no_test,
        })
    }
}

pub(crate) fn run(arguments: &TrainArguments, backend: &dyn Backend) -> Outcome {
    let card = train(&arguments.request()?, backend)?;
    if arguments.json {
        print_json(&card)?;
    } else {
        print_line(&format!(
            "{} parameters, trained in {:.0} s; the weights are those of epoch {}",
            card.parameters, card.training_s, card.epoch
        ))?;
        for line in summary(&card) {
            print_line(&line)?;
        }
        print_line(&format!("Written to {}", arguments.out.display()))?;
    }
    Ok(())
}

/// Gives the accuracies on the test split, by every question.
fn summary(card: &ModelCard) -> Vec<String> {
    let Some(test) = &card.test else {
        return Vec::new();
    };
    let fitting = format!("{:.1} % of all placements fit", 100.0 * test.fitting_share);
    let answers = Question::ALL.map(|question| {
        let answers = shares(test.of(question));
        format!("optimum {}: {answers}", ranked(question))
    });
    let head = format!(
        "On {} candidates of {} test sequences:",
        test.candidates, test.sequences
    );
    [head, fitting].into_iter().chain(answers).collect()
}

fn ranked(question: Question) -> &'static str {
    match question {
        Question::Proposed => "among the best-scored that fit, as many as K % of all placements",
        Question::OverAll => "among the best-scored K % of all placements",
        Question::AmongFitting => "among the best-scored K % of those that fit",
    }
}

/// Trains with progress on standard error; what the epochs came to is kept after each.
fn train(request: &TrainingRequest, backend: &dyn Backend) -> Outcome<ModelCard> {
    // What is wrong with the dataset is the fault of who names it, not of the training.
    Dataset::open(&request.dataset).or_input()?;
    let bar = progress::bar("Reading the dataset", 0);
    let question = Question::of_loss(request.settings.loss_over);
    let mut epochs: Vec<EpochReport> = Vec::new();
    let mut kept = Ok(());
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
            bar.suspend(|| eprintln!("{}", line(&report, question)));
            epochs.push(report);
            kept = serde_json::to_vec_pretty(&epochs)
                .or_run()
                .and_then(|epochs| Ok(write_whole(&request.folder.join("epochs.json"), &epochs)?));
        }
    });
    bar.finish_and_clear();
    let card = card.or_run()?;
    kept?;
    Ok(card)
}

fn line(report: &EpochReport, question: Question) -> String {
    let validation = report.validation.as_ref().map(|validation| {
        format!(
            ", validation loss {:.4}, optimum {}: {}",
            validation.loss,
            ranked(question),
            shares(validation.accuracies.of(question)),
        )
    });
    format!(
        "epoch {}: loss {:.4}{}; {:.0} s, {:.0} % waiting for data",
        report.epoch,
        report.training_loss,
        validation.unwrap_or_default(),
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
