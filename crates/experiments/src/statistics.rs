//! Means with confidence intervals, shares, quantiles.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A mean over cases.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Mean {
    pub(crate) mean: f64,
    /// Half the width of the 95 % confidence interval; 0 where a single value says nothing of it.
    pub(crate) half_width: f64,
}

impl Mean {
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.collect();
        let count = values.len() as f64;
        if values.is_empty() {
            return Self::default();
        }
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let variance = squares / (count - 1.0).max(1.0);
        Self {
            mean,
            half_width: quantile_95(values.len()) * (variance / count).sqrt(),
        }
    }

    /// The mean and its interval with so many decimals.
    pub(crate) fn shown(&self, decimals: usize) -> String {
        let size = format!("{:.decimals$}", self.mean.abs());
        // What rounds to nothing is not less than nothing.
        let is_less = self.mean < 0.0 && size.contains(|digit| matches!(digit, '1'..='9'));
        let sign = if is_less { "-" } else { "" };
        format!("{sign}{size} ± {:.decimals$}", self.half_width)
    }

    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self {
            mean: self.mean * factor,
            half_width: self.half_width * factor,
        }
    }
}

/// The two-sided 95 % quantile of Student's t distribution for the mean of so many values; 0 for a single one.
fn quantile_95(count: usize) -> f64 {
    let freedom = count.saturating_sub(1) as f64;
    StudentsT::new(0.0, 1.0, freedom).map_or(0.0, |distribution| distribution.inverse_cdf(0.975))
}

/// The percentage that a part is of the whole; not a number where there is no whole.
pub(crate) fn percentage(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole as f64
}

/// The values that these shares of all stay below; not numbers where there are none.
pub(crate) fn quantiles<const N: usize>(
    values: impl Iterator<Item = f64>,
    shares: [f64; N],
) -> [f64; N] {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    shares.map(|share| {
        let rank = ((values.len() as f64 * share) as usize).min(last);
        values.get(rank).copied().unwrap_or(f64::NAN)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounds_to_nothing_has_no_sign() {
        let shown = |mean: f64| {
            let mean = Mean {
                mean,
                half_width: 0.12,
            };
            mean.shown(1)
        };
        assert_eq!(shown(-0.037), "0.0 ± 0.1");
        assert_eq!(shown(-0.051), "-0.1 ± 0.1");
        assert_eq!(shown(0.26), "0.3 ± 0.1");
    }

    #[test]
    fn the_interval_is_that_of_students_t() {
        let mean = Mean::of([1.0, 2.0, 3.0, 4.0].into_iter());
        assert!((mean.mean - 2.5).abs() < 1e-12);
        let expected = 3.182446 * (5.0_f64 / 3.0 / 4.0).sqrt();
        assert!((mean.half_width - expected).abs() < 1e-6);
        assert_eq!(Mean::of(std::iter::empty()), Mean::default());
        assert_eq!(Mean::of(std::iter::once(2.0)).half_width, 0.0);
    }

    #[test]
    fn a_quantile_is_one_of_the_values() {
        let values = [3.0, 1.0, 2.0];
        assert_eq!(quantiles(values.into_iter(), [0.5, 1.0]), [2.0, 3.0]);
        assert!(quantiles(std::iter::empty(), [0.5])[0].is_nan());
    }
}
