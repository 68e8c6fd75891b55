//! How often the optimum is among the best-scored placements, at the shares of the paper's Table III.

use std::path::Path;

use ppnpack_chart::{Curve, Lines};
use ppnpack_cli::failure::Outcome;

use crate::document;
use crate::statistics::Mean;

/// The shares `K` of the paper's table, in percent.
pub(crate) const SHARES: [f64; 5] = ppnpack_model::accuracy::SHARES_PERCENT;

/// The head of a table's columns of shares.
pub(crate) fn head() -> String {
    SHARES.map(|share| format!(" K = {share} % |")).concat()
}

/// Draws a curve for each row of a table: its name, and its means at the shares, in percent.
pub(crate) fn draw<'a>(
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
