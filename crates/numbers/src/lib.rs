//! Numbers that are given, checked ([`require`], [`within`]), [`settings`] with their defaults and
//! ranges, and numbers that are drawn: normal ones ([`gaussian`]) and factors ([`factor_within`]).
//!
//! ```
//! use ppnpack_numbers::within;
//!
//! let share = within("0 to 1", 0.0..=1.0);
//! assert_eq!(share("dropout", 0.05), Ok(()));
//! let error = share("dropout", 5.0).unwrap_err();
//! assert_eq!(error.to_string(), "dropout must be 0 to 1, but is 5");
//! ```

use std::fmt::Display;
use std::ops::RangeBounds;

mod defaults;

pub use defaults::Number;

/// A setting that is not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} must be {expected}, but is {value}")]
pub struct SettingError {
    /// The setting.
    pub name: String,
    /// The possible values, in words.
    pub expected: &'static str,
    /// The value that was given.
    pub value: f64,
}

/// Refuses a number that is not finite or fails a condition.
///
/// # Errors
/// [`SettingError`] has the name, and what is expected instead.
pub fn require(
    name: impl Display,
    value: f64,
    expected: &'static str,
    is_possible: impl FnOnce(f64) -> bool,
) -> Result<(), SettingError> {
    let is_possible = value.is_finite() && is_possible(value);
    is_possible.then_some(()).ok_or_else(|| SettingError {
        name: name.to_string(),
        expected,
        value,
    })
}

/// Makes a check that refuses numbers, given by name and value, that are not finite or outside a
/// range.
pub fn within(
    expected: &'static str,
    range: impl RangeBounds<f64>,
) -> impl Fn(&str, f64) -> Result<(), SettingError> {
    move |name, value| require(name, value, expected, |value| range.contains(&value))
}

/// Draws a standard normal number from two uniform ones in [0, 1), by the Box-Muller transform.
pub fn gaussian(first: f64, second: f64) -> f64 {
    // 1 - first is in (0, 1], where the logarithm is finite.
    (-2.0 * (1.0 - first).ln()).sqrt() * (std::f64::consts::TAU * second).cos()
}

/// Draws a factor between `most` and its inverse from a uniform number in [0, 1): as likely to
/// enlarge as to lessen.
pub fn factor_within(most: f64, uniform: f64) -> f64 {
    most.powf(2.0 * uniform - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_not_finite_are_refused() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(require("a length", value, "a number", |_| true).is_err());
        }
    }

    #[test]
    fn normal_numbers_have_mean_0_and_deviation_1() {
        let steps = 400;
        let uniform = |step: usize| (step as f64 + 0.5) / steps as f64;
        let all = (0..steps).flat_map(|a| (0..steps).map(move |b| (a, b)));
        let drawn: Vec<f64> = all.map(|(a, b)| gaussian(uniform(a), uniform(b))).collect();
        let count = drawn.len() as f64;
        let mean = drawn.iter().sum::<f64>() / count;
        let variance = drawn.iter().map(|value| value * value).sum::<f64>() / count;
        assert!(mean.abs() < 1e-9, "{mean}");
        assert!((variance - 1.0).abs() < 0.01, "{variance}");
        assert!(gaussian(0.0, 0.3).is_finite());
    }

    #[test]
    fn factors_reach_from_the_inverse_to_the_most() {
        assert_eq!(factor_within(1.0, 0.3), 1.0);
        assert_eq!(factor_within(4.0, 0.0), 0.25);
        assert_eq!(factor_within(4.0, 0.5), 1.0);
        assert_eq!(factor_within(4.0, 0.75), 2.0);
    }
}
