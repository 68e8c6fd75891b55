//! How often the optimum is among the best-scored placements, at the shares of the paper's Table III.

use std::path::Path;

use ppnpack_chart::{Curve, Lines};
use ppnpack_cli::failure::Outcome;
use ppnpack_model::accuracy::{Accuracies, Question};

use crate::document;
use crate::statistics::Mean;

/// The shares `K` of the paper's table, in percent.
pub(super) const SHARES: [f64; 5] = ppnpack_model::accuracy::SHARES_PERCENT;

/// What the paper's network finds over all placements at these shares, in percent.
pub(super) const PAPER_PERCENT: [f64; 5] = [81.0, 94.9, 97.2, 98.0, 99.4];

/// The head of a table's columns of shares.
pub(super) fn head() -> String {
    SHARES.map(|share| format!(" K = {share} % |")).concat()
}

/// Accuracies as a table's cells, each with the paper's in brackets where there is one.
pub(super) fn cells(accuracy: &[Mean], paper: &[f64]) -> String {
    let cells = accuracy.iter().enumerate().map(|(at, mean)| {
        let paper = paper.get(at).map(|paper| format!(" [{paper:.1}]"));
        format!(" {}{} |", mean.shown(1), paper.unwrap_or_default())
    });
    cells.collect()
}

/// Draws a curve for each row of a table: its name, and its means at the shares, in percent.
pub(super) fn draw<'a>(
    (folder, name): (&Path, &str),
    title: &str,
    of: &str,
    rows: impl Iterator<Item = (&'a str, &'a Vec<Mean>)>,
) -> Outcome {
    let curves = rows.map(|(name, means)| Curve {
        name: name.to_owned(),
        points: SHARES
            .iter()
            .zip(means)
            .map(|(share, accuracy)| [*share, accuracy.mean])
            .collect(),
    });
    let chart = Lines {
        title: title.to_owned(),
        x_label: "K (%)".to_owned(),
        y_label: format!("{of} (%)"),
        curves: curves.collect(),
    };
    document::figure(folder, name, chart.to_svg([900, 560]))
}

/// Percentages at the shares: with several networks, means over them with intervals over them; with one, intervals
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
