//! Clouds that were held up on their way.

use std::time::Duration;

use ppnpack_service::clock::Boottime;

/// Maximum growth of a cloud's way in a second that is no delay: clocks drift apart. NTP sets them
/// by no more than 0.5 ms a second.
const DRIFT_NS_PER_S: i128 = 500_000;

/// Minimum number of clouds in a row that come as they were captured, before a delay is believed:
/// some sensors' times of capture are no times at all.
const STEADY_CLOUDS: u32 = 8;

/// Maximum growth of the way of clouds that come as they were captured.
const STEADY_NS: i128 = 50_000_000;

/// Tells when a cloud of a sensor would have come if nothing had held it up.
///
/// A cloud that is held up, by a process that was stopped or a network that was away, comes long
/// after it was captured. The clock of the sensor is another one, and may be set at any time. So
/// only the growth of the time from capture to arrival is used, while times of capture grow, and
/// have grown with those here.
#[derive(Debug, Clone, Default)]
pub(crate) struct Delays {
    last: Option<Last>,
}

#[derive(Debug, Clone, Copy)]
struct Last {
    /// The arrival of the first cloud.
    began: Boottime,
    captured_at_ns: i64,
    /// The arrival, since `began`.
    since_ns: i128,
    /// The time from the capture, by the sensor's clock, to the arrival since `began`, where
    /// nothing holds a cloud up.
    way_ns: i128,
    /// Clouds before that came as they were captured.
    steady: u32,
}

impl Delays {
    /// Says whether enough clouds came as they were captured to tell when one is held up.
    pub(crate) fn are_known(&self) -> bool {
        self.last.is_some_and(|last| last.steady > STEADY_CLOUDS)
    }

    /// Gives the time at which a cloud would have come if nothing had held it up. The clouds of a
    /// sensor come in their order.
    pub(crate) fn undelayed(&mut self, captured_at_ns: i64, at: Boottime) -> Boottime {
        let began = self.last.map_or(at, |last| last.began);
        let since_ns = i128::try_from(at.saturating_duration_since(began).as_nanos());
        let since_ns = since_ns.unwrap_or_default();
        let way_ns = since_ns - i128::from(captured_at_ns);
        let known = self.last.filter(|last| {
            let longer_ns = way_ns - last.way_ns;
            captured_at_ns > last.captured_at_ns
                && (last.steady >= STEADY_CLOUDS || longer_ns <= STEADY_NS)
        });
        let expected_ns = known.map_or(way_ns, |last| {
            let drift_ns = (since_ns - last.since_ns) * DRIFT_NS_PER_S / 1_000_000_000;
            way_ns.min(last.way_ns + drift_ns)
        });
        let steady = known.map_or(0, |last| last.steady.saturating_add(1));
        self.last = Some(Last {
            began,
            captured_at_ns,
            since_ns,
            way_ns: expected_ns,
            steady,
        });
        if !self.are_known() {
            return at;
        }
        let delay_ns = u64::try_from(way_ns - expected_ns).unwrap_or(u64::MAX);
        let undelayed = at.checked_sub(Duration::from_nanos(delay_ns));
        undelayed.unwrap_or(began)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A time of capture by a clock of its own, in milliseconds.
    fn captured_ms(ms: i64) -> i64 {
        (1_700_000_000_000 + ms) * 1_000_000
    }

    /// Delays of clouds, by when they were captured and when they came, in milliseconds.
    fn delays_ms(clouds: impl IntoIterator<Item = (i64, u64)>) -> Vec<u128> {
        let (mut delays, start) = (Delays::default(), Boottime::now());
        let delay = |(captured, came): (i64, u64)| {
            let at = start + Duration::from_millis(came);
            let undelayed = delays.undelayed(captured_ms(captured), at);
            at.saturating_duration_since(undelayed).as_millis()
        };
        clouds.into_iter().map(delay).collect()
    }

    #[test]
    fn delays_are_known_after_some_clouds_that_came_as_they_were_captured() {
        let (mut delays, start) = (Delays::default(), Boottime::now());
        let clouds = [(0, 20), (100, 320)].into_iter();
        let steady = (2..11).map(|number| (number * 100, number as u64 * 100 + 30));
        let are_known = clouds.chain(steady).map(|(captured, came)| {
            delays.undelayed(captured_ms(captured), start + Duration::from_millis(came));
            delays.are_known()
        });
        // The second one was held up, so they are counted from there.
        let are_known: Vec<bool> = are_known.collect();
        assert_eq!(are_known, [vec![false; 10], vec![true]].concat());
    }

    /// Ten clouds a second that take 20 ms each, for two seconds.
    fn steady() -> impl Iterator<Item = (i64, u64)> {
        (0..20).map(|number| (number * 100, number as u64 * 100 + 20))
    }

    #[test]
    fn clouds_that_queued_while_the_process_was_stopped_are_as_old_as_they_are() {
        let captured = [2_000, 2_100, 2_800, 7_000, 7_100];
        let queued = captured
            .into_iter()
            .zip([7_000, 7_001, 7_002, 7_020, 7_120]);
        let found = delays_ms(steady().chain(queued)).split_off(20);
        for (found, expected) in found.iter().zip([4_980, 4_881, 4_182, 0, 0]) {
            assert!(found.abs_diff(expected) <= 50, "{found} is not {expected}");
        }
    }

    #[test]
    fn a_clock_that_is_set_delays_nothing() {
        let hour = 3_600_000;
        let set = [
            (hour, 2_120),
            (hour + 100, 2_220),
            (-hour, 2_320),
            (-hour + 100, 2_420),
            (400 * 24 * hour, 2_520),
            (520, 2_620),
        ];
        assert_eq!(delays_ms(steady().chain(set)), [0; 26]);
    }

    #[test]
    fn what_is_no_time_says_nothing() {
        assert_eq!(delays_ms([(0, 0), (0, 1_000), (0, 60_000)]), [0; 3]);
        let counts = (0..1_000).map(|number| (number, number as u64 * 33));
        assert_eq!(delays_ms(counts), [0; 1_000]);
        let mut delays = Delays::default();
        let now = Boottime::now();
        for captured_at_ns in [i64::MIN, i64::MAX, 0, i64::MIN] {
            assert_eq!(delays.undelayed(captured_at_ns, now), now);
        }
    }

    #[test]
    fn a_clock_that_drifts_as_much_as_clocks_do_delays_nothing() {
        let clouds = (0..10_000).map(|number| (number * 9_996, number as u64 * 10_000));
        let found = delays_ms(clouds);
        assert!(found.iter().all(|delay_ms| *delay_ms == 0));
    }

    #[test]
    fn a_way_that_becomes_longer_cloud_by_cloud_is_a_delay() {
        // 30 Hz, 1.9 ms more each: a link that fills up. After a minute clouds are 3.4 s old.
        let clouds = (0..1_800).map(|number| (number * 33, number as u64 * 349 / 10));
        let last_ms = delays_ms(clouds).pop().unwrap();
        assert!((3_300..3_450).contains(&last_ms), "{last_ms}");
    }
}
