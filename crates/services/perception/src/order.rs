//! The order of clouds: which are newer than those before.

use std::time::Duration;

use ppnpack_service::clock::Boottime;

/// Tells clouds that are newer than those before from those that are late.
///
/// Within a state of the cell, the sensor's count decides. A sensor or a bridge that begins anew
/// counts from the beginning; it is believed once nothing newer came for a while.
#[derive(Debug, Clone)]
pub(crate) struct CloudOrder {
    restart_after: Duration,
    last: Option<Last>,
}

#[derive(Debug, Clone, Copy)]
struct Last {
    state_number: u64,
    sequence: u64,
    at: Boottime,
}

impl CloudOrder {
    pub(crate) fn new(restart_after: Duration) -> Self {
        Self {
            restart_after,
            last: None,
        }
    }

    /// Says whether a cloud is news; it is then the last.
    pub(crate) fn accept(&mut self, state_number: u64, sequence: u64, at: Boottime) -> bool {
        let is_news = self.last.is_none_or(|last| {
            (state_number, sequence) > (last.state_number, last.sequence)
                || at.saturating_duration_since(last.at) >= self.restart_after
        });
        if is_news {
            self.last = Some(Last {
                state_number,
                sequence,
                at,
            });
        }
        is_news
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_clouds_are_refused_until_the_sensor_counts_anew() {
        let mut order = CloudOrder::new(Duration::from_secs(2));
        let start = Boottime::now();
        let mut accept = |state, sequence, after_ms| {
            order.accept(state, sequence, start + Duration::from_millis(after_ms))
        };
        assert!(accept(7, 10, 0));
        assert!(!accept(7, 10, 1), "the same again");
        assert!(!accept(7, 9, 2), "out of order");
        assert!(accept(7, 11, 3));
        assert!(!accept(6, 12, 4), "of an earlier state");
        assert!(
            accept(8, 1, 5),
            "of a later state, from a bridge that began anew"
        );
        assert!(!accept(1, 1, 1000));
        assert!(accept(1, 2, 2005), "nothing newer came for two seconds");
        assert!(accept(1, 3, 2006));
    }
}
