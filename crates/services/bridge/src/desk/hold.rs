//! Requests that stop a cell, let it go on, and say what people did in it.

use std::time::{Duration, Instant};

use ppnpack_packing::motion::Cycle;
use ppnpack_service::Shutdown;
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{WireError, header};

use super::Desk;
use super::share::Order;
use crate::journal::JournalError;
use crate::runner::Job;
use ppnpack_protocol::ledger::{Change, Record};

/// The most items that one request may say were taken out.
const MOST_REMOVED: usize = 1_000;

impl Desk {
    /// Holds the cell, whatever becomes of the journal: that it cannot be written is told.
    pub(super) fn hold(&mut self, incoming: Incoming<v1::HoldRequest>) {
        self.share.order(&Order::hold(incoming.message()));
        if let Err(error) = self.follow_order() {
            let message = format!("the cell is held, but a restart would forget it: {error}");
            return incoming.refuse(Status::Unavailable, message);
        }
        let reply = v1::HoldReply {
            header: None,
            state: Some(self.streams.state_of(&self.ledger)),
        };
        incoming.reply(reply, Done::default());
    }

    /// Holds the cell for this reason; what is under way is broken off where that is asked for.
    fn hold_for(&mut self, reason: &str, is_aborting: bool) -> Result<(), JournalError> {
        if is_aborting && let Some(break_off) = &self.break_off {
            break_off.request();
        }
        self.hold_with(self.ledger.hold(reason))
    }

    /// Does what was ordered last for all containers of the robot.
    fn follow_order(&mut self) -> Result<(), JournalError> {
        match self.share.take_order() {
            None => Ok(()),
            Some(Order::Hold {
                reason,
                is_aborting,
            }) => self.hold_for(&reason, is_aborting),
            Some(Order::Resume) => self.go_on(),
        }
    }

    /// Does what was asked for at another container of the robot; until it can be written down, that goes on being tried.
    pub(super) fn follow_others(&mut self) {
        let is_resuming = self.share.is_resuming();
        if let Err(error) = self.follow_order() {
            tracing::error!(%error, "what was asked for at another container of the robot is not written down");
            if is_resuming {
                self.share.put_back(Order::Resume);
            }
        }
    }

    /// Takes over the hold of another container of the same robot, and has the others take over the own one.
    pub(super) fn begin_held_with_others(&mut self) {
        let own = self.ledger.head().hold.clone();
        self.share.note(own.as_deref());
        if let Some(reason) = own {
            self.order_hold(reason);
        } else if let Some(reason) = self.share.held_elsewhere()
            && let Err(error) = self.hold_for(&reason, false)
        {
            tracing::error!(%error, "a restart would forget that the cell is held");
        }
    }

    fn order_hold(&self, reason: String) {
        self.share.order(&Order::Hold {
            reason,
            is_aborting: false,
        });
    }

    /// Holds the cell, also where that cannot be written down.
    fn hold_with(&mut self, change: Change) -> Result<(), JournalError> {
        let reason = change.head.hold.as_deref();
        tracing::warn!(reason, "the cell is held");
        let written = self.commit(change.clone());
        if written.is_err() {
            self.apply(change);
        }
        self.streams.tell_state(&self.ledger);
        written.map(drop)
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
        if let Err(error) = self.hold_with(self.ledger.hold_besides(&reason)) {
            tracing::error!(%error, "a restart would forget that the cell is held");
        }
        self.order_hold(reason);
    }

    pub(super) fn resume(&mut self, incoming: Incoming<v1::ResumeRequest>) {
        if !self.resumed.has(&incoming.header().request_id) {
            self.share.order(&Order::Resume);
            if let Err(error) = self.follow_order() {
                return incoming.refuse(Status::Unavailable, error.to_string());
            }
            self.resumed.add(&incoming.header().request_id);
        }
        let reply = v1::ResumeReply {
            header: None,
            state: Some(self.streams.state_of(&self.ledger)),
        };
        incoming.reply(reply, Done::default());
    }

    /// The cell is held no longer.
    fn go_on(&mut self) -> Result<(), JournalError> {
        self.change(self.ledger.resume())?;
        tracing::info!("the cell goes on");
        if self.ledger.under_way().is_none() {
            self.send(Job::Show(self.ledger.head().state_number));
        }
        Ok(())
    }

    pub(super) fn changed(&mut self, incoming: Incoming<v1::ChangedRequest>) {
        let removed = match read_removed(incoming.message()) {
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

    /// By which the next placement can be broken off.
    pub(super) fn new_break_off(&mut self) -> Shutdown {
        let break_off = self.cut_off.of_part();
        self.break_off = Some(break_off.clone());
        break_off
    }
}

fn read_removed(message: &v1::ChangedRequest) -> Result<Vec<String>, WireError> {
    let field = "removed_item_ids";
    let ids = &message.removed_item_ids;
    if ids.len() > MOST_REMOVED {
        let reason = format_args!("{} where at most {MOST_REMOVED} are possible", ids.len());
        return Err(WireError::invalid(field, reason));
    }
    let ids = ids.iter().map(|id| Ok(header::id(field, id)?.to_owned()));
    ids.collect()
}
