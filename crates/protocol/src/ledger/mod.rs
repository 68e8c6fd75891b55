//! The ledger of a cell: its placements and renewals, their ends, and the content of the container.
//!
//! A [`Ledger`] only answers and computes [`Change`]s. Each is written to the journal first and
//! applied then, so that the ledger is never ahead of the disk.
//!
//! Placements are executed at most once for two reasons. Their ids are remembered, as idempotency
//! keys. And each names the state of the cell that it was planned on, which every change of the
//! container counts up: one whose id was forgotten, or lost with the journal, is of a past state.
//! A ledger without a past begins at a state that no earlier one had.
//!
//! A ledger knows all placements on the states from [`Head::first_state_number`] on. Only of those
//! states does it say that a placement was never begun.

mod holds;

use std::collections::BTreeMap;
use std::time::UNIX_EPOCH;

use ppnpack_wire::v1::Status;
use serde::{Deserialize, Serialize};

use crate::placing::{Body, Ending, Finding, Placement};
pub use holds::{AFTER_ANOTHER, BRIDGE, FROM_BACKUP, Hold, Holds};
use holds::{PLACEMENT_CUT_OFF, RENEWAL_CUT_OFF};

/// Maximum number of placements and renewals that are remembered: hours of a cell's work, at a
/// kilobyte each. Placements that were planned before are [`PlacementVerdict::Forgotten`].
pub const MAX_RECORDS: usize = 1_000;

/// Number of random low bits of a first state number, below the milliseconds since 1970.
const RANDOM_BITS: u32 = 20;

/// Maximum number of changes that a cell makes between a backup and its restoring, and more.
const MOST_CHANGES: u64 = 1 << 32;

/// Number of high zero bits of the random part that a restored state number is moved on by;
/// thousands of restorings find room.
const RESTORE_SHIFT: u32 = 12;

/// The end of a placement, and the state of the cell afterwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The robot's finding.
    pub finding: Finding,
    /// The state of the cell afterwards.
    pub state_number: u64,
}

/// The record of a request.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Record {
    /// A placement; without an outcome while it is executed.
    Placement {
        /// The placement.
        placement: Box<Placement>,
        /// Its end, where it has ended.
        outcome: Option<Outcome>,
    },
    /// A renewal of the container; without a state number while it is under way.
    Renewal {
        /// The name of the renewal, its idempotency key.
        request_id: String,
        /// The state of the cell afterwards, where it has happened.
        state_number: Option<u64>,
    },
}

impl Record {
    fn has_ended(&self) -> bool {
        match self {
            Self::Placement { outcome, .. } => outcome.is_some(),
            Self::Renewal { state_number, .. } => state_number.is_some(),
        }
    }
}

/// The cell as it is now.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// The number of the state, which counts the changes of the container's content.
    pub state_number: u64,
    /// The first state of which every placement is known.
    pub first_state_number: u64,
    /// The holds, for which nothing is begun.
    pub holds: Holds,
    /// The number of placements that may begin before the cell holds itself; 0: any number.
    pub placements_left: u32,
    /// The number of the next record.
    pub next: u64,
    /// The content of the container.
    pub bodies: Vec<Body>,
}

/// A change of a ledger, to be written down and then applied.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The cell after it.
    pub head: Head,
    /// The record that is new or has changed, with its number.
    pub written: Option<(u64, Record)>,
    /// The numbers of the records that are forgotten.
    pub forgotten: Vec<u64>,
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
pub struct Ledger {
    head: Head,
    /// At most one, the last, has no end.
    records: BTreeMap<u64, Record>,
}

/// The verdict on a placement that is asked for.
#[derive(Debug, PartialEq)]
pub enum PlacementVerdict<'a> {
    /// It was asked for before; its end, if it has ended.
    Known(Option<&'a Outcome>),
    /// Its id was used for another one.
    Conflict,
    /// Something else is under way.
    Busy,
    /// It was planned on a past state, and was never begun.
    Stale,
    /// It was planned on a state of which not all placements are known.
    Forgotten,
    /// Nothing is begun, for these reasons.
    Held(&'a Holds),
    /// It can be executed.
    New,
}

/// The verdict on a renewal that is asked for.
#[derive(Debug, PartialEq)]
pub enum RenewalVerdict<'a> {
    /// It has happened; the state afterwards.
    Done(u64),
    /// It is under way.
    UnderWay,
    /// Something else is under way.
    Busy,
    /// Nothing is begun, for these reasons.
    Held(&'a Holds),
    /// It can begin.
    New,
}

/// Makes the number of a state that no placement was planned on.
///
/// The time alone would do where clocks only go forward; the random bits are for those that do not.
pub(crate) fn new_state_number() -> u64 {
    let since_1970 = UNIX_EPOCH.elapsed().unwrap_or_default();
    let milliseconds = since_1970.as_millis() as u64;
    let random = rand::random::<u64>() >> (u64::BITS - RANDOM_BITS);
    milliseconds << RANDOM_BITS | random
}

impl PlacementVerdict<'_> {
    /// Gives the status of a refusal; `None` where the placement is not refused.
    pub fn refusal(&self) -> Option<Status> {
        match self {
            Self::Known(_) | Self::New => None,
            Self::Conflict => Some(Status::Conflict),
            Self::Busy => Some(Status::Busy),
            Self::Stale => Some(Status::Stale),
            Self::Forgotten => Some(Status::Forgotten),
            Self::Held(_) => Some(Status::Held),
        }
    }
}

impl Ledger {
    /// Makes a ledger without a past: an empty container, at a state that no placement was planned
    /// on.
    pub fn without_past() -> Self {
        Self::beginning_at(new_state_number())
    }

    /// Makes a ledger without a past that begins at this state: one that no placement was planned
    /// on.
    pub fn beginning_at(state_number: u64) -> Self {
        Self::of(
            Head {
                state_number,
                first_state_number: state_number,
                holds: Holds::default(),
                placements_left: 0,
                next: 1,
                bodies: Vec::new(),
            },
            BTreeMap::new(),
        )
    }

    /// Makes a ledger as it was written down.
    pub fn of(head: Head, records: BTreeMap<u64, Record>) -> Self {
        Self { head, records }
    }

    /// Gives the cell as it is now.
    pub fn head(&self) -> &Head {
        &self.head
    }

    /// Gives the records with their numbers, in their order.
    pub fn records(&self) -> impl Iterator<Item = (u64, &Record)> {
        let records = self.records.iter();
        records.map(|(number, record)| (*number, record))
    }

    /// Gives the record without an end.
    pub fn under_way(&self) -> Option<&Record> {
        self.open().map(|(_, record)| record)
    }

    fn open(&self) -> Option<(u64, &Record)> {
        let mut records = self.records.iter().rev();
        let open = records.find(|(_, record)| !record.has_ended());
        open.map(|(number, record)| (*number, record))
    }

    /// Gives a placement with its end, if it has ended.
    pub fn placement(&self, id: &str) -> Option<(&Placement, Option<&Outcome>)> {
        self.records.values().rev().find_map(|record| match record {
            Record::Placement { placement, outcome } if placement.placement_id == id => {
                Some((placement.as_ref(), outcome.as_ref()))
            }
            _ => None,
        })
    }

    /// Judges a placement that is asked for.
    pub fn judge(&self, asked: &Placement) -> PlacementVerdict<'_> {
        match self.placement(&asked.placement_id) {
            Some((known, outcome)) if known.is_same(asked) => PlacementVerdict::Known(outcome),
            Some(_) => PlacementVerdict::Conflict,
            None if !self.knows_all_of(asked.state_number) => PlacementVerdict::Forgotten,
            None if asked.state_number != self.head.state_number => PlacementVerdict::Stale,
            None if self.open().is_some() => PlacementVerdict::Busy,
            None if self.is_held() => PlacementVerdict::Held(&self.head.holds),
            None => PlacementVerdict::New,
        }
    }

    /// Says whether all placements that were begun on a state are known. On state 0, which sensors
    /// send that know none, none ever is.
    fn knows_all_of(&self, state_number: u64) -> bool {
        let known = self.head.first_state_number..=self.head.state_number;
        state_number == 0 || known.contains(&state_number)
    }

    /// Judges a renewal that is asked for.
    pub fn judge_renewal(&self, id: &str) -> RenewalVerdict<'_> {
        let known = self.records.values().rev().find_map(|record| match record {
            Record::Renewal {
                request_id,
                state_number,
            } if request_id == id => Some(*state_number),
            _ => None,
        });
        match known {
            Some(Some(state_number)) => RenewalVerdict::Done(state_number),
            Some(None) => RenewalVerdict::UnderWay,
            None if self.open().is_some() => RenewalVerdict::Busy,
            None if self.is_held() => RenewalVerdict::Held(&self.head.holds),
            None => RenewalVerdict::New,
        }
    }

    /// Accepts a placement.
    pub fn accept(&self, placement: Placement) -> Change {
        let begun = self.begin(Record::Placement {
            placement: Box::new(placement),
            outcome: None,
        });
        begun.counted()
    }

    /// Begins a renewal.
    pub fn begin_renewal(&self, request_id: String) -> Change {
        self.begin(Record::Renewal {
            request_id,
            state_number: None,
        })
    }

    /// Ends the placement under way with this finding; the container holds these bodies.
    pub fn end_placement(&self, finding: Finding, bodies: Vec<Body>) -> Change {
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

    /// Ends the renewal under way, which has happened.
    pub fn end_renewal(&self, bodies: Vec<Body>) -> Change {
        let head = self.head_with(bodies, true);
        let after = head.state_number;
        self.end(head, |record| {
            if let Record::Renewal { state_number, .. } = record {
                *state_number = Some(after);
            }
        })
    }

    /// Abandons the renewal under way, which failed, or nobody knows: it can be asked for again.
    pub fn abandon_renewal(&self, bodies: Vec<Body>) -> Change {
        Change {
            forgotten: self.open().map(|(number, _)| number).into_iter().collect(),
            ..self.find_bodies(bodies)
        }
    }

    /// Replaces the bodies in the container, which turned out to be others.
    pub fn find_bodies(&self, bodies: Vec<Body>) -> Change {
        Change::of(self.head_with(bodies, true))
    }

    /// Counts a change by hand, with which some items were taken out.
    pub fn change_by_hand(&self, removed: &[String]) -> Change {
        let bodies = self.head.bodies.iter();
        let left = bodies.filter(|body| !removed.contains(&body.item_id));
        self.find_bodies(left.cloned().collect())
    }

    /// Changes nothing: to try whether it can be written down.
    pub fn no_change(&self) -> Change {
        Change::of(self.head.clone())
    }

    /// Settles the record under way when the bridge was cut off; `None` where there is none.
    ///
    /// A simulated cell is as it was written down, so that nothing happened there. What a real cell
    /// did is not known: it is held until somebody has looked, and its container counts as
    /// unchanged. A real cell without a past is held as well.
    pub fn recover(&self, is_simulated: bool) -> Option<Change> {
        let bodies = self.head.bodies.clone();
        let cut_off = |change: Change, reason| {
            let hold = Hold::own("cut-off", change.head.state_number, reason);
            change.holding(hold)
        };
        let Some(under_way) = self.under_way() else {
            return (!is_simulated).then(|| self.hold_without_past()).flatten();
        };
        Some(match (under_way, is_simulated) {
            (Record::Placement { .. }, true) => {
                let failure = "the bridge was restarted before it was carried out";
                self.end_placement(Finding::failed(Ending::NotPlaced, failure), bodies)
            }
            (Record::Placement { .. }, false) => {
                let failure = "the bridge was restarted while it was carried out";
                let finding = Finding::failed(Ending::Unknown, failure);
                cut_off(self.end_placement(finding, bodies), PLACEMENT_CUT_OFF)
            }
            (Record::Renewal { .. }, true) => self.abandon_renewal(bodies),
            (Record::Renewal { .. }, false) => {
                cut_off(self.abandon_renewal(bodies), RENEWAL_CUT_OFF)
            }
        })
    }

    /// Restores a ledger that does not know all that was done since it was written, for this
    /// reason, such as [`FROM_BACKUP`]. It goes on at a state that none had, which is the first of
    /// which all is known, and the cell is held.
    pub fn restored(&self, reason: &str) -> Change {
        // By the time alone, where the clock was set back, it could be a state that the cell had
        // after the backup.
        let moved_on = MOST_CHANGES + (rand::random::<u64>() >> RESTORE_SHIFT);
        let beyond = self.head.state_number.saturating_add(moved_on);
        self.restored_at(new_state_number().max(beyond), reason)
    }

    /// Restores as [`Self::restored`] does, at this state: one that the cell never had.
    pub fn restored_at(&self, state_number: u64, reason: &str) -> Change {
        let bodies = self.head.bodies.clone();
        let settled = match self.under_way() {
            Some(Record::Placement { .. }) => {
                let finding = Finding::failed(Ending::Unknown, reason);
                self.end_placement(finding, bodies)
            }
            Some(Record::Renewal { .. }) => self.abandon_renewal(bodies),
            None => self.no_change(),
        };
        let mut change = settled.holding(Hold::own("restored", state_number, reason));
        change.head.state_number = state_number;
        change.head.first_state_number = state_number;
        change
    }

    /// Applies a change that was written down.
    pub fn apply(&mut self, change: Change) {
        self.head = change.head;
        for number in &change.forgotten {
            self.records.remove(number);
        }
        self.records.extend(change.written);
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

    /// Gives the head when the container holds these bodies, as a new state where that is a change.
    fn head_with(&self, bodies: Vec<Body>, is_changed: bool) -> Head {
        Head {
            state_number: self.head.state_number + u64::from(is_changed),
            bodies,
            ..self.head.clone()
        }
    }

    /// Ends the record under way, and forgets the oldest ones where there are too many.
    fn end(&self, mut head: Head, end: impl FnOnce(&mut Record)) -> Change {
        let mut written = self.open().map(|(number, record)| (number, record.clone()));
        if let Some((_, record)) = &mut written {
            end(record);
        }
        let surplus = self.records.len().saturating_sub(MAX_RECORDS);
        let oldest = self.records.iter().take(surplus);
        let states = oldest.clone().filter_map(|(_, record)| match record {
            Record::Placement { placement, .. } => Some(placement.state_number),
            Record::Renewal { .. } => None,
        });
        // Of the states that forgotten placements were planned on not all is known any more, and
        // they have to be past.
        if let Some(last) = states.max() {
            head.first_state_number = head.first_state_number.max(last + 1);
            head.state_number = head.state_number.max(head.first_state_number);
        }
        Change {
            head,
            written,
            forgotten: oldest.map(|(number, _)| *number).collect(),
        }
    }
}

#[cfg(test)]
mod tests;
