//! The content of pages, in parts, each with the number of the change that made it.
//!
//! Nothing waits for a page: a page asks for what changed since the last number that it had. A slow
//! one gets the newest value of each part and misses those between.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use ppnpack_service::sync::lock;
use ppnpack_wire::keys::Cell;
use serde_json::{Value, json};
use tokio::sync::watch;

/// The cell and the container of a part, where it has them, and its name.
type PartKey<'a> = (Option<&'a Cell>, Option<&'a Cell>, &'static str);

struct Kept {
    revision: u64,
    value: Value,
    /// The whole part as JSON.
    text: Arc<str>,
}

pub(crate) struct Changes {
    pub(crate) revision: u64,
    /// The parts, each as JSON, in the order in which they changed.
    pub(crate) parts: Vec<Arc<str>>,
}

type Parts = BTreeMap<(Option<Cell>, Option<Cell>, &'static str), Kept>;

#[derive(Default)]
pub(crate) struct Board {
    parts: Mutex<Parts>,
    revision: watch::Sender<u64>,
}

impl Board {
    /// Puts the value of a part, where it is another one than before.
    pub(crate) fn put(&self, (cell, container, part): PartKey<'_>, value: impl Into<Value>) {
        let value = value.into();
        let key = (cell.cloned(), container.cloned(), part);
        let mut parts = lock(&self.parts);
        if parts.get(&key).is_some_and(|kept| kept.value == value) {
            return;
        }
        // Only here, and under the lock, is it counted up.
        let revision = *self.revision.borrow() + 1;
        let text = json!({
            "cell": cell.map(Cell::as_str),
            "container": container.map(Cell::as_str),
            "part": part,
            "revision": revision,
            "value": value,
        });
        let kept = Kept {
            revision,
            value,
            text: text.to_string().into(),
        };
        parts.insert(key, kept);
        self.revision.send_replace(revision);
    }

    /// Gives the parts that changed after a revision; after 0: all of them.
    pub(crate) fn since(&self, revision: u64) -> Changes {
        let parts = lock(&self.parts);
        let mut newer: Vec<&Kept> = parts
            .values()
            .filter(|kept| kept.revision > revision)
            .collect();
        newer.sort_unstable_by_key(|kept| kept.revision);
        Changes {
            revision: newer.last().map_or(revision, |kept| kept.revision),
            parts: newer.into_iter().map(|kept| kept.text.clone()).collect(),
        }
    }

    pub(crate) fn watch(&self) -> watch::Receiver<u64> {
        self.revision.subscribe()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(changes: &Changes) -> Vec<(String, Value)> {
        let parts = changes.parts.iter().map(|text| {
            let mut part: Value = serde_json::from_str(text).unwrap();
            let name = part["part"].as_str().unwrap().to_owned();
            (name, part["value"].take())
        });
        parts.collect()
    }

    #[test]
    fn who_asks_gets_the_newest_value_of_what_changed_since() {
        let board = Board::default();
        let mut watch = board.watch();
        let [a, b] = ["a", "b"].map(|part| (None, None, part));
        board.put(a, 1);
        board.put(b, 1);
        let first = board.since(0);
        let both = [("a".to_owned(), json!(1)), ("b".to_owned(), json!(1))];
        assert_eq!(read(&first), both);
        for value in 2..100 {
            board.put(a, value);
        }
        let changes = board.since(first.revision);
        assert_eq!(read(&changes), [("a".to_owned(), json!(99))]);
        assert!(watch.has_changed().unwrap());
        let newest = changes.revision;
        assert_eq!(*watch.borrow_and_update(), newest);
        board.put(a, 99);
        let same = board.since(newest);
        assert!(same.parts.is_empty(), "the same is no change");
        assert!(!watch.has_changed().unwrap());
    }
}
