//! What holds a cell: a set, of which each has a name and is ended by it alone.

use std::fmt;

use ppnpack_wire::header;
use serde::{Deserialize, Serialize};

use super::{Change, Head, Ledger};

/// The most holds that are kept apart. There is always room for one more: see [`Holds::add`].
const MAX_HOLDS: usize = 32;

/// The longest name of who holds, in bytes.
const MAX_HOLDER_BYTES: usize = 64;

/// Who holds where the bridge does by itself.
pub const BRIDGE: &str = "bridge";

/// Why a cell is held whose placement was cut off.
pub(super) const PLACEMENT_CUT_OFF: &str = "the bridge was restarted while a placement was carried out: look where the item is and what \
     the robot holds, say what changed, then resume";

/// Why a cell is held whose renewal was cut off.
pub(super) const RENEWAL_CUT_OFF: &str = "the bridge was restarted while the container was renewed: look which container is there, resume, \
     and renew it where it is not empty";

/// Why a cell is held that another bridge served meanwhile.
pub const AFTER_ANOTHER: &str = "another bridge served the cell: look that nobody is in it, what the container holds and what the robot does, renew the container \
     or say what changed, then resume";

/// Why a cell is held whose journal was restored.
pub const FROM_BACKUP: &str = "the journal was restored from a backup: look that nobody is in the cell, what the container holds and what the robot does, renew the \
     container or say what changed, then resume";

/// Why a cell is held in which so many placements have begun as were asked for.
const STEPPED: &str =
    "as many placements have begun as were asked for: look at their ends, then resume";

/// Why a real cell is held of which nothing is known.
const WITHOUT_PAST: &str = "nothing is known of the cell, as at its first start or after its journal was lost: look that nobody is in \
     it, what the container holds and what the robot does, renew the container or say what changed, then resume";

/// Something for which nothing is begun.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Hold {
    /// Names it: the id of the request that made it, or one of the bridge's own.
    pub id: String,
    /// Who holds, for people.
    pub holder: String,
    /// Why, for people.
    pub reason: String,
}

impl Hold {
    /// A hold of somebody's; what is too long of it is cut.
    pub fn new(id: &str, holder: &str, reason: &str) -> Self {
        let end = holder.floor_char_boundary(MAX_HOLDER_BYTES);
        Self {
            id: id.to_owned(),
            holder: holder.get(..end).unwrap_or("").to_owned(),
            reason: header::text(reason),
        }
    }

    /// A hold of the bridge's own. A cell that goes on is at a new state: no other one of the same cause has this id.
    pub fn own(cause: &str, state_number: u64, reason: &str) -> Self {
        Self::new(&format!("{cause}-{state_number}"), BRIDGE, reason)
    }
}

/// The holds of a cell, in the order in which they were made.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Holds(Vec<Hold>);

impl Holds {
    /// Whether nothing is held.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Each of them.
    pub fn iter(&self) -> impl Iterator<Item = &Hold> {
        self.0.iter()
    }

    /// Adds one, where it is not there. In a full set it takes the place of the last, with both reasons: whoever saw only that one
    /// ends neither.
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

    /// The set without these; `None` where none of them is in it.
    pub fn without(&self, ids: &[String]) -> Option<Self> {
        let left = self.0.iter().filter(|hold| !ids.contains(&hold.id));
        let left = Self(left.cloned().collect());
        (left.0.len() < self.0.len()).then_some(left)
    }
}

impl fmt::Display for Holds {
    /// Writes the reasons, each once.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, hold) in self.0.iter().enumerate() {
            let mut before = self.0.iter().take(index);
            if before.any(|before| before.reason == hold.reason) {
                continue;
            }
            let separator = if index == 0 { "" } else { "; " };
            write!(formatter, "{separator}{}", hold.reason)?;
        }
        Ok(())
    }
}

impl Change {
    /// The same, after which the cell is held by this too.
    pub(super) fn holding(mut self, hold: Hold) -> Self {
        self.head.holds.add(hold);
        self.head.placements_left = 0;
        self
    }

    /// The same, in which a placement is begun: the last that was asked for holds the cell.
    pub(super) fn counted(mut self) -> Self {
        match self.head.placements_left {
            0 => self,
            1 => {
                let hold = Hold::own("stepped", self.head.state_number, STEPPED);
                self.holding(hold)
            }
            left => {
                self.head.placements_left = left - 1;
                self
            }
        }
    }
}

impl Ledger {
    /// Whether nothing is begun.
    pub fn is_held(&self) -> bool {
        !self.head.holds.is_empty()
    }

    /// Nothing is begun from now on, until this is ended as well. One that is there changes nothing.
    pub fn hold(&self, hold: Hold) -> Change {
        self.no_change().holding(hold)
    }

    /// Ends these holds; where none is left the cell goes on, for so many placements or, with 0, for any number. Changes nothing in a cell
    /// that is not held: they were ended. `None` where the cell is held by others alone.
    pub fn resume(&self, ids: &[String], most_placements: u32) -> Option<Change> {
        match self.is_held() {
            false => Some(self.no_change()),
            true => Some(self.held_by(self.head.holds.without(ids)?, most_placements)),
        }
    }

    /// The cell is held by these and nothing else. Where that is nothing any more it goes on at a new state, for so many placements: one
    /// that was refused while it was held counts as not placed, and its request may still come late.
    pub fn held_by(&self, holds: Holds, most_placements: u32) -> Change {
        let goes_on = self.is_held() && holds.is_empty();
        let placements_left = match (goes_on, holds.is_empty()) {
            (true, _) => most_placements,
            (false, true) => self.head.placements_left,
            (false, false) => 0,
        };
        Change::of(Head {
            holds,
            placements_left,
            ..self.head_with(self.head.bodies.clone(), goes_on)
        })
    }

    /// A hold of a real cell of which nothing is known; `None` where something is.
    pub(super) fn hold_without_past(&self) -> Option<Change> {
        let Head {
            state_number,
            first_state_number,
            next,
            ..
        } = self.head;
        // A hold that ended counted the state up.
        let has_past = state_number != first_state_number || next != 1 || self.is_held();
        (!has_past).then(|| self.hold(Hold::own("start", state_number, WITHOUT_PAST)))
    }
}
