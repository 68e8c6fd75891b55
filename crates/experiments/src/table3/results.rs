//! What the table says of each network.

use ppnpack_model::accuracy::{Accuracies, Question};
use ppnpack_model::card::ModelCard;
use ppnpack_model::settings::LossOver;
use serde::Serialize;

use super::recipes::Recipe;
use super::shares::percent;
use super::variants::Variant;
use crate::statistics::Mean;

/// The table.
#[derive(Debug, Serialize)]
pub(super) struct Results {
    pub(super) shares_percent: [f64; 5],
    pub(super) loss_over: LossOver,
    pub(super) rows: Vec<Row>,
}

/// A network of the table.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    pub(super) network: &'static str,
    /// What validation chose among; empty where there was one recipe alone.
    pub(super) tried: Vec<Tried>,
    pub(super) recipe: Recipe,
    /// The test split's answers, one per question.
    pub(super) answers: Vec<Answer>,
    /// The networks that were tested, one per seed.
    pub(super) cards: Vec<ModelCard>,
}

/// A recipe, and how good it is on the validation split.
#[derive(Debug, Serialize)]
pub(super) struct Tried {
    pub(super) recipe: Recipe,
    pub(super) validation: Accuracies,
}

/// How often the optimum is found, by one question.
#[derive(Debug, Serialize)]
pub(super) struct Answer {
    pub(super) question: Question,
    /// At the shares of the table.
    pub(super) accuracy_percent: Vec<Mean>,
    /// The paper's, where the question is its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) paper_percent: Option<[f64; 5]>,
}

impl Row {
    pub(super) fn new(
        variant: &Variant,
        tried: Vec<Tried>,
        recipe: Recipe,
        cards: Vec<ModelCard>,
    ) -> Self {
        let tests: Vec<&Accuracies> = cards.iter().filter_map(|card| card.test.as_ref()).collect();
        let answers = Question::ALL.map(|question| Answer {
            question,
            accuracy_percent: percent(&tests, question),
            paper_percent: variant
                .paper_percent
                .filter(|_| question == Question::OverAll),
        });
        Self {
            network: variant.name,
            answers: answers.into(),
            tried,
            recipe,
            cards,
        }
    }

    pub(super) fn answer(&self, question: Question) -> Option<&Answer> {
        let mut answers = self.answers.iter();
        answers.find(|answer| answer.question == question)
    }
}
