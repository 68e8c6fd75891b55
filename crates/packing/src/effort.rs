//! How much a step may compute: one number in place of the budgets of its stages.

use crate::method::Method;

/// How long a step may take, in seconds: 95 % of the steps take no longer on a core of some years ago.
///
/// It stands for a number of tries, and is not held against a clock: the same effort decides the same on every machine.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Effort(f64);

/// An effort that is not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("an effort must be from 1 ms to an hour, but is {0} s")]
pub struct EffortError(f64);

/// What a step does from an effort on.
struct Rung {
    from_s: f64,
    tries_per_item: usize,
}

/// By rising effort, as measured in `docs/results/effort.md`. There is nothing between: with fewer tries an item is given up
/// sooner, which costs volume and saves hardly any time; and looking ahead takes longer and fills no more.
const LADDER: [Rung; 2] = [
    Rung {
        from_s: 0.001,
        tries_per_item: 0,
    },
    Rung {
        from_s: 0.150,
        tries_per_item: 40,
    },
];

impl Effort {
    /// An effort of so many seconds.
    ///
    /// # Errors
    /// [`EffortError`] where it is below a millisecond, above an hour or no number.
    pub fn new(step_s: f64) -> Result<Self, EffortError> {
        let is_possible = (0.001..=3600.0).contains(&step_s);
        is_possible
            .then_some(Self(step_s))
            .ok_or(EffortError(step_s))
    }

    /// How long a step may take, in seconds.
    pub fn step_s(self) -> f64 {
        self.0
    }

    /// The method with as many tries as the effort allows.
    #[must_use]
    pub fn of(self, method: Method) -> Method {
        let mut method = method;
        let allowed = LADDER.iter().rfind(|rung| rung.from_s <= self.0);
        if let Some(rung) = allowed {
            method.trial.tries_per_item = rung.tries_per_item;
        }
        method
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tries(step_s: f64) -> usize {
        let method = Effort::new(step_s).unwrap().of(Method::default());
        method.trial.tries_per_item
    }

    #[test]
    fn an_effort_takes_the_last_rung_that_is_not_above_it() {
        assert_eq!(tries(0.001), 0);
        assert_eq!(tries(0.150_f64.next_down()), 0);
        assert_eq!(tries(0.150), 40);
        assert_eq!(tries(3600.0), 40);
    }

    #[test]
    fn more_effort_never_does_less() {
        assert!(LADDER.iter().map(|rung| rung.from_s).is_sorted());
        assert!(LADDER.iter().map(|rung| rung.tries_per_item).is_sorted());
    }

    #[test]
    fn impossible_efforts_are_named() {
        for step_s in [0.0, 0.0009, 3601.0, f64::NAN, f64::INFINITY, -1.0] {
            let refused = Effort::new(step_s).unwrap_err().to_string();
            assert!(refused.contains("effort"), "{refused}");
        }
    }
}
