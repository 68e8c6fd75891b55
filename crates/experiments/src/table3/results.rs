//! What the table says of each network.

use ppnpack_model::accuracy::{Accuracies, Question};
use ppnpack_model::card::ModelCard;
use ppnpack_model::settings::LossOver;
use serde::Serialize;

use super::recipes::Recipe;
use super::variants::Variant;
use crate::shares::SHARES;
use crate::statistics::Mean;

/// The table.
#[derive(Debug, Serialize)]
pub(super) struct Results {
    pub(super) machine: String,
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

/// Percentages at the table's shares: with several networks, means over them with intervals over them; with one, intervals
/// over the sequences.
pub(super) fn percent(networks: &[&Accuracies], question: Question) -> Vec<Mean> {
    let at_share = |at: usize| {
        let found = |of: &&Accuracies| of.of(question).get(at).map(|answer| answer.share);
        let mean = match networks {
            [one] => one.of(question).get(at).map(|answer| {
                let error = answer.standard_error.unwrap_or(0.0);
                Mean::clustered(answer.share, error, one.sequences)
            }),
            several => Some(Mean::of(several.iter().filter_map(found))),
        };
        mean.unwrap_or_default().scaled(100.0)
    };
    (0..SHARES.len()).map(at_share).collect()
}

#[cfg(test)]
mod tests {
    use ppnpack_model::accuracy::{Rank, Tally};

    use super::*;

    /// Two sequences of candidates, of which so many of ten each have their optimum scored best.
    fn accuracies(found: [u64; 2]) -> Accuracies {
        let mut tally = Tally::default();
        for (sequence, found) in (0..).zip(found) {
            for candidate in 0..10 {
                let before = if candidate < found { 0 } else { 900 };
                let rank = Rank {
                    placements: 1000,
                    fitting: 1000,
                    before,
                    fitting_before: before,
                };
                tally.add(sequence, &rank);
            }
        }
        tally.accuracies()
    }

    #[test]
    fn one_network_has_an_interval_over_sequences_and_several_over_networks() {
        let (good, bad) = (accuracies([6, 8]), accuracies([5, 5]));
        let one = percent(&[&good], Question::OverAll)[0];
        // Means of 0.6 and 0.8: an error of 0.1, and 12.706 of them with one degree of freedom.
        assert!((one.mean - 70.0).abs() < 1e-9 && (one.half_width - 127.062).abs() < 1e-2);
        let both = percent(&[&good, &bad], Question::OverAll)[0];
        assert!((both.mean - 60.0).abs() < 1e-9 && (both.half_width - 127.062).abs() < 1e-2);
        assert_eq!(percent(&[&bad], Question::OverAll)[0].half_width, 0.0);
    }
}
