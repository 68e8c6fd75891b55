//! Orders of which more items are expected than were announced, and how long these are waited for.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::CellPlanner;

/// Orders that wait for items, with how many were announced of each, and when the wait for the next one is over.
#[derive(Debug, Default)]
pub(super) struct Expected(BTreeMap<String, (usize, Instant)>);

impl Expected {
    /// When an order is given up next.
    pub(super) fn next_expiry(&self) -> Option<Instant> {
        self.0.values().map(|(_, until)| *until).min()
    }

    /// Takes over which orders wait now. The wait of one begins anew with each item that is announced of it.
    fn note(&mut self, waiting: BTreeMap<String, usize>, until: Instant) {
        let known = std::mem::take(&mut self.0);
        let waiting = waiting.into_iter().map(|(order, announced)| {
            let before = known.get(&order);
            let same = before.filter(|(before, _)| *before == announced);
            let until = same.map_or(until, |(_, until)| *until);
            (order, (announced, until))
        });
        self.0 = waiting.collect();
    }

    fn due(&self, now: Instant) -> Vec<String> {
        let due = self.0.iter().filter(|(_, (_, until))| *until <= now);
        due.map(|(order, _)| order.clone()).collect()
    }
}

impl CellPlanner {
    /// Expects no more items of orders of which none was announced for as long as is set.
    pub(super) fn give_up_expecting(&mut self) {
        let Some(wait_s) = self.settings.closing.order_wait_s else {
            return;
        };
        let now = Instant::now();
        let until = now + Duration::from_secs_f64(wait_s);
        self.expected.note(self.session.unannounced(), until);
        for order in self.expected.due(now) {
            match self.change(|session| session.expects_no_more(&order)) {
                Ok(()) => {
                    tracing::info!(cell = %self.cell, order, "no more items are expected");
                }
                Err(refusal) => {
                    let reason = refusal.message;
                    tracing::warn!(cell = %self.cell, order, reason, "items are expected on");
                }
            }
            // Anew, where it could not be written down.
            self.expected.0.remove(&order);
        }
        self.expected.note(self.session.unannounced(), until);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wait_begins_anew_with_each_item_of_an_order() {
        let waiting = |announced| BTreeMap::from([("7".to_owned(), announced)]);
        let start = Instant::now();
        let after = |seconds| start + Duration::from_secs(seconds);
        let mut expected = Expected::default();
        assert_eq!(expected.next_expiry(), None);
        expected.note(waiting(1), after(10));
        expected.note(waiting(1), after(13));
        assert_eq!(expected.next_expiry(), Some(after(10)));
        assert_eq!(expected.due(after(9)), [] as [String; 0]);
        expected.note(waiting(2), after(19));
        assert_eq!(expected.due(after(18)), [] as [String; 0]);
        assert_eq!(expected.due(after(19)), ["7"]);
        expected.note(BTreeMap::new(), after(30));
        assert_eq!(expected.next_expiry(), None);
    }
}
