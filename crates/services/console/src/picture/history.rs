//! A figure over time, thinned out as it grows.

use serde::Serialize;

/// Maximum of values: as many are thinned out to half.
const MOST_KEPT: usize = 512;

/// The values of a figure, oldest first, each with its time in milliseconds since 1970. It is not
/// known from one without a value on.
#[derive(Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub(super) struct History {
    values: Vec<(u64, Option<f64>)>,
}

impl History {
    /// Notes a value, where it is another one than before.
    pub(super) fn note(&mut self, at_ms: u64, value: Option<f64>) {
        if self.values.last().is_some_and(|(_, last)| *last == value) {
            return;
        }
        if self.values.len() >= MOST_KEPT {
            let mut is_kept = false;
            self.values.retain(|_| {
                is_kept = !is_kept;
                is_kept
            });
        }
        self.values.push((at_ms, value));
    }

    pub(super) fn clear(&mut self) {
        self.values.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_kept_and_thinned_out_as_they_grow_older() {
        let mut history = History::default();
        for at_ms in 0..10_000 {
            history.note(at_ms, Some(at_ms as f64 / 10_000.0));
            history.note(at_ms + 1, Some(at_ms as f64 / 10_000.0));
        }
        let values = &history.values;
        assert!((MOST_KEPT / 2..=MOST_KEPT).contains(&values.len()));
        assert_eq!((values[0].0, values[values.len() - 1].0), (0, 9_999));
        assert!(values.is_sorted_by_key(|(at_ms, _)| *at_ms));
        history.clear();
        assert_eq!(history, History::default());
    }
}
