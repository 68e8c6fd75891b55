//! Decisions that are too old to be carried out.

use std::time::Duration;

use crate::Settings;
use crate::clock;
use crate::settings::span;

/// How old what is carried out may be, and how long that may take; 0 where it does not matter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TimeLimits {
    /// The longest ago that a placement may have been decided.
    pub(super) decision_age: Duration,
    /// How much longer than its motion a placement may take.
    pub(super) overdue: Duration,
}

impl TimeLimits {
    pub(crate) fn of(settings: &Settings) -> Self {
        Self {
            decision_age: span(settings.decision_age_limit_s),
            overdue: span(settings.overdue_s),
        }
    }

    /// Why a placement that was decided then, by the clock of this bridge, is not begun any more. 0 is not known.
    pub(super) fn expired(&self, decided_at_ns: u64) -> Option<String> {
        if self.decision_age.is_zero() || decided_at_ns == 0 {
            return None;
        }
        let limit_s = self.decision_age.as_secs_f64();
        match clock::age(decided_at_ns) {
            Some(age) if age <= self.decision_age => None,
            Some(age) => Some(format!(
                "it was decided {:.1} s ago, and decision_age_limit_s is {limit_s}: plan anew",
                age.as_secs_f64()
            )),
            None => Some("decided_at_ns: it was decided by another clock: plan anew".to_owned()),
        }
    }
}
