//! What is known of a cell: what was asked for, how it ended, and what lies in the container.
//!
//! A [`Ledger`] only answers and computes [`Change`]s. Each is written to the journal first and applied then, so that
//! the ledger is never ahead of the disk.
//!
//! Placements are executed at most once for two reasons. Their ids are remembered, and each names the state of the cell
//! that it was planned on: whatever changes the container counts the state up, so that a placement whose id was
//! forgotten, or lost with the journal, is of a past state. A ledger without a past begins at a state that no earlier one had.
//!
//! Of a placement that it does not know, a ledger says that it was never begun only where it knows all that was done on the
//! state that it was planned on: from [`Head::first_state_number`] on.

mod holds;

use std::collections::{BTreeMap, HashMap};
use std::time::{SystemTime, UNIX_EPOCH};

use ppnpack_wire::v1::Status;
use serde::{Deserialize, Serialize};

use crate::placing::{Body, Ending, Finding, Placement};
pub use holds::{AFTER_ANOTHER, BRIDGE, FROM_BACKUP, Hold, Holds};
use holds::{PLACEMENT_CUT_OFF, RENEWAL_CUT_OFF};

/// How many placements and renewals are remembered: hours of a cell's work, at a kilobyte each. Of what was planned before, a ledger
/// says that it does not know ([`PlacementVerdict::Forgotten`]).
pub const MAX_RECORDS: usize = 1_000;

/// How many low bits of a first state number are random; the milliseconds since 1970 stand above them.
const RANDOM_BITS: u32 = 20;

/// More changes than a cell makes between a backup and its restoring.
const MOST_CHANGES: u64 = 1 << 32;

/// How many high bits of what a restored state number is moved on by are 0; thousands of restorings find room.
const RESTORE_SHIFT: u32 = 12;

/// How a placement ended, and the state of the cell afterwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// How it ended.
    pub finding: Finding,
    /// The state of the cell afterwards.
    pub state_number: u64,
}

/// Something that was asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Record {
    /// A placement; without an outcome while it is executed.
    Placement {
        /// What was asked for.
        placement: Box<Placement>,
        /// How it ended, where it has.
        outcome: Option<Outcome>,
    },
    /// A renewal of the container; without a state number while it is under way.
    Renewal {
        /// Names the renewal.
        request_id: String,
        /// The state of the cell afterwards, where it has happened.
        state_number: Option<u64>,
    },
}

/// What is known of the cell as it is now.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// Counts the changes of the container's content.
    pub state_number: u64,
    /// The first state of which every placement is known.
    pub first_state_number: u64,
    /// Why nothing is begun.
    pub holds: Holds,
    /// How many placements may begin before the cell holds itself; 0: any number.
    pub placements_left: u32,
    /// The number of the next record.
    pub next: u64,
    /// What lies in the container.
    pub bodies: Vec<Body>,
}

/// A step of a ledger, to be written down and then applied.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The cell after the step.
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
    records: BTreeMap<u64, Record>,
    placements: HashMap<String, u64>,
    renewals: HashMap<String, u64>,
    /// The record without an end.
    under_way: Option<u64>,
}

/// What is to be done about a placement.
#[derive(Debug, PartialEq)]
pub enum PlacementVerdict<'a> {
    /// It was asked for before; how it ended, if it did.
    Known(Option<&'a Outcome>),
    /// Its id was used for another one.
    Conflict,
    /// Something else is under way.
    Busy,
    /// It was planned on a past state, and was never begun.
    Stale,
    /// It was planned on a state of which it is not known what was done on it.
    Forgotten,
    /// Nothing is begun, for these reasons.
    Held(&'a Holds),
    /// It can be executed.
    New,
}

/// What is to be done about a renewal.
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

/// The number of a state that no placement was planned on.
///
/// The time alone would do where clocks only go forward; the random bits are for those that do not.
pub(crate) fn new_state_number() -> u64 {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    let milliseconds = since_1970.map_or(0, |since_1970| since_1970.as_millis() as u64);
    let random = rand::random::<u64>() >> (u64::BITS - RANDOM_BITS);
    milliseconds << RANDOM_BITS | random
}

impl PlacementVerdict<'_> {
    /// As what the placement is refused; `None` where it is not.
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
    /// A ledger without a past: an empty container, at a state that no placement was planned on.
    pub fn without_past() -> Self {
        Self::beginning_at(new_state_number())
    }

    /// A ledger without a past that begins at this state: one that no placement was planned on.
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

    /// A ledger as it was written down.
    pub fn of(head: Head, records: BTreeMap<u64, Record>) -> Self {
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

    /// The cell as it is now.
    pub fn head(&self) -> &Head {
        &self.head
    }

    /// The records with their numbers, in their order.
    pub fn records(&self) -> impl Iterator<Item = (u64, &Record)> {
        self.records
            .iter()
            .map(|(number, record)| (*number, record))
    }

    /// What is being done.
    pub fn under_way(&self) -> Option<&Record> {
        self.records.get(&self.under_way?)
    }

    /// A placement, and how it ended, if it did.
    pub fn placement(&self, id: &str) -> Option<(&Placement, Option<&Outcome>)> {
        match self.records.get(self.placements.get(id)?)? {
            Record::Placement { placement, outcome } => Some((placement, outcome.as_ref())),
            Record::Renewal { .. } => None,
        }
    }

    /// What is to be done about a placement.
    pub fn judge(&self, asked: &Placement) -> PlacementVerdict<'_> {
        match self.placement(&asked.placement_id) {
            Some((known, outcome)) if known.is_same(asked) => PlacementVerdict::Known(outcome),
            Some(_) => PlacementVerdict::Conflict,
            None if !self.knows_all_of(asked.state_number) => PlacementVerdict::Forgotten,
            None if asked.state_number != self.head.state_number => PlacementVerdict::Stale,
            None if self.under_way.is_some() => PlacementVerdict::Busy,
            None if self.is_held() => PlacementVerdict::Held(&self.head.holds),
            None => PlacementVerdict::New,
        }
    }

    /// Whether all placements that were begun on a state are known. On state 0, which sensors send that know none, none ever is.
    fn knows_all_of(&self, state_number: u64) -> bool {
        let known = self.head.first_state_number..=self.head.state_number;
        state_number == 0 || known.contains(&state_number)
    }

    /// What is to be done about a renewal.
    pub fn judge_renewal(&self, request_id: &str) -> RenewalVerdict<'_> {
        let number = self.renewals.get(request_id);
        match number.and_then(|number| self.records.get(number)) {
            Some(Record::Renewal {
                state_number: Some(state_number),
                ..
            }) => RenewalVerdict::Done(*state_number),
            Some(_) => RenewalVerdict::UnderWay,
            None if self.under_way.is_some() => RenewalVerdict::Busy,
            None if self.is_held() => RenewalVerdict::Held(&self.head.holds),
            None => RenewalVerdict::New,
        }
    }

    /// A placement is accepted.
    pub fn accept(&self, placement: Placement) -> Change {
        let begun = self.begin(Record::Placement {
            placement: Box::new(placement),
            outcome: None,
        });
        begun.counted()
    }

    /// A renewal begins.
    pub fn begin_renewal(&self, request_id: String) -> Change {
        self.begin(Record::Renewal {
            request_id,
            state_number: None,
        })
    }

    /// What is under way has ended with this finding, and the container holds these bodies.
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

    /// The renewal under way has happened.
    pub fn end_renewal(&self, bodies: Vec<Body>) -> Change {
        let head = self.head_with(bodies, true);
        let after = head.state_number;
        self.end(head, |record| {
            if let Record::Renewal { state_number, .. } = record {
                *state_number = Some(after);
            }
        })
    }

    /// The renewal under way has failed, or nobody knows: it can be asked for again.
    pub fn abandon_renewal(&self, bodies: Vec<Body>) -> Change {
        Change {
            forgotten: self.under_way.into_iter().collect(),
            ..self.find_bodies(bodies)
        }
    }

    /// The container turned out to hold other bodies than was thought.
    pub fn find_bodies(&self, bodies: Vec<Body>) -> Change {
        Change::of(self.head_with(bodies, true))
    }

    /// Somebody had a hand in the container, and took some items out.
    pub fn change_by_hand(&self, removed: &[String]) -> Change {
        let bodies = self.head.bodies.iter();
        let left = bodies.filter(|body| !removed.contains(&body.item_id));
        self.find_bodies(left.cloned().collect())
    }

    /// Nothing: to try whether it can be written down.
    pub fn no_change(&self) -> Change {
        Change::of(self.head.clone())
    }

    /// What was under way when the bridge was cut off; `None` where nothing was.
    ///
    /// A simulated cell is what was written down, so that it did not happen there. What another cell did is not known: it is held
    /// until somebody has looked, and its container counts as holding what it held before. So is one of which nothing is known.
    pub fn recover(&self, is_simulated: bool) -> Option<Change> {
        let bodies = self.head.bodies.clone();
        let cut_off = |change: Change, reason| {
            let hold = Hold::own("cut-off", change.head.state_number, reason);
            change.holding(hold)
        };
        let Some(under_way) = self.under_way() else {
            return (!is_simulated).then(|| self.hold_without_past())?;
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

    /// What a ledger is that does not know all that was done since it was written, for this reason, such as [`FROM_BACKUP`]. It goes
    /// on at a state that none had, which is the first of which all is known, and the cell is held.
    pub fn restored(&self, reason: &str) -> Change {
        // By the time alone, where the clock was set back, it could be a state that the cell had after the backup.
        let moved_on = MOST_CHANGES + (rand::random::<u64>() >> RESTORE_SHIFT);
        let beyond = self.head.state_number.saturating_add(moved_on);
        self.restored_at(new_state_number().max(beyond), reason)
    }

    /// As [`Self::restored`], at this state: one that the cell never had.
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

    /// Takes a step that was written down.
    pub fn apply(&mut self, change: Change) {
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
            bodies,
            ..self.head.clone()
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
        let states = oldest.clone().filter_map(|(_, record)| match record {
            Record::Placement { placement, .. } => Some(placement.state_number),
            Record::Renewal { .. } => None,
        });
        // Of the states that forgotten placements were planned on not all is known any more, and they have to be past.
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
mod tests;
