//! How much a step may compute, as a time.

use crate::trial::TrialSettings;

/// From this effort on placements are tried, in seconds: on two cores of an AMD EPYC, 95 % of the steps that try take no longer
/// (`docs/results/effort.md`).
const TRYING_FROM_S: f64 = 0.250;

/// About how long a step may take, in seconds.
///
/// It stands for a number of tries, and is not held against a clock: the same effort decides the same on every machine.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Effort(f64);

/// An effort that is not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("an effort must be from 1 ms to an hour, but is {0} s")]
pub struct EffortError(f64);

impl Effort {
    /// An effort of so many seconds.
    ///
    /// # Errors
    /// [`EffortError`] where it is below a millisecond, above an hour or no number.
    pub fn new(step_s: f64) -> Result<Self, EffortError> {
        match (0.001..=3600.0).contains(&step_s) {
            true => Ok(Self(step_s)),
            false => Err(EffortError(step_s)),
        }
    }

    /// How many placements of an item it is enough to try.
    ///
    /// That is none or as many as usual: with fewer tries an item is given up sooner, which costs volume and saves hardly any time.
    pub fn tries_per_item(self) -> usize {
        match self.0 < TRYING_FROM_S {
            true => TrialSettings::off().tries_per_item,
            false => TrialSettings::default().tries_per_item,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placements_are_tried_from_an_effort_on() {
        let tries = |step_s: f64| Effort::new(step_s).unwrap().tries_per_item();
        assert_eq!(tries(0.001), 0);
        assert_eq!(tries(TRYING_FROM_S.next_down()), 0);
        assert_eq!(tries(TRYING_FROM_S), 40);
        assert_eq!(tries(3600.0), 40);
    }

    #[test]
    fn impossible_efforts_are_named() {
        for step_s in [0.0, 0.0009, 3601.0, f64::NAN, f64::INFINITY, -1.0] {
            let refused = Effort::new(step_s).unwrap_err().to_string();
            assert!(refused.contains("effort"), "{refused}");
        }
    }
}
