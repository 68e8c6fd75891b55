//! What pages show, in parts, each with the number of the change that made it.
//!
//! Nothing waits for a page: a page asks for what changed since the last number that it had. One that is slow gets the newest value of each
//! part and misses those between.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ppnpack_wire::keys::Cell;
use serde::Serialize;
use serde_json::value::RawValue;
use tokio::sync::watch;

/// Which part, of all, of a cell or of one of its containers.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct PartKey {
    pub(crate) cell: Option<Cell>,
    pub(crate) container: Option<Cell>,
    pub(crate) part: &'static str,
}

impl PartKey {
    pub(crate) fn of_all(part: &'static str) -> Self {
        Self {
            cell: None,
            container: None,
            part,
        }
    }

    pub(crate) fn of_cell(cell: &Cell, part: &'static str) -> Self {
        Self {
            cell: Some(cell.clone()),
            container: None,
            part,
        }
    }

    pub(crate) fn of_container(cell: &Cell, container: &Cell, part: &'static str) -> Self {
        Self {
            cell: Some(cell.clone()),
            container: Some(container.clone()),
            part,
        }
    }
}

/// A part as it is sent.
#[derive(Serialize)]
struct Part<'a> {
    cell: Option<&'a str>,
    container: Option<&'a str>,
    part: &'static str,
    revision: u64,
    value: &'a RawValue,
}

/// A part as it is kept.
struct Kept {
    revision: u64,
    value: Box<RawValue>,
    /// The whole part as JSON.
    text: Arc<str>,
}

/// What changed since a revision.
pub(crate) struct Changes {
    /// The newest revision.
    pub(crate) revision: u64,
    /// The parts, each as JSON, in the order in which they changed.
    pub(crate) parts: Vec<Arc<str>>,
}

/// All parts.
pub(crate) struct Board {
    parts: Mutex<BTreeMap<PartKey, Kept>>,
    /// The newest revision.
    revision: watch::Sender<u64>,
}

impl Default for Board {
    fn default() -> Self {
        Self {
            parts: Mutex::default(),
            revision: watch::Sender::new(0),
        }
    }
}

impl Board {
    /// Puts the value of a part, where it is another one than before.
    pub(crate) fn put(&self, key: PartKey, value: &impl Serialize) {
        let value = match serde_json::value::to_raw_value(value) {
            Ok(value) => value,
            Err(error) => {
                return tracing::error!(part = key.part, %error, "a part cannot be written");
            }
        };
        let mut parts = self.parts();
        if parts
            .get(&key)
            .is_some_and(|kept| kept.value.get() == value.get())
        {
            return;
        }
        // Only here, and under the lock, is it counted up.
        let revision = *self.revision.borrow() + 1;
        let part = Part {
            cell: key.cell.as_ref().map(Cell::as_str),
            container: key.container.as_ref().map(Cell::as_str),
            part: key.part,
            revision,
            value: &value,
        };
        let text = match serde_json::to_string(&part) {
            Ok(text) => text.into(),
            Err(error) => {
                return tracing::error!(part = key.part, %error, "a part cannot be written");
            }
        };
        parts.insert(
            key,
            Kept {
                revision,
                value,
                text,
            },
        );
        self.revision.send_replace(revision);
    }

    /// The parts that changed after a revision; after 0: all of them.
    pub(crate) fn since(&self, revision: u64) -> Changes {
        let parts = self.parts();
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

    /// Tells of every change from now on.
    pub(crate) fn watch(&self) -> watch::Receiver<u64> {
        self.revision.subscribe()
    }

    fn parts(&self) -> MutexGuard<'_, BTreeMap<PartKey, Kept>> {
        self.parts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn read(changes: &Changes) -> Vec<(String, Value)> {
        let parts = changes.parts.iter().map(|text| {
            let part: Value = serde_json::from_str(text).unwrap();
            (
                part["part"].as_str().unwrap().to_owned(),
                part["value"].clone(),
            )
        });
        parts.collect()
    }

    #[test]
    fn who_asks_gets_the_newest_value_of_what_changed_since() {
        let board = Board::default();
        let mut watch = board.watch();
        board.put(PartKey::of_all("a"), &1);
        board.put(PartKey::of_all("b"), &1);
        let first = board.since(0);
        assert_eq!(
            read(&first),
            [("a".to_owned(), json!(1)), ("b".to_owned(), json!(1))]
        );
        for value in 2..100 {
            board.put(PartKey::of_all("a"), &value);
        }
        assert_eq!(
            read(&board.since(first.revision)),
            [("a".to_owned(), json!(99))]
        );
        assert!(watch.has_changed().unwrap());
        let newest = board.since(first.revision).revision;
        assert_eq!(*watch.borrow_and_update(), newest);
        board.put(PartKey::of_all("a"), &99);
        assert!(
            board.since(newest).parts.is_empty(),
            "the same is no change"
        );
        assert!(!watch.has_changed().unwrap());
    }

    #[test]
    fn a_part_says_what_it_is_of() {
        let board = Board::default();
        let [cell, container] = ["cell-1", "cell-1-a"].map(|name| Cell::new(name).unwrap());
        board.put(PartKey::of_container(&cell, &container, "items"), &[0; 0]);
        let text = board.since(0).parts[0].to_string();
        assert_eq!(
            text,
            r#"{"cell":"cell-1","container":"cell-1-a","part":"items","revision":1,"value":[]}"#
        );
    }
}
