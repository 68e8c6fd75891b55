//! Requests that stop a cell, let it go on, and say what people did in it.

use std::fmt::Display;
use std::time::{Duration, Instant};

use ppnpack_packing::motion::Cycle;
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{WireError, header};

use super::Desk;
use crate::journal::JournalError;
use ppnpack_protocol::ledger::{Change, Hold, Holds, Record};

/// The most items or holds that one request may name.
const MOST_IDS: usize = 1_000;

impl Desk {
    /// Holds the cell, whatever becomes of the journal: that it cannot be written is told.
    pub(super) fn hold(&mut self, incoming: Incoming<v1::HoldRequest>) {
        self.share.hold_for(&incoming);
        let mut written = self.follow();
        if written.is_ok() && self.trouble.is_some() {
            // It may be one that came before, and was not written.
            written = self.commit(self.ledger.no_change()).map(drop);
        }
        if let Err(error) = written {
            let message = format!("the cell is held, but a restart would forget it: {error}");
            return incoming.refuse(Status::Unavailable, message);
        }
        let reply = v1::HoldReply {
            header: None,
            state: Some(self.streams.state_of(&self.ledger)),
            hold_id: incoming.header().request_id.clone(),
        };
        incoming.reply(reply, Done::default());
    }

    /// Takes over the holds of the robot, as the desks of all its containers do.
    fn follow(&mut self) -> Result<(), JournalError> {
        let (holds, most_placements) = self.share.holds();
        if holds == self.ledger.head().holds {
            return Ok(());
        }
        if !holds.is_empty() {
            return self.hold_by(holds);
        }
        self.commit(self.ledger.held_by(holds, most_placements))?;
        self.tell_holds();
        Ok(())
    }

    /// Does what was asked for at another container of the robot; until it can be written down, that goes on being tried.
    pub(super) fn follow_others(&mut self) {
        if let Err(error) = self.follow() {
            tracing::error!(%error, "the holds of the robot are not written down");
        }
    }

    /// Holds the cell by these, also where that cannot be written down.
    fn hold_by(&mut self, holds: Holds) -> Result<(), JournalError> {
        let change = self.ledger.held_by(holds, 0);
        let written = self.commit(change.clone());
        if written.is_err() {
            self.ledger.apply(change);
        }
        self.tell_holds();
        written.map(drop)
    }

    /// As [`Self::hold_by`], where nobody waits for it.
    pub(super) fn be_held_by(&mut self, holds: Holds) {
        if let Err(error) = self.hold_by(holds) {
            tracing::error!(%error, "a restart would forget that the cell is held");
        }
    }

    /// Tells that the cell is held, or goes on.
    fn tell_holds(&self) {
        let head = self.ledger.head();
        if self.ledger.is_held() {
            tracing::warn!(reasons = %head.holds, "the cell is held");
        } else {
            tracing::info!("the cell goes on");
            self.show();
        }
        self.streams.tell_state(&self.ledger);
    }

    /// From now on the placement may take so long.
    pub(super) fn watch_over(&mut self, cycle: Option<&Cycle>) {
        let longest = cycle.and_then(|cycle| Duration::try_from_secs_f64(cycle.cycle_s).ok());
        let longest = longest.filter(|_| !self.limits.overdue.is_zero());
        let longest = longest.map(|longest| longest.saturating_add(self.limits.overdue));
        // What is longer than the clock can count is never overdue.
        self.overdue_at = longest.and_then(|longest| Instant::now().checked_add(longest));
    }

    /// Holds the cell where the robot takes longer than its motion says: it may stand before something.
    pub(super) fn hold_where_overdue(&mut self) {
        if self
            .overdue_at
            .take_if(|at| *at <= Instant::now())
            .is_none()
        {
            return;
        }
        let Some(Record::Placement { placement, .. }) = self.ledger.under_way() else {
            return;
        };
        let reason = format!(
            "placement {} takes {} s longer than its motion: look what the robot does",
            placement.placement_id,
            self.limits.overdue.as_secs_f64()
        );
        let hold = Hold::own("overdue", self.ledger.head().state_number, &reason);
        self.share.hold(hold, false);
        self.follow_others();
    }

    pub(super) fn resume(&mut self, incoming: Incoming<v1::ResumeRequest>) {
        let ids = match read_hold_ids(incoming.message()) {
            Ok(ids) => ids,
            Err(error) => return incoming.refuse(Status::Invalid, error.to_string()),
        };
        match self.end_holds(&ids, incoming.message().most_placements) {
            Ok(()) => {
                let reply = v1::ResumeReply {
                    header: None,
                    state: Some(self.streams.state_of(&self.ledger)),
                };
                incoming.reply(reply, Done::default());
            }
            Err((status, message)) => incoming.refuse(status, message),
        }
    }

    /// Ends holds of the robot; on an error none of them.
    fn end_holds(&mut self, ids: &[String], most_placements: u32) -> Result<(), (Status, String)> {
        let unavailable = |error: &dyn Display| (Status::Unavailable, error.to_string());
        self.share.is_open().map_err(|taken| unavailable(&taken))?;
        self.follow().map_err(|error| unavailable(&error))?;
        if !self.ledger.is_held() {
            return Ok(());
        }
        let Some(change) = self.ledger.resume(ids, most_placements) else {
            let holds = &self.ledger.head().holds;
            let message =
                format!("the cell is held for another reason: {holds}: see `holds` of its state");
            return Err((Status::Stale, message));
        };
        self.commit(change).map_err(|error| unavailable(&error))?;
        self.share.end_holds(ids, most_placements);
        self.tell_holds();
        Ok(())
    }

    pub(super) fn changed(&mut self, incoming: Incoming<v1::ChangedRequest>) {
        let removed = match read_ids("removed_item_ids", &incoming.message().removed_item_ids) {
            Ok(removed) => removed,
            Err(error) => return incoming.refuse(Status::Invalid, error.to_string()),
        };
        if self.ledger.under_way().is_some() {
            return self.refuse_busy(incoming);
        }
        let change = self.ledger.change_by_hand(&removed);
        if let Err(error) = self.change(change) {
            return incoming.refuse(Status::Unavailable, error.to_string());
        }
        tracing::info!(?removed, "the container was changed by hand");
        self.send_change();
        let reply = v1::ChangedReply {
            header: None,
            state: Some(self.streams.state_of(&self.ledger)),
        };
        incoming.reply(reply, Done::default());
    }

    /// Writes down a change, makes it and tells of it.
    pub(super) fn change(&mut self, change: Change) -> Result<(), JournalError> {
        self.commit(change)?;
        self.streams.tell_state(&self.ledger);
        Ok(())
    }
}

fn read_hold_ids(message: &v1::ResumeRequest) -> Result<Vec<String>, WireError> {
    let field = "hold_ids";
    if message.hold_ids.is_empty() {
        let reason = "name the holds that are to end, by `holds` of the cell's state";
        return Err(WireError::invalid(field, reason));
    }
    read_ids(field, &message.hold_ids)
}

fn read_ids(field: &'static str, ids: &[String]) -> Result<Vec<String>, WireError> {
    if ids.len() > MOST_IDS {
        let reason = format_args!("{} where at most {MOST_IDS} are possible", ids.len());
        return Err(WireError::invalid(field, reason));
    }
    let ids = ids.iter().map(|id| Ok(header::id(field, id)?.to_owned()));
    ids.collect()
}
