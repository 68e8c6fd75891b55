//! `ppnpack experiment table3`: how often the optimum is among the best-scored placements, and what that owes to.
//!
//! Of each network, every cut-off is trained with the first seed; the validation split chooses the one that is trained
//! with the other seeds too. Only what is chosen is measured on the test split.

mod columns;
mod variants;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use ppnpack_cli::failure::{Failure, OrInput, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::{one_of, positive};
use ppnpack_dataset::Dataset;
use ppnpack_model::accuracy::{Accuracies, Question, SHARES_PERCENT};
use ppnpack_model::architecture::Architecture;
use ppnpack_model::card::ModelCard;
use ppnpack_model::settings::{Loss, LossOver, TrainingRequest, TrainingSettings};
use serde::Serialize;

use crate::document::{OutOptions, Page};
use crate::sheet::Lines;
use crate::train::options::{LOSS_OVERS, RunOptions, SizeOptions};
use crate::train::{ranked, train};
use columns::{Trained, answers, sizes};
use variants::{VARIANTS, Variant};

/// Trains the network and its ablations in the same way, and compares their accuracy on the test split.
#[derive(Debug, Args)]
pub(crate) struct Table3Arguments {
    /// The folder that `ppnpack dataset --values` made
    #[arg(long, value_name = "DIR", default_value = "out/dataset")]
    dataset: PathBuf,

    /// Passes over the training split, for each network
    #[arg(long, value_name = "COUNT", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    epochs: u32,

    /// Networks of each row, from --seed on
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: u32,

    /// Which placements the loss is over
    #[arg(long, value_parser = one_of(&LOSS_OVERS), default_value = "all")]
    loss_over: LossOver,

    /// How far above the optimum regression tells values apart, in units of the objective. Of several, validation chooses for each
    /// network
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "10,40", value_parser = positive)]
    cut_off: Vec<f64>,

    #[command(flatten)]
    size: SizeOptions,

    #[command(flatten)]
    training: RunOptions,

    #[command(flatten)]
    out: OutOptions,
}

/// A cut-off, and how good it is on the validation split.
#[derive(Debug, Clone, Serialize)]
struct Tried {
    cut_off: f64,
    validation: Accuracies,
}

pub(crate) fn run(arguments: &Table3Arguments, backend: &dyn Backend) -> Outcome {
    let architecture = arguments.size.architecture()?;
    if arguments.training.validation == 0 && arguments.cut_off.len() > 1 {
        return Err(no_choice());
    }
    has_values(&arguments.dataset)?;
    let mut rows = Vec::new();
    let (mut all_tried, mut chosen, mut cards) = (Vec::new(), Vec::new(), Vec::new());
    for variant in &VARIANTS {
        let plan = Plan {
            arguments,
            variant,
            architecture: &architecture,
        };
        let (tried, cut_off) = plan.choose(backend)?;
        let trained = plan.train(cut_off, backend)?;
        cards.push(
            trained
                .iter()
                .map(|it| it.card.as_ref().clone())
                .collect::<Vec<_>>(),
        );
        rows.push((variant.name.to_owned(), trained));
        all_tried.push(tried);
        chosen.push(cut_off);
    }
    let mut lines = Lines::new("network", rows);
    lines.keep("tried", &all_tried);
    lines.keep("cut_off", &chosen);
    let text = "# Table 3: how often the optimum is among the best-scored K %\n\n".to_owned();
    let mut page = Page::new("table3", text);
    if let Some(card) = cards.first().and_then(|cards| cards.first()) {
        page.say(&head(arguments, card));
    }
    for question in [
        Question::OverAll,
        Question::Proposed,
        Question::AmongFitting,
    ] {
        let mut columns = answers(
            question,
            |trained: &Trained| trained.card.test.as_ref(),
            |trained| trained.variant.paper_percent,
        );
        columns.extend(sizes());
        page.say(&format!(
            "## {}\n\nThe optimum is {}.\n\n{}\n",
            title(question),
            ranked(question),
            lines.table("network", &columns)
        ));
    }
    page.say(&choices(arguments, &all_tried, &chosen));
    lines.keep("cards", cards);
    page.keep("shares_percent", SHARES_PERCENT);
    page.keep("loss_over", arguments.loss_over);
    page.keep("lines", lines);
    page.publish(&arguments.out)
}

fn title(question: Question) -> &'static str {
    match question {
        Question::OverAll => "Over all placements: the paper's question",
        Question::Proposed => {
            "What the planner proposes: it leaves out what does not fit, and K stays a share of all"
        }
        Question::AmongFitting => "Among those that fit",
    }
}

/// What all networks have in common.
fn head(arguments: &Table3Arguments, card: &ModelCard) -> String {
    let training = &card.training;
    let over = match arguments.loss_over {
        LossOver::All => "all placements, as in the paper",
        LossOver::Fitting => "the placements that fit",
    };
    let of_split = |split: &Option<Accuracies>| {
        split.as_ref().map_or("none".to_owned(), |of| {
            format!("{} candidates of {} sequences", of.candidates, of.sequences)
        })
    };
    format!(
        "Each network is trained alike: {} epochs of {} candidates, batches of {} steps, the loss over {over}. Validation ({}) chose \
         the epoch, and the cut-off where several were tried, by the accuracy at the smallest K. The test split ({}) was looked at once, \
         at the end. Accuracies in %, {} networks each, from seed {} on; intervals are 95 % by Student's t over the networks, or over the \
         test sequences where there is one network. In brackets the paper's Table III, whose network is wider and was trained on its own \
         data.\n\n",
        training.epochs,
        card.data.training_candidates,
        training.batch,
        of_split(&card.validation),
        of_split(&card.test),
        arguments.seeds,
        training.seed
    )
}

/// What validation chose among, where it chose.
fn choices(arguments: &Table3Arguments, tried: &[Vec<Tried>], chosen: &[Option<f64>]) -> String {
    let question = Question::of_loss(arguments.loss_over);
    let mut rows = Vec::new();
    for ((variant, tried), chosen) in VARIANTS.iter().zip(tried).zip(chosen) {
        for one in tried {
            let mark = if Some(one.cut_off) == *chosen {
                ", chosen"
            } else {
                ""
            };
            let name = format!("{}, cut off at {}{mark}", variant.name, one.cut_off);
            rows.push((name, vec![one.clone()]));
        }
    }
    if rows.is_empty() {
        return String::new();
    }
    let columns = answers(question, |tried: &Tried| Some(&tried.validation), |_| None);
    format!(
        "## What validation chose\n\nAccuracy on the validation split, {}, with the first seed. What was not chosen was \
         not tested.\n\n{}",
        ranked(question),
        Lines::new("network", rows).table("network", &columns)
    )
}

/// How one row comes about.
struct Plan<'a> {
    arguments: &'a Table3Arguments,
    variant: &'static Variant,
    architecture: &'a Architecture,
}

impl Plan<'_> {
    /// Trains a network with each seed, and tests it.
    fn train(&self, cut_off: Option<f64>, backend: &dyn Backend) -> Outcome<Vec<Trained>> {
        let first = self.arguments.training.seed;
        let seeds = first..first.saturating_add(u64::from(self.arguments.seeds));
        let trained = seeds.map(|seed| {
            eprintln!("{}, seed {seed}:", self.variant.name);
            let card = train(&self.request(cut_off, seed, true), backend)?;
            Ok(Trained {
                variant: self.variant,
                card: Arc::new(card),
            })
        });
        trained.collect()
    }

    /// Trains every cut-off with the first seed, and gives the one that validation chooses; none is tested. Where there is
    /// one alone, or the loss has none, there is nothing to choose.
    fn choose(&self, backend: &dyn Backend) -> Outcome<(Vec<Tried>, Option<f64>)> {
        let cut_offs = match (self.variant.loss, self.arguments.cut_off.as_slice()) {
            (Loss::Ranking, _) => return Ok((Vec::new(), None)),
            (Loss::Mse, [one]) => return Ok((Vec::new(), Some(*one))),
            (Loss::Mse, several) => several,
        };
        let mut tried = Vec::new();
        for cut_off in cut_offs.iter().copied() {
            eprintln!("{}, cut off at {cut_off}, to choose:", self.variant.name);
            let seed = self.arguments.training.seed;
            let card = train(&self.request(Some(cut_off), seed, false), backend)?;
            let validation = card.validation.ok_or_else(no_choice)?;
            tried.push(Tried {
                cut_off,
                validation,
            });
        }
        let question = Question::of_loss(self.arguments.loss_over);
        let chosen = best(&tried, question).ok_or_else(no_choice)?;
        Ok((tried, Some(chosen)))
    }

    /// A training goes on from its own checkpoint; one that is finished is not repeated.
    fn request(&self, cut_off: Option<f64>, seed: u64, look_at_test: bool) -> TrainingRequest {
        let Self {
            arguments, variant, ..
        } = self;
        let usual = arguments.training.settings();
        let settings = TrainingSettings {
            architecture: self.architecture.clone(),
            loss_over: arguments.loss_over,
            epochs: arguments.epochs as usize,
            cut_off: cut_off.unwrap_or(usual.cut_off),
            seed,
            ..usual
        };
        let networks = arguments.out.folder("table3").join("networks");
        let recipe = cut_off.map_or("plain".to_owned(), |cut_off| format!("cut-off-{cut_off}"));
        let folder = networks.join(variant.key).join(recipe);
        TrainingRequest {
            dataset: arguments.dataset.clone(),
            folder: folder.join(format!("seed-{seed}")),
            settings: variant.of(settings),
            device: arguments.training.device,
            threads: arguments.training.threads(),
            resume: true,
            look_at_test,
        }
    }
}

/// The rows without ranking need values; that they are missing is said before the first row is trained, not hours later.
fn has_values(dataset: &Path) -> Outcome {
    if Dataset::open(dataset).or_input()?.settings().has_values {
        return Ok(());
    }
    Err(Failure::input(format_args!(
        "the dataset in {} has no values, which the rows without ranking need: make it with `ppnpack dataset --values`",
        dataset.display()
    )))
}

fn no_choice() -> Failure {
    Failure::input(
        "several cut-offs are given and no validation split to choose among them: give one, or --validation 1",
    )
}

/// The cut-off that does best on the validation split, the first of equals.
fn best(tried: &[Tried], question: Question) -> Option<f64> {
    let found = |tried: &Tried| tried.validation.decisive(question);
    // Of equal ones, `min_by` gives the first.
    let best = tried
        .iter()
        .min_by(|one, other| found(other).total_cmp(&found(one)));
    best.map(|best| best.cut_off)
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use ppnpack_model::accuracy::{Rank, Tally};

    use super::*;

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        table3: Table3Arguments,
    }

    fn arguments(line: &str) -> Table3Arguments {
        Command::parse_from(line.split(' ')).table3
    }

    /// A cut-off whose optimum has so many placements before it, and so many that fit.
    fn tried(cut_off: f64, before: u64, fitting_before: u64) -> Tried {
        let mut tally = Tally::default();
        let rank = Rank {
            placements: 1000,
            fitting: 100,
            before,
            fitting_before,
        };
        tally.add(8, &rank);
        Tried {
            cut_off,
            validation: tally.accuracies(),
        }
    }

    #[test]
    fn validation_chooses_by_the_question_that_the_loss_asks() {
        let all = [tried(10.0, 50, 0), tried(40.0, 0, 0), tried(80.0, 0, 0)];
        let chosen = |question| best(&all, question);
        assert_eq!(chosen(Question::OverAll), Some(40.0));
        assert_eq!(chosen(Question::Proposed), Some(10.0));
        assert_eq!(best(&[], Question::OverAll), None);
    }

    #[test]
    fn every_training_has_a_folder_and_settings_of_its_own() {
        let arguments = arguments("table3 --cut-off 10,40 --loss-over fitting");
        let mut folders = std::collections::BTreeSet::new();
        for variant in &VARIANTS {
            let plan = Plan {
                arguments: &arguments,
                variant,
                architecture: &Architecture::default(),
            };
            for cut_off in [None, Some(10.0), Some(40.0)] {
                for seed in [0, 1] {
                    let request = plan.request(cut_off, seed, true);
                    let settings = &request.settings;
                    assert_eq!((settings.seed, settings.loss), (seed, variant.loss));
                    assert_eq!(settings.loss_over, LossOver::Fitting);
                    assert!(cut_off.is_none_or(|cut_off| settings.cut_off == cut_off));
                    folders.insert(request.folder);
                }
            }
        }
        assert_eq!(folders.len(), 24);
    }
}
