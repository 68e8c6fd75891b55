//! The events of a cell, in words.

use std::collections::VecDeque;

use serde::Serialize;

const MOST_KEPT: usize = 200;

/// The weight of an event to an operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Level {
    Info,
    Warning,
    Error,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Event {
    /// Counts the events of the cell, from 1.
    number: u64,
    /// When it was heard of, in milliseconds since 1970.
    at_ms: u64,
    level: Level,
    kind: String,
    text: String,
}

/// The last events, oldest first.
#[derive(Debug, Default, Serialize)]
#[serde(transparent)]
pub(super) struct Log {
    events: VecDeque<Event>,
}

impl Log {
    pub(super) fn note(&mut self, at_ms: u64, level: Level, kind: &str, text: String) {
        let number = self.events.back().map_or(1, |last| last.number + 1);
        if self.events.len() >= MOST_KEPT {
            self.events.pop_front();
        }
        self.events.push_back(Event {
            number,
            at_ms,
            level,
            kind: kind.to_owned(),
            text,
        });
    }

    #[cfg(test)]
    pub(super) fn kinds(&self) -> Vec<&str> {
        self.events
            .iter()
            .map(|event| event.kind.as_str())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_events_are_kept_and_numbered() {
        let mut log = Log::default();
        for index in 0..2 * MOST_KEPT {
            log.note(7, Level::Info, "placed", index.to_string());
        }
        assert_eq!(log.events.len(), MOST_KEPT);
        let numbers = (log.events[0].number, log.events[MOST_KEPT - 1].number);
        assert_eq!(numbers, (MOST_KEPT as u64 + 1, 2 * MOST_KEPT as u64));
    }
}
