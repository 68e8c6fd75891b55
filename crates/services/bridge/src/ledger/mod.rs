//! What is known of a cell: what was asked for, how it ended, and what lies in the container.
//!
//! A [`Ledger`] only answers and computes [`Change`]s. Each is written to the journal first and applied then, so that
//! the ledger is never ahead of the disk.
//!
//! Placements are executed at most once for two reasons. Their ids are remembered, and each names the state of the cell
//! that it was planned on: whatever changes the container counts the state up, so that a placement whose id was
//! forgotten, or lost with the journal, is stale. A ledger without a past begins at a state that no earlier one had.

use std::collections::{BTreeMap, HashMap};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::robot::{Body, Ending, Finding, Placement};

/// How many placements and renewals are remembered.
pub(crate) const MAX_RECORDS: usize = 10_000;

/// How many low bits of a first state number are random; the milliseconds since 1970 stand above them.
const RANDOM_BITS: u32 = 20;

/// How a placement ended, and the state of the cell afterwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) finding: Finding,
    pub(crate) state_number: u64,
}

/// Something that was asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) enum Record {
    /// A placement; without an outcome while it is executed.
    Placement {
        placement: Box<Placement>,
        outcome: Option<Outcome>,
    },
    /// A renewal of the container; without a state number while it is under way.
    Renewal {
        request_id: String,
        state_number: Option<u64>,
    },
}

/// What is known of the cell as it is now.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Head {
    /// Counts the changes of the container's content.
    pub(crate) state_number: u64,
    /// The number of the next record.
    pub(crate) next: u64,
    /// What lies in the container.
    pub(crate) bodies: Vec<Body>,
}

/// A step of a ledger, to be written down and then applied.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Change {
    pub(crate) head: Head,
    pub(crate) written: Option<(u64, Record)>,
    pub(crate) forgotten: Vec<u64>,
}

impl Change {
    fn of(head: Head) -> Self {
        Self {
            head,
            written: None,
            forgotten: Vec::new(),
        }
    }
}

/// The records of a cell and its content, as the journal has them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ledger {
    head: Head,
    records: BTreeMap<u64, Record>,
    placements: HashMap<String, u64>,
    renewals: HashMap<String, u64>,
    /// The record without an end.
    under_way: Option<u64>,
}

/// What is to be done about a placement.
#[derive(Debug, PartialEq)]
pub(crate) enum PlacementVerdict<'a> {
    /// It was asked for before; how it ended, if it did.
    Known(Option<&'a Outcome>),
    /// Its id was used for another one.
    Conflict,
    /// Something else is under way.
    Busy,
    /// It was planned on another state.
    Stale,
    /// It can be executed.
    New,
}

/// What is to be done about a renewal.
#[derive(Debug, PartialEq)]
pub(crate) enum RenewalVerdict {
    /// It has happened; the state afterwards.
    Done(u64),
    /// It is under way.
    UnderWay,
    /// Something else is under way.
    Busy,
    /// It can begin.
    New,
}

impl Ledger {
    /// A ledger without a past: an empty container, at a state that no placement was planned on.
    ///
    /// The time alone would do where clocks only go forward; the random bits are for those that do not.
    pub(crate) fn new() -> Self {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
        let milliseconds = since_1970.map_or(0, |since_1970| since_1970.as_millis() as u64);
        let random = rand::random::<u64>() >> (u64::BITS - RANDOM_BITS);
        Self::of(
            Head {
                state_number: milliseconds << RANDOM_BITS | random,
                next: 1,
                bodies: Vec::new(),
            },
            BTreeMap::new(),
        )
    }

    /// A ledger as it was written down.
    pub(crate) fn of(head: Head, records: BTreeMap<u64, Record>) -> Self {
        let mut ledger = Self {
            head,
            records: BTreeMap::new(),
            placements: HashMap::new(),
            renewals: HashMap::new(),
            under_way: None,
        };
        for (number, record) in records {
            ledger.insert(number, record);
        }
        ledger
    }

    pub(crate) fn head(&self) -> &Head {
        &self.head
    }

    pub(crate) fn records(&self) -> impl Iterator<Item = (u64, &Record)> {
        self.records
            .iter()
            .map(|(number, record)| (*number, record))
    }

    /// What is being done.
    pub(crate) fn under_way(&self) -> Option<&Record> {
        self.records.get(&self.under_way?)
    }

    /// A placement, and how it ended, if it did.
    pub(crate) fn placement(&self, id: &str) -> Option<(&Placement, Option<&Outcome>)> {
        match self.records.get(self.placements.get(id)?)? {
            Record::Placement { placement, outcome } => Some((placement, outcome.as_ref())),
            Record::Renewal { .. } => None,
        }
    }

    /// What is to be done about a placement.
    pub(crate) fn judge(&self, asked: &Placement) -> PlacementVerdict<'_> {
        match self.placement(&asked.placement_id) {
            Some((known, outcome)) if known.is_same(asked) => PlacementVerdict::Known(outcome),
            Some(_) => PlacementVerdict::Conflict,
            None if self.under_way.is_some() => PlacementVerdict::Busy,
            None if asked.state_number != self.head.state_number => PlacementVerdict::Stale,
            None => PlacementVerdict::New,
        }
    }

    /// What is to be done about a renewal.
    pub(crate) fn judge_renewal(&self, request_id: &str) -> RenewalVerdict {
        let number = self.renewals.get(request_id);
        match number.and_then(|number| self.records.get(number)) {
            Some(Record::Renewal {
                state_number: Some(state_number),
                ..
            }) => RenewalVerdict::Done(*state_number),
            Some(_) => RenewalVerdict::UnderWay,
            None if self.under_way.is_some() => RenewalVerdict::Busy,
            None => RenewalVerdict::New,
        }
    }

    /// A placement is accepted.
    pub(crate) fn accept(&self, placement: Placement) -> Change {
        self.begin(Record::Placement {
            placement: Box::new(placement),
            outcome: None,
        })
    }

    /// A renewal begins.
    pub(crate) fn begin_renewal(&self, request_id: String) -> Change {
        self.begin(Record::Renewal {
            request_id,
            state_number: None,
        })
    }

    /// What is under way has ended with this finding, and the container holds these bodies.
    pub(crate) fn end_placement(&self, finding: Finding, bodies: Vec<Body>) -> Change {
        let head = self.head_with(bodies, finding.ending != Ending::NotPlaced);
        let state_number = head.state_number;
        self.end(head, |record| {
            if let Record::Placement { placement, outcome } = record {
                *outcome = Some(Outcome {
                    finding,
                    state_number,
                });
                // It is long, and nobody asks for it any more.
                placement.cycle = None;
            }
        })
    }

    /// The renewal under way has happened.
    pub(crate) fn end_renewal(&self, bodies: Vec<Body>) -> Change {
        let head = self.head_with(bodies, true);
        let after = head.state_number;
        self.end(head, |record| {
            if let Record::Renewal { state_number, .. } = record {
                *state_number = Some(after);
            }
        })
    }

    /// The renewal under way has failed, or nobody knows: it can be asked for again.
    pub(crate) fn abandon_renewal(&self, bodies: Vec<Body>) -> Change {
        Change {
            forgotten: self.under_way.into_iter().collect(),
            ..self.find_bodies(bodies)
        }
    }

    /// The container turned out to hold other bodies than was thought.
    pub(crate) fn find_bodies(&self, bodies: Vec<Body>) -> Change {
        Change::of(self.head_with(bodies, true))
    }

    /// Nothing: to try whether it can be written down.
    pub(crate) fn no_change(&self) -> Change {
        Change::of(self.head.clone())
    }

    /// What was under way when the bridge was cut off; `None` where nothing was.
    ///
    /// A simulated cell is what was written down, so that it did not happen there. What another cell did is not known.
    pub(crate) fn recover(&self, is_simulated: bool) -> Option<Change> {
        let bodies = self.head.bodies.clone();
        Some(match (self.under_way()?, is_simulated) {
            (Record::Placement { .. }, true) => {
                let failure = "the bridge was restarted before it was carried out";
                self.end_placement(Finding::failed(Ending::NotPlaced, failure), bodies)
            }
            (Record::Placement { .. }, false) => {
                let failure = "the bridge was restarted while it was carried out";
                self.end_placement(Finding::failed(Ending::Unknown, failure), bodies)
            }
            (Record::Renewal { .. }, true) => self.abandon_renewal(bodies),
            (Record::Renewal { .. }, false) => self.abandon_renewal(Vec::new()),
        })
    }

    /// Takes a step that was written down.
    pub(crate) fn apply(&mut self, change: Change) {
        self.head = change.head;
        for number in change.forgotten {
            self.remove(number);
        }
        if let Some((number, record)) = change.written {
            self.insert(number, record);
        }
    }

    fn begin(&self, record: Record) -> Change {
        let mut head = self.head.clone();
        let number = head.next;
        head.next += 1;
        Change {
            written: Some((number, record)),
            ..Change::of(head)
        }
    }

    /// The head when the container holds these bodies, as a new state where that is a change.
    fn head_with(&self, bodies: Vec<Body>, is_changed: bool) -> Head {
        Head {
            state_number: self.head.state_number + u64::from(is_changed),
            next: self.head.next,
            bodies,
        }
    }

    /// Ends what is under way, and forgets the oldest records where they are too many.
    fn end(&self, mut head: Head, end: impl FnOnce(&mut Record)) -> Change {
        let written = self.under_way.and_then(|number| {
            let mut record = self.records.get(&number)?.clone();
            end(&mut record);
            Some((number, record))
        });
        let surplus = self.records.len().saturating_sub(MAX_RECORDS);
        let oldest = self.records.iter().take(surplus);
        let is_of_now = |record: &Record| match record {
            Record::Placement { placement, .. } => placement.state_number == head.state_number,
            Record::Renewal { .. } => false,
        };
        // Forgotten, it must not be executed again: the state that it was planned on has to be past.
        if oldest.clone().any(|(_, record)| is_of_now(record)) {
            head.state_number += 1;
        }
        Change {
            head,
            written,
            forgotten: oldest.map(|(number, _)| *number).collect(),
        }
    }

    fn insert(&mut self, number: u64, record: Record) {
        let has_ended = match &record {
            Record::Placement { placement, outcome } => {
                self.placements
                    .insert(placement.placement_id.clone(), number);
                outcome.is_some()
            }
            Record::Renewal {
                request_id,
                state_number,
            } => {
                self.renewals.insert(request_id.clone(), number);
                state_number.is_some()
            }
        };
        if !has_ended {
            self.under_way = Some(number);
        } else if self.under_way == Some(number) {
            self.under_way = None;
        }
        self.records.insert(number, record);
    }

    fn remove(&mut self, number: u64) {
        match self.records.remove(&number) {
            Some(Record::Placement { placement, .. }) => {
                self.placements.remove(&placement.placement_id);
            }
            Some(Record::Renewal { request_id, .. }) => {
                self.renewals.remove(&request_id);
            }
            None => {}
        }
        if self.under_way == Some(number) {
            self.under_way = None;
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
