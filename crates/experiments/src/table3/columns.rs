//! What the table says of each network: how often the optimum is among the best-scored placements.

use std::sync::Arc;

use ppnpack_model::accuracy::{Accuracies, Question, SHARES_PERCENT};
use ppnpack_model::card::ModelCard;

use super::variants::Variant;
use crate::sheet::{Cell, Column};
use crate::statistics::Mean;

/// A network that was trained for a row, with one seed.
#[derive(Debug, Clone)]
pub(super) struct Trained {
    pub(super) variant: &'static Variant,
    pub(super) card: Arc<ModelCard>,
}

/// What the columns of a question are kept by, at the shares of the paper's table, and their heads.
fn keys(question: Question) -> [&'static str; SHARES_PERCENT.len()] {
    match question {
        Question::Proposed => [
            "proposed/1",
            "proposed/5",
            "proposed/8",
            "proposed/10",
            "proposed/20",
        ],
        Question::OverAll => [
            "over_all/1",
            "over_all/5",
            "over_all/8",
            "over_all/10",
            "over_all/20",
        ],
        Question::AmongFitting => [
            "among_fitting/1",
            "among_fitting/5",
            "among_fitting/8",
            "among_fitting/10",
            "among_fitting/20",
        ],
    }
}

const HEADS: [&str; SHARES_PERCENT.len()] =
    ["K = 1 %", "K = 5 %", "K = 8 %", "K = 10 %", "K = 20 %"];

/// The answers to a question at the shares of the paper's table; the paper's own, in brackets, beside its own question.
pub(super) fn answers<'a, R>(
    question: Question,
    accuracies: impl Fn(&R) -> Option<&Accuracies> + Copy + 'a,
    paper: impl Fn(&R) -> Option<[f64; SHARES_PERCENT.len()]> + Copy + 'a,
) -> Vec<Column<'a, R>> {
    let keys = keys(question).into_iter().zip(HEADS).enumerate();
    let columns = keys.map(|(at, (key, head))| {
        Column::new(key, head, move |runs: &[R]| {
            let networks: Vec<&Accuracies> = runs.iter().filter_map(accuracies).collect();
            let mean = percent(&networks, question, at);
            let paper = runs.first().and_then(paper);
            let paper = paper.and_then(|paper| paper.get(at).copied());
            match paper.filter(|_| question == Question::OverAll) {
                Some(paper) => Cell::new(format!("{} [{paper:.1}]", mean.shown(1)), mean),
                None => Cell::mean(mean, 1),
            }
        })
    });
    columns.collect()
}

/// How large the networks are and how long they were trained.
pub(super) fn sizes() -> [Column<'static, Trained>; 2] {
    [
        Column::new("parameters", "parameters", |runs: &[Trained]| {
            Cell::count(runs.first().map_or(0, |it| it.card.parameters as usize))
        }),
        Column::new("training_s", "training", |runs: &[Trained]| {
            let mean = Mean::of(runs.iter().map(|it| it.card.training_s));
            Cell::new(format!("{:.0} s", mean.mean), mean)
        }),
    ]
}

/// The percentage at a share: with several networks, the mean over them with an interval over them; with one, an interval
/// over the sequences.
fn percent(networks: &[&Accuracies], question: Question, at: usize) -> Mean {
    let found = |of: &&Accuracies| of.of(question).get(at).map(|answer| answer.share);
    let mean = match networks {
        [one] => one.of(question).get(at).map(|answer| {
            let error = answer.standard_error.unwrap_or(0.0);
            Mean::clustered(answer.share, error, one.sequences)
        }),
        several => Some(Mean::of(several.iter().filter_map(found))),
    };
    mean.unwrap_or_default().scaled(100.0)
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
        let one = percent(&[&good], Question::OverAll, 0);
        // Means of 0.6 and 0.8: an error of 0.1, and 12.706 of them with one degree of freedom.
        assert!((one.mean - 70.0).abs() < 1e-9 && (one.half_width - 127.062).abs() < 1e-2);
        let both = percent(&[&good, &bad], Question::OverAll, 0);
        assert!((both.mean - 60.0).abs() < 1e-9 && (both.half_width - 127.062).abs() < 1e-2);
        assert_eq!(percent(&[&bad], Question::OverAll, 0).half_width, 0.0);
    }
}
