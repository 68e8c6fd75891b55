//! The holds of a cell: a set, of which each has a name and is ended by it alone.

use std::fmt;

use ppnpack_wire::header;
use serde::{Deserialize, Serialize};

use super::{Change, Head, Ledger};

/// Maximum number of holds that are kept apart. There is always room for one more: see
/// [`Holds::add`].
const MAX_HOLDS: usize = 32;

/// Maximum size of a holder's name, in bytes.
const MAX_HOLDER_BYTES: usize = 64;

/// The holder of the bridge's own holds.
pub const BRIDGE: &str = "bridge";

/// Reason of the hold after a placement that was cut off.
pub(super) const PLACEMENT_CUT_OFF: &str = "the bridge was restarted while a placement was carried \
     out: look where the item is and what the robot holds, say what changed, then resume";

/// Reason of the hold after a renewal that was cut off.
pub(super) const RENEWAL_CUT_OFF: &str = "the bridge was restarted while the container was \
     renewed: look which container is there, resume, and renew it where it is not empty";

/// Reason of the hold of a cell that another bridge served meanwhile.
pub const AFTER_ANOTHER: &str = "another bridge served the cell: look that nobody is in it, what \
     the container holds and what the robot does, renew the container or say what changed, then \
     resume";

/// Reason of the hold of a cell whose journal was restored.
pub const FROM_BACKUP: &str = "the journal was restored from a backup: look that nobody is in the \
     cell, what the container holds and what the robot does, renew the container or say what \
     changed, then resume";

/// Reason of the hold after the placements that were asked for.
const STEPPED: &str =
    "as many placements have begun as were asked for: look at their ends, then resume";

/// Reason of the hold of a real cell of which nothing is known.
const WITHOUT_PAST: &str = "nothing is known of the cell, as at its first start or after its \
     journal was lost: look that nobody is in it, what the container holds and what the robot does, \
     renew the container or say what changed, then resume";

/// A reason for which nothing is begun in a cell.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Hold {
    /// Its name: the id of the request that made it, or one of the bridge's own.
    pub id: String,
    /// The holder, for people.
    pub holder: String,
    /// The reason, for people.
    pub reason: String,
}

impl Hold {
    /// Makes somebody's hold; a holder or reason that is too long is cut.
    pub fn new(id: &str, holder: &str, reason: &str) -> Self {
        let end = holder.floor_char_boundary(MAX_HOLDER_BYTES);
        Self {
            id: id.to_owned(),
            holder: holder.get(..end).unwrap_or("").to_owned(),
            reason: header::text(reason),
        }
    }

    /// Makes a hold of the bridge's own. A cell that goes on is at a new state: no other hold of
    /// the same cause has this id.
    pub fn own(cause: &str, state_number: u64, reason: &str) -> Self {
        Self::new(&format!("{cause}-{state_number}"), BRIDGE, reason)
    }
}

/// The holds of a cell, in the order in which they were made.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Holds(Vec<Hold>);

impl Holds {
    /// Says whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Gives each of them.
    pub fn iter(&self) -> impl Iterator<Item = &Hold> {
        self.0.iter()
    }

    /// Adds one, where it is not there. In a full set it takes the place of the last, with both
    /// reasons: whoever saw only that one ends neither.
    pub fn add(&mut self, mut hold: Hold) {
        if self.0.iter().any(|own| own.id == hold.id) {
            return;
        }
        if self.0.len() >= MAX_HOLDS
            && let Some(last) = self.0.pop()
        {
            hold.reason = match last.reason.starts_with(&hold.reason) {
                true => last.reason,
                false => header::text(&format!("{}; {}", hold.reason, last.reason)),
            };
        }
        self.0.push(hold);
    }

    /// Gives the set without these; `None` where none of them is in it.
    pub fn without(&self, ids: &[String]) -> Option<Self> {
        let left = self.0.iter().filter(|hold| !ids.contains(&hold.id));
        let left = Self(left.cloned().collect());
        (left.0.len() < self.0.len()).then_some(left)
    }
}

impl fmt::Display for Holds {
    /// Writes the reasons, each once.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut reasons: Vec<&str> = Vec::new();
        for hold in &self.0 {
            if !reasons.contains(&hold.reason.as_str()) {
                reasons.push(&hold.reason);
            }
        }
        formatter.write_str(&reasons.join("; "))
    }
}

impl Change {
    /// Adds a hold to the change.
    pub(super) fn holding(mut self, hold: Hold) -> Self {
        self.head.holds.add(hold);
        self.head.placements_left = 0;
        self
    }

    /// Counts the placement that is begun: the last that was asked for holds the cell.
    pub(super) fn counted(mut self) -> Self {
        if self.head.placements_left == 1 {
            let hold = Hold::own("stepped", self.head.state_number, STEPPED);
            return self.holding(hold);
        }
        self.head.placements_left = self.head.placements_left.saturating_sub(1);
        self
    }
}

impl Ledger {
    /// Says whether the cell is held: nothing is begun.
    pub fn is_held(&self) -> bool {
        !self.head.holds.is_empty()
    }

    /// Holds the cell: nothing is begun until this hold is ended as well. One that is there changes
    /// nothing.
    pub fn hold(&self, hold: Hold) -> Change {
        self.no_change().holding(hold)
    }

    /// Ends these holds; where none is left the cell goes on, for so many placements or, with 0,
    /// for any number. Changes nothing in a cell that is not held: they were ended. `None` where
    /// the cell is held by others alone.
    pub fn resume(&self, ids: &[String], most_placements: u32) -> Option<Change> {
        match self.is_held() {
            false => Some(self.no_change()),
            true => Some(self.held_by(self.head.holds.without(ids)?, most_placements)),
        }
    }

    /// Has the cell held by these alone. Where that is none it goes on at a new state, for so many
    /// placements. One that was refused meanwhile counts as not placed: its request may come late.
    pub fn held_by(&self, holds: Holds, most_placements: u32) -> Change {
        let goes_on = self.is_held() && holds.is_empty();
        let placements_left = match holds.is_empty() {
            true if goes_on => most_placements,
            true => self.head.placements_left,
            false => 0,
        };
        Change::of(Head {
            holds,
            placements_left,
            ..self.head_with(self.head.bodies.clone(), goes_on)
        })
    }

    /// Holds a real cell of which nothing is known; `None` where something is.
    pub(super) fn hold_without_past(&self) -> Option<Change> {
        let (head, state_number) = (&self.head, self.head.state_number);
        // A hold that ended counted the state up.
        let has_counted = state_number != head.first_state_number || head.next != 1;
        let has_past = has_counted || self.is_held();
        (!has_past).then(|| self.hold(Hold::own("start", state_number, WITHOUT_PAST)))
    }
}
