//! Ridge regression, and how much it explains of sequences that it was not fitted on.

use nalgebra::{DMatrix, DVector};

/// A step of a packed sequence.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sample {
    pub(super) figures: Vec<f64>,
    /// What was packed until then.
    pub(super) packed: f64,
    /// What was packed after it.
    pub(super) further: f64,
}

impl Sample {
    /// What the regression is on: the figures from the one numbered `first` on, and what was packed until then.
    fn regressors(&self, first: usize) -> impl Iterator<Item = f64> {
        self.figures
            .iter()
            .skip(first)
            .copied()
            .chain([self.packed])
    }
}

/// A linear function of the figures and of what was packed until then.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Linear {
    first: usize,
    pub(super) coefficients: Vec<f64>,
    constant: f64,
}

impl Linear {
    fn of(&self, sample: &Sample) -> f64 {
        let terms = self.coefficients.iter().zip(sample.regressors(self.first));
        self.constant
            + terms
                .map(|(coefficient, figure)| coefficient * figure)
                .sum::<f64>()
    }
}

/// The ridge regression on the figures from the one numbered `first` on, each by its standard deviation; `None` without samples.
///
/// Source: Hoerl and Kennard, *Ridge Regression: Biased Estimation for Nonorthogonal Problems*, 1970.
pub(super) fn fit<'a>(
    samples: impl Iterator<Item = &'a Sample>,
    first: usize,
    penalty: f64,
) -> Option<Linear> {
    let samples: Vec<&Sample> = samples.collect();
    let width = samples.first()?.regressors(first).count();
    let rows = samples.iter().flat_map(|sample| sample.regressors(first));
    let mut regressors = DMatrix::from_row_iterator(samples.len(), width, rows);
    let further = samples.iter().map(|sample| sample.further);
    let mut further = DVector::from_iterator(samples.len(), further);
    let count = samples.len() as f64;
    let mut means = Vec::with_capacity(width);
    let mut deviations = Vec::with_capacity(width);
    for mut column in regressors.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
        // What is always the same explains nothing.
        let deviation = (column.norm_squared() / count).sqrt().max(1e-9);
        column /= deviation;
        means.push(mean);
        deviations.push(deviation);
    }
    let mean_further = further.mean();
    further.add_scalar_mut(-mean_further);
    let mut normal = regressors.tr_mul(&regressors);
    for index in 0..width {
        if let Some(diagonal) = normal.get_mut((index, index)) {
            *diagonal += penalty;
        }
    }
    let solved = normal.cholesky()?.solve(&regressors.tr_mul(&further));
    let coefficients = solved.iter().zip(&deviations);
    let coefficients: Vec<f64> = coefficients
        .map(|(of_deviation, by)| of_deviation / by)
        .collect();
    let at_means = coefficients.iter().zip(&means);
    let at_means: f64 = at_means.map(|(coefficient, mean)| coefficient * mean).sum();
    Some(Linear {
        first,
        coefficients,
        constant: mean_further - at_means,
    })
}

/// The share of the variance that is explained of sequences that were held back, a fifth of them at a time.
pub(super) fn explained(sequences: &[Vec<Sample>], first: usize, penalty: f64) -> Option<f64> {
    const PARTS: usize = 5;
    let is_held_back = |index: usize, part: usize| index % PARTS == part;
    let mut squares = 0.0;
    for part in 0..PARTS {
        let of = |is_wanted: bool| {
            let sequences = sequences.iter().enumerate();
            let wanted =
                sequences.filter(move |(index, _)| is_held_back(*index, part) == is_wanted);
            wanted.flat_map(|(_, samples)| samples)
        };
        let linear = fit(of(false), first, penalty)?;
        let errors = of(true).map(|sample| sample.further - linear.of(sample));
        squares += errors.map(|error| error * error).sum::<f64>();
    }
    let all = || sequences.iter().flatten().map(|sample| sample.further);
    let mean = all().sum::<f64>() / all().count() as f64;
    let total: f64 = all().map(|further| (further - mean).powi(2)).sum();
    Some(1.0 - squares / total)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Sequences in which what is packed later is `2 a - 3 b + 5 c`, `c` what was packed until then, and noise.
    fn sequences(noise: f64) -> Vec<Vec<Sample>> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut sample = || {
            let mut draw = || random.random::<f64>();
            let [a, b, c, error] = [draw(), draw(), draw(), draw() - 0.5];
            Sample {
                figures: vec![a, b, 0.25],
                packed: c,
                further: 2.0 * a - 3.0 * b + 5.0 * c + noise * error,
            }
        };
        (0..20)
            .map(|_| (0..30).map(|_| sample()).collect())
            .collect()
    }

    #[test]
    fn a_linear_law_is_found() {
        let linear = fit(sequences(0.0).iter().flatten(), 0, 1e-9).unwrap();
        for (found, expected) in linear.coefficients.iter().zip([2.0, -3.0, 0.0, 5.0]) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        assert!(linear.constant.abs() < 1e-6);
        let explained = explained(&sequences(0.0), 0, 1e-9).unwrap();
        assert!((explained - 1.0).abs() < 1e-9);
    }

    #[test]
    fn noise_and_what_is_left_out_are_not_explained_and_a_penalty_makes_coefficients_less() {
        let noisy = sequences(1.0);
        let all = explained(&noisy, 0, 1.0).unwrap();
        let without_the_first = explained(&noisy, 1, 1.0).unwrap();
        assert!(all > 0.9 && all < 1.0, "{all}");
        assert!(without_the_first < all - 0.05, "{without_the_first}");
        let norm = |penalty: f64| {
            let linear = fit(noisy.iter().flatten(), 0, penalty).unwrap();
            linear.coefficients.iter().map(|it| it * it).sum::<f64>()
        };
        assert!(norm(1e4) < 0.5 * norm(1.0));
        assert_eq!(fit(std::iter::empty(), 0, 1.0), None);
        assert_eq!(explained(&[], 0, 1.0), None);
    }
}
