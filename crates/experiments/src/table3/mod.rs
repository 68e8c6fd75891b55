//! `ppnpack experiment table3`: how often the optimum is among the best-scored placements, and what that owes to.
//!
//! Of each network, every recipe is trained with the first seed; the validation split chooses the one that is trained
//! with the other seeds too. Only what is chosen is measured on the test split.

mod page;
mod recipes;
mod results;
mod shares;
mod variants;

use std::path::{Path, PathBuf};

use clap::Args;
use ppnpack_cli::failure::{Failure, OrInput, Outcome};
use ppnpack_cli::network::Backend;
use ppnpack_cli::options::one_of;
use ppnpack_dataset::Dataset;
use ppnpack_model::accuracy::Question;
use ppnpack_model::architecture::Architecture;
use ppnpack_model::card::ModelCard;
use ppnpack_model::settings::{LossOver, TrainingRequest, TrainingSettings};

use crate::document::OutOptions;
use crate::train::options::{LOSS_OVERS, RunOptions, SizeOptions};
use crate::train::train;
use recipes::{Recipe, RecipeOptions};
use results::{Results, Row, Tried};
use shares::SHARES;
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

    #[command(flatten)]
    recipes: RecipeOptions,

    #[command(flatten)]
    size: SizeOptions,

    #[command(flatten)]
    training: RunOptions,

    #[command(flatten)]
    out: OutOptions,
}

pub(crate) fn run(arguments: &Table3Arguments, backend: &dyn Backend) -> Outcome {
    let architecture = arguments.size.architecture()?;
    let mut choices = VARIANTS.iter();
    if arguments.training.validation == 0
        && choices.any(|variant| arguments.recipes.of(variant.loss).len() > 1)
    {
        return Err(no_choice());
    }
    has_values(&arguments.dataset)?;
    let rows = VARIANTS.iter().map(|variant| {
        let plan = Plan {
            arguments,
            variant,
            architecture: &architecture,
        };
        plan.row(backend)
    });
    let results = Results {
        shares_percent: SHARES,
        loss_over: arguments.loss_over,
        rows: rows.collect::<Outcome<_>>()?,
    };
    draw(arguments, &results)?;
    let text = page::markdown(&results);
    arguments.out.publish("table3", &results, &text)
}

fn draw(arguments: &Table3Arguments, results: &Results) -> Outcome {
    for (question, name, title) in [
        (
            Question::OverAll,
            "table3",
            "Optimum among the best-scored K % of all placements",
        ),
        (
            Question::Proposed,
            "table3-proposed",
            "Optimum among what the planner proposes",
        ),
        (
            Question::AmongFitting,
            "table3-fitting",
            "Optimum among the best-scored K % of those that fit",
        ),
    ] {
        let rows = results.rows.iter();
        let rows =
            rows.filter_map(|row| Some((row.network, &row.answer(question)?.accuracy_percent)));
        shares::draw(
            (&arguments.out.folder("table3"), name),
            title,
            "Test candidates",
            rows,
        )?;
    }
    Ok(())
}

/// How one row comes about.
struct Plan<'a> {
    arguments: &'a Table3Arguments,
    variant: &'a Variant,
    architecture: &'a Architecture,
}

impl Plan<'_> {
    fn row(&self, backend: &dyn Backend) -> Outcome<Row> {
        let name = self.variant.name;
        let first = self.arguments.training.seed;
        let (tried, chosen) = self.choose(backend)?;
        let seeds = first..first.saturating_add(u64::from(self.arguments.seeds));
        let cards = seeds.map(|seed| {
            eprintln!("{name}, {}, seed {seed}:", chosen.key());
            train(&self.request(&chosen, seed, true), backend)
        });
        let cards: Vec<ModelCard> = cards.collect::<Outcome<_>>()?;
        Ok(Row::new(self.variant, tried, chosen, cards))
    }

    /// Trains every recipe with the first seed, and gives the one that validation chooses; none is tested. Where there is
    /// one alone, there is nothing to choose.
    fn choose(&self, backend: &dyn Backend) -> Outcome<(Vec<Tried>, Recipe)> {
        let recipes = self.arguments.recipes.of(self.variant.loss);
        if let [one] = recipes.as_slice() {
            return Ok((Vec::new(), *one));
        }
        let mut tried = Vec::new();
        for recipe in recipes {
            eprintln!("{}, {}, to choose:", self.variant.name, recipe.key());
            let seed = self.arguments.training.seed;
            let card = train(&self.request(&recipe, seed, false), backend)?;
            let validation = card.validation.ok_or_else(no_choice)?;
            tried.push(Tried { recipe, validation });
        }
        let question = Question::of_loss(self.arguments.loss_over);
        let chosen = best(&tried, question).ok_or_else(no_choice)?;
        Ok((tried, chosen))
    }

    /// A training goes on from its own checkpoint; one that is finished is not repeated.
    fn request(&self, recipe: &Recipe, seed: u64, look_at_test: bool) -> TrainingRequest {
        let Self {
            arguments, variant, ..
        } = self;
        let settings = TrainingSettings {
            architecture: self.architecture.clone(),
            loss_over: arguments.loss_over,
            epochs: arguments.epochs as usize,
            seed,
            ..arguments.training.settings()
        };
        let networks = arguments
            .out
            .folder("table3")
            .join("networks")
            .join(variant.key);
        TrainingRequest {
            dataset: arguments.dataset.clone(),
            folder: networks.join(recipe.key()).join(format!("seed-{seed}")),
            settings: variant.of(recipe.of(settings)),
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
        "several settings are given and no validation split to choose among them: give one of each, or --validation 1",
    )
}

/// The recipe that does best on the validation split, the first of equals.
fn best(tried: &[Tried], question: Question) -> Option<Recipe> {
    let mut best: Option<&Tried> = None;
    for tried in tried {
        let found = tried.validation.decisive(question);
        if best.is_none_or(|best| found > best.validation.decisive(question)) {
            best = Some(tried);
        }
    }
    best.map(|best| best.recipe)
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use ppnpack_model::accuracy::{Rank, Tally};
    use ppnpack_model::settings::{Loss, Schedule};

    use super::*;

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        table3: Table3Arguments,
    }

    fn arguments(line: &str) -> Table3Arguments {
        Command::parse_from(line.split(' ')).table3
    }

    /// A recipe whose optimum has so many placements before it, and so many that fit.
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
            recipe: Recipe {
                learning_rate: 2e-3,
                schedule: Schedule::Constant,
                cut_off: Some(cut_off),
            },
            validation: tally.accuracies(),
        }
    }

    #[test]
    fn validation_chooses_by_the_question_that_the_loss_asks() {
        let all = [tried(10.0, 50, 0), tried(40.0, 0, 0), tried(80.0, 0, 0)];
        let chosen = |question| best(&all, question).unwrap().cut_off;
        assert_eq!(chosen(Question::OverAll), Some(40.0));
        assert_eq!(chosen(Question::Proposed), Some(10.0));
        assert_eq!(best(&[], Question::OverAll), None);
    }

    #[test]
    fn every_training_has_a_folder_and_settings_of_its_own() {
        let arguments = arguments("table3 --seeds 2 --cut-off 10,40 --loss-over fitting");
        let mut folders = std::collections::BTreeSet::new();
        let mut trainings = 0;
        for variant in &VARIANTS {
            let plan = Plan {
                arguments: &arguments,
                variant,
                architecture: &Architecture::default(),
            };
            for recipe in arguments.recipes.of(variant.loss) {
                for seed in [0, 1] {
                    let request = plan.request(&recipe, seed, true);
                    let settings = &request.settings;
                    assert_eq!((settings.seed, settings.loss), (seed, variant.loss));
                    assert_eq!(settings.loss_over, LossOver::Fitting);
                    if variant.loss == Loss::Mse {
                        assert_eq!(Some(settings.cut_off), recipe.cut_off);
                    }
                    folders.insert(request.folder);
                    trainings += 1;
                }
            }
        }
        assert_eq!((trainings, folders.len()), (12, 12));
    }
}
