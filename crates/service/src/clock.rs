//! The time of day, as messages tell it, and the time by which things age.

use std::ops::Add;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rustix::time::{ClockId, clock_gettime};

/// Gives the nanoseconds since 1970.
pub fn now_ns() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |now| u64::try_from(now.as_nanos()).unwrap_or(u64::MAX))
}

/// A time by a clock that nobody sets, and that counts while the machine sleeps, which
/// [`Instant`](std::time::Instant)'s does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Boottime(Duration);

impl Boottime {
    /// Gives the time now.
    pub fn now() -> Self {
        let since_start = clock_gettime(ClockId::Boottime);
        Self(Duration::try_from(since_start).unwrap_or_default())
    }

    /// Gives the time that passed since.
    pub fn elapsed(self) -> Duration {
        Self::now().saturating_duration_since(self)
    }

    /// Gives the time from an earlier one to this; zero where that is later.
    pub fn saturating_duration_since(self, earlier: Self) -> Duration {
        self.0.saturating_sub(earlier.0)
    }

    /// Gives a time so much earlier; `None` where the machine had not started yet.
    pub fn checked_sub(self, span: Duration) -> Option<Self> {
        self.0.checked_sub(span).map(Self)
    }
}

impl Add<Duration> for Boottime {
    type Output = Self;

    fn add(self, span: Duration) -> Self {
        Self(self.0.saturating_add(span))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_counts_all_that_passed_since_the_machine_started() {
        let uptime = || {
            let text = std::fs::read_to_string("/proc/uptime").unwrap();
            let uptime_s: f64 = text.split(' ').next().unwrap().parse().unwrap();
            Duration::from_secs_f64(uptime_s)
        };
        // The system tells hundredths of a second.
        let (before, now) = (uptime(), Boottime::now());
        let after = uptime() + Duration::from_millis(20);
        assert!(before <= now.0 && now.0 <= after, "{now:?}");
        let later = now + Duration::from_secs(3);
        assert_eq!(later.saturating_duration_since(now).as_secs(), 3);
        assert_eq!(now.saturating_duration_since(later), Duration::ZERO);
        assert_eq!(now.checked_sub(after), None);
    }
}
