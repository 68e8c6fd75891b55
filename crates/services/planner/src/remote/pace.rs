//! Whether a search is done sooner here or by the heuristic services: what both took tells.

use std::time::Duration;

/// How much of an estimate is the newest time.
const WEIGHT: f64 = 0.2;

/// After so many searches the slower way is taken once, so that its estimate does not grow old.
const REMEASURED_AFTER: u64 = 256;

/// What searches took.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    /// Seconds a placement takes here.
    here: Option<f64>,
    /// Seconds that asking the services takes beyond their share of the work.
    asking: Option<f64>,
    searches: u64,
}

impl Pace {
    /// Whether to search here. `placements` are to be searched, by `replicas` services otherwise.
    pub(crate) fn is_sooner_here(&mut self, placements: u64, replicas: usize) -> bool {
        let (Some(here), Some(asking)) = (self.here, self.asking) else {
            // Both are measured first, this process before the others.
            return self.here.is_none();
        };
        self.searches += 1;
        let alone = here * placements as f64;
        let is_sooner = alone <= asking + alone / replicas.max(1) as f64;
        is_sooner != self.searches.is_multiple_of(REMEASURED_AFTER)
    }

    /// What a search of so many placements takes here, once that is known.
    pub(crate) fn expected_here(&self, placements: u64) -> Option<Duration> {
        let seconds = self.here? * placements as f64;
        Duration::try_from_secs_f64(seconds).ok()
    }

    /// Notes a search in this process.
    pub(crate) fn searched_here(&mut self, placements: u64, took: Duration) {
        let each = took.as_secs_f64() / placements.max(1) as f64;
        self.here = Some(newer(self.here, each));
    }

    /// Notes a search by services.
    pub(crate) fn asked(&mut self, placements: u64, replicas: usize, took: Duration) {
        let share = placements as f64 / replicas.max(1) as f64;
        let work = self.here.unwrap_or_default() * share;
        let beyond = (took.as_secs_f64() - work).max(0.0);
        self.asking = Some(newer(self.asking, beyond));
    }
}

fn newer(old: Option<f64>, new: f64) -> f64 {
    old.map_or(new, |old| old + WEIGHT * (new - old))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASKING: Duration = Duration::from_millis(1);

    /// A pace at which a placement takes a microsecond here, and asking a millisecond.
    fn pace() -> Pace {
        let mut pace = Pace::default();
        assert!(pace.is_sooner_here(100, 2), "nothing is known yet");
        pace.searched_here(1000, Duration::from_millis(1));
        assert!(
            !pace.is_sooner_here(100, 2),
            "the services are not known yet"
        );
        pace.asked(1000, 2, ASKING + Duration::from_micros(500));
        pace
    }

    #[test]
    fn little_work_is_done_here_and_much_is_shared() {
        let mut pace = pace();
        assert!(pace.is_sooner_here(1000, 2));
        assert!(!pace.is_sooner_here(10_000, 2));
        // One replica has as much to do as this process.
        assert!(pace.is_sooner_here(10_000, 1));
    }

    #[test]
    fn what_changes_is_noticed() {
        let mut pace = pace();
        for _ in 0..50 {
            pace.searched_here(1000, Duration::from_millis(20));
        }
        assert!(!pace.is_sooner_here(1000, 2), "this process is slow now");
        let other_ways = (0..REMEASURED_AFTER).filter(|_| pace.is_sooner_here(1000, 2));
        assert_eq!(other_ways.count(), 1, "looked at again once in a while");
    }
}
