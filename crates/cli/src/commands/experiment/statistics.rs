//! Means with confidence intervals.

use serde::{Deserialize, Serialize};

/// The two-sided 95 % quantile of the normal distribution; samples here are 20 and more.
const NORMAL_95: f64 = 1.96;

/// A mean over cases.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Mean {
    pub(super) mean: f64,
    /// Half the width of the 95 % confidence interval.
    pub(super) half_width: f64,
}

impl Mean {
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Self {
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
            half_width: NORMAL_95 * (variance / count).sqrt(),
        }
    }

    /// The mean and its interval with so many decimals.
    pub(super) fn shown(&self, decimals: usize) -> String {
        format!("{:.decimals$} ± {:.decimals$}", self.mean, self.half_width)
    }

    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self {
            mean: self.mean * factor,
            half_width: self.half_width * factor,
        }
    }
}

/// A count out of a total, as a share in percent.
pub(super) fn percent(count: usize, total: usize) -> String {
    if total == 0 {
        "–".to_owned()
    } else {
        format!("{:.1} %", 100.0 * count as f64 / total as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_that_of_the_normal_distribution() {
        let mean = Mean::of([1.0, 2.0, 3.0, 4.0].into_iter());
        assert!((mean.mean - 2.5).abs() < 1e-12);
        let expected = 1.96 * (5.0_f64 / 3.0 / 4.0).sqrt();
        assert!((mean.half_width - expected).abs() < 1e-12);
        assert_eq!(Mean::of(std::iter::empty()), Mean::default());
    }
}
