//! How much a step may compute: one number in place of the budgets of its stages.

use crate::method::Method;

/// How long a step may take, in seconds: 95 % of the steps take no longer on a core of some years ago.
///
/// It stands for numbers of tries and futures, and is not held against a clock: the same effort decides the same on every
/// machine.
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
    futures: usize,
}

/// By rising effort, as measured in `docs/results/effort.md`.
const LADDER: [Rung; 7] = [
    rung(0.0, 0, 0),
    rung(0.030, 1, 0),
    rung(0.050, 3, 0),
    rung(0.100, 10, 0),
    rung(0.250, 40, 0),
    rung(0.500, 40, 6),
    rung(1.0, 40, 12),
];

const fn rung(from_s: f64, tries_per_item: usize, futures: usize) -> Rung {
    Rung {
        from_s,
        tries_per_item,
        futures,
    }
}

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

    /// The efforts at which a step begins to do more, the least possible one first.
    pub fn ladder() -> impl Iterator<Item = Self> {
        LADDER.iter().map(|rung| Self(rung.from_s.max(0.001)))
    }

    /// How long a step may take, in seconds.
    pub fn step_s(self) -> f64 {
        self.0
    }

    /// The method with as many tries and futures as the effort allows.
    #[must_use]
    pub fn of(self, method: Method) -> Method {
        let mut method = method;
        let below = LADDER.iter().take_while(|rung| rung.from_s <= self.0);
        if let Some(rung) = below.last() {
            method.trial.tries_per_item = rung.tries_per_item;
            method.look_ahead.futures = rung.futures;
        }
        method
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn budgets(step_s: f64) -> (usize, usize) {
        let method = Effort::new(step_s).unwrap().of(Method::default());
        (method.trial.tries_per_item, method.look_ahead.futures)
    }

    #[test]
    fn more_effort_never_does_less() {
        let efforts: Vec<Effort> = Effort::ladder().collect();
        assert!(efforts.is_sorted());
        let of_rungs: Vec<_> = efforts
            .iter()
            .map(|effort| budgets(effort.step_s()))
            .collect();
        assert!(of_rungs.is_sorted());
        assert!(of_rungs.windows(2).all(|pair| pair[0] != pair[1]));
        assert_eq!(budgets(0.001), (0, 0));
        assert_eq!(budgets(3600.0), of_rungs[of_rungs.len() - 1]);
    }

    #[test]
    fn an_effort_takes_the_last_rung_that_is_not_above_it() {
        for rung in LADDER.iter().skip(1) {
            let below = budgets(rung.from_s.next_down());
            let expected = (rung.tries_per_item, rung.futures);
            assert_eq!(budgets(rung.from_s), expected);
            assert_ne!(below, expected);
        }
    }

    #[test]
    fn impossible_efforts_are_named() {
        for step_s in [0.0, 0.0009, 3601.0, f64::NAN, f64::INFINITY, -1.0] {
            let refused = Effort::new(step_s).unwrap_err().to_string();
            assert!(refused.contains("effort"), "{refused}");
        }
    }
}
