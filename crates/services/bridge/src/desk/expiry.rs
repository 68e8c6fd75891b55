//! Decisions that are too old to be carried out.

use std::time::Duration;

use crate::Settings;
use crate::clock;
use crate::settings::span;

/// The limits in time of a placement; 0 where it does not matter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TimeLimits {
    /// The maximum age of a decision that begins.
    pub(super) decision_age: Duration,
    /// The maximum by which a placement may take longer than its motion.
    pub(super) overdue: Duration,
}

impl TimeLimits {
    pub(crate) fn of(settings: &Settings) -> Self {
        Self {
            decision_age: span(settings.decision_age_limit_s),
            overdue: span(settings.overdue_s),
        }
    }

    /// Says why a placement that was decided then, by the clock of this bridge, does not begin any
    /// more; 0 is not known.
    pub(super) fn expired(&self, decided_at_ns: u64) -> Option<String> {
        if self.decision_age.is_zero() || decided_at_ns == 0 {
            return None;
        }
        let limit_s = self.decision_age.as_secs_f64();
        let age = clock::now_ns().checked_sub(decided_at_ns);
        match age.map(Duration::from_nanos) {
            Some(age) if age <= self.decision_age => None,
            Some(age) => Some(format!(
                "it was decided {:.1} s ago, and decision_age_limit_s is {limit_s}: plan anew",
                age.as_secs_f64()
            )),
            None => Some("decided_at_ns: it was decided by another clock: plan anew".to_owned()),
        }
    }
}
