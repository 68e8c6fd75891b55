//! The settings that validation chooses among.

use clap::Args;
use ppnpack_cli::options::{one_of, positive};
use ppnpack_model::settings::{Loss, Schedule, TrainingSettings};
use serde::Serialize;

use crate::document;
use crate::train::options::SCHEDULES;

/// Settings that a training needs and the paper leaves open or that are no ablation of it. Where several values are given,
/// every combination is trained with the first seed, and validation chooses for each network.
#[derive(Debug, Args)]
#[command(next_help_heading = "What validation chooses among")]
pub(super) struct RecipeOptions {
    /// Learning rates at their peak
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "2e-3", value_parser = positive)]
    learning_rate: Vec<f64>,

    /// How the learning rate changes
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "cosine", value_parser = one_of(&SCHEDULES))]
    schedule: Vec<Schedule>,

    /// How far above the optimum regression tells values apart, in units of the objective
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "10,40", value_parser = positive)]
    cut_off: Vec<f64>,
}

/// One combination.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Recipe {
    pub(super) learning_rate: f64,
    pub(super) schedule: Schedule,
    /// None where the loss has no regression target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) cut_off: Option<f64>,
}

impl RecipeOptions {
    /// Every combination that makes a difference to a loss, each once.
    pub(super) fn of(&self, loss: Loss) -> Vec<Recipe> {
        let cut_offs: Vec<Option<f64>> = match loss {
            Loss::Ranking => vec![None],
            Loss::Mse => self.cut_off.iter().copied().map(Some).collect(),
        };
        let mut recipes = Vec::new();
        for learning_rate in self.learning_rate.iter().copied() {
            for schedule in self.schedule.iter().copied() {
                for cut_off in cut_offs.iter().copied() {
                    let recipe = Recipe {
                        learning_rate,
                        schedule,
                        cut_off,
                    };
                    if !recipes.contains(&recipe) {
                        recipes.push(recipe);
                    }
                }
            }
        }
        recipes
    }
}

impl Recipe {
    /// The name of its folder.
    pub(super) fn key(&self) -> String {
        let schedule = document::name_of(&self.schedule);
        let cut_off = self.cut_off.map(|value| format!("-cut-off-{value}"));
        format!(
            "rate-{}-{schedule}{}",
            self.learning_rate,
            cut_off.unwrap_or_default()
        )
    }

    /// These settings by this recipe.
    pub(super) fn of(&self, settings: TrainingSettings) -> TrainingSettings {
        TrainingSettings {
            learning_rate: self.learning_rate,
            schedule: self.schedule,
            cut_off: self.cut_off.unwrap_or(settings.cut_off),
            ..settings
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_combination_that_makes_a_difference_is_tried_once() {
        let options = RecipeOptions {
            learning_rate: vec![1e-4, 2e-3, 1e-4],
            schedule: vec![Schedule::Constant, Schedule::WarmUpAndCosine],
            cut_off: vec![10.0, 40.0],
        };
        let (ranking, regression) = (options.of(Loss::Ranking), options.of(Loss::Mse));
        assert_eq!((ranking.len(), regression.len()), (4, 8));
        assert!(ranking.iter().all(|recipe| recipe.cut_off.is_none()));
        let keys: BTreeSet<String> = regression.iter().map(Recipe::key).collect();
        assert_eq!(keys.len(), regression.len());
        assert!(keys.contains("rate-0.0001-constant-cut-off-40"), "{keys:?}");
    }
}
