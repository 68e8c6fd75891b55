//! Requests that stop a cell, let it go on, and say what people did in it.

use std::time::{Duration, Instant};

use ppnpack_packing::checks::motion::Cycle;
use ppnpack_service::rpc::Incoming;
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{WireError, header};

use super::{Desk, Refusal};
use crate::journal::JournalError;
use ppnpack_protocol::ledger::{Change, Hold, Holds, Record};

/// The maximum of items or holds that one request may name.
const MOST_IDS: usize = 1_000;

impl Desk {
    /// Holds the robot, even if the journal cannot be written: the answer says so then.
    pub(super) fn hold(
        &mut self,
        incoming: &Incoming<v1::HoldRequest>,
    ) -> Result<v1::HoldReply, Refusal> {
        self.robot.share.hold_as_asked(incoming);
        let mut written = self.copy_robot_holds();
        if written.is_ok() && self.trouble.is_some() {
            // An earlier hold may be unwritten.
            written = self.commit(self.ledger.no_change()).map(drop);
        }
        written.map_err(|error| {
            let message = format!("the cell is held, but a restart would forget it: {error}");
            Refusal(Status::Unavailable, message)
        })?;
        Ok(v1::HoldReply {
            header: None,
            state: Some(self.streams.state_of(&self.ledger)),
            hold_id: incoming.header().request_id.clone(),
        })
    }

    /// Writes the robot's holds into the ledger, as the desks of all its containers do.
    fn copy_robot_holds(&mut self) -> Result<(), JournalError> {
        let (holds, most_placements) = self.robot.share.robot_holds();
        match holds == self.ledger.head().holds {
            true => Ok(()),
            false => self.replace_holds(holds, most_placements),
        }
    }

    /// Copies holds that were made or ended at another container of the robot. What cannot be
    /// written is tried again at the next tick.
    pub(super) fn follow_robot(&mut self) {
        let written = self.copy_robot_holds();
        log_unwritten(written);
    }

    /// Replaces the ledger's holds by these. Holds count even if they cannot be written; a cell
    /// goes on only once that is written.
    pub(super) fn replace_holds(
        &mut self,
        holds: Holds,
        most_placements: u32,
    ) -> Result<(), JournalError> {
        let goes_on = holds.is_empty();
        let change = self.ledger.held_by(holds, most_placements);
        let written = self.commit(change.clone()).map(drop);
        if written.is_err() {
            if goes_on {
                return written;
            }
            self.ledger.apply(change);
        }
        self.tell_holds();
        written
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

    /// Notes when the placement that begins now takes too long for its motion.
    pub(super) fn watch_over(&mut self, cycle: Option<&Cycle>) {
        let longest = cycle.and_then(|cycle| Duration::try_from_secs_f64(cycle.cycle_s).ok());
        let longest = longest.filter(|_| !self.limits.overdue.is_zero());
        let longest = longest.map(|longest| longest.saturating_add(self.limits.overdue));
        // What is longer than the clock can count is never overdue.
        self.overdue_at = longest.and_then(|longest| Instant::now().checked_add(longest));
    }

    /// Holds the robot where it takes longer than its motion says: it may stand before something.
    pub(super) fn hold_where_overdue(&mut self) {
        let overdue = self.overdue_at.take_if(|at| *at <= Instant::now());
        let (Some(_), Some(Record::Placement { placement, .. })) =
            (overdue, self.ledger.under_way())
        else {
            return;
        };
        let reason = format!(
            "placement {} takes {} s longer than its motion: look what the robot does",
            placement.placement_id,
            self.limits.overdue.as_secs_f64()
        );
        let hold = Hold::own("overdue", self.ledger.head().state_number, &reason);
        self.robot.share.hold(hold, false);
        self.follow_robot();
    }

    /// Ends holds of the robot; on an error none of them.
    pub(super) fn resume(
        &mut self,
        incoming: &Incoming<v1::ResumeRequest>,
    ) -> Result<v1::ResumeReply, Refusal> {
        let request = incoming.message();
        let ids = read_hold_ids(&request.hold_ids)?;
        self.robot.share.check_open()?;
        self.copy_robot_holds()?;
        if self.ledger.is_held() {
            let change = self.ledger.resume(&ids, request.most_placements);
            let change = change.ok_or_else(|| {
                let holds = &self.ledger.head().holds;
                let message = format!(
                    "the cell is held for another reason: {holds}: see `holds` of its state"
                );
                Refusal(Status::Stale, message)
            })?;
            self.commit(change)?;
            self.robot.share.end_holds(&ids, request.most_placements);
            self.tell_holds();
        }
        Ok(v1::ResumeReply {
            header: None,
            state: Some(self.streams.state_of(&self.ledger)),
        })
    }

    /// Takes note that people had a hand in the container.
    pub(super) fn changed(
        &mut self,
        incoming: &Incoming<v1::ChangedRequest>,
    ) -> Result<v1::ChangedReply, Refusal> {
        let removed = &incoming.message().removed_item_ids;
        let removed = read_ids("removed_item_ids", removed)?;
        if self.ledger.under_way().is_some() {
            return Err(self.busy());
        }
        let change = self.ledger.change_by_hand(&removed);
        self.change(change)?;
        tracing::info!(?removed, "the container was changed by hand");
        self.send_change();
        Ok(v1::ChangedReply {
            header: None,
            state: Some(self.streams.state_of(&self.ledger)),
        })
    }

    /// Writes down a change, makes it and tells of it.
    pub(super) fn change(&mut self, change: Change) -> Result<(), JournalError> {
        self.commit(change)?;
        self.streams.tell_state(&self.ledger);
        Ok(())
    }
}

/// Logs that holds are not written down, where nobody waits for the answer.
pub(super) fn log_unwritten(written: Result<(), JournalError>) {
    if let Err(error) = written {
        tracing::error!(%error, "the robot's holds are not written down");
    }
}

fn read_hold_ids(ids: &[String]) -> Result<Vec<String>, WireError> {
    let field = "hold_ids";
    if ids.is_empty() {
        let reason = "name the holds that are to end, by `holds` of the cell's state";
        return Err(WireError::invalid(field, reason));
    }
    read_ids(field, ids)
}

fn read_ids(field: &'static str, ids: &[String]) -> Result<Vec<String>, WireError> {
    if ids.len() > MOST_IDS {
        let reason = format_args!("{} where at most {MOST_IDS} are possible", ids.len());
        return Err(WireError::invalid(field, reason));
    }
    let ids = ids.iter().map(|id| Ok(header::id(field, id)?.to_owned()));
    ids.collect()
}
