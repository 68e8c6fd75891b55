//! Requests for placements.

use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, Status};

use super::Desk;
use super::share::Taken;
use crate::robot::Placement;
use crate::runner::Job;
use ppnpack_protocol::ledger::{Holds, PlacementVerdict, Record};
use ppnpack_protocol::message;

impl Desk {
    pub(super) fn place(&mut self, incoming: Incoming<v1::PlaceRequest>) {
        let placement = match message::read_placement(incoming.message()) {
            Ok(placement) => placement,
            Err(error) => return incoming.refuse(Status::Invalid, error.to_string()),
        };
        match self.ledger.judge(&placement) {
            PlacementVerdict::Known(outcome) => {
                let execution = message::execution(&placement, outcome);
                incoming.reply(reply(execution), Done::default());
            }
            PlacementVerdict::Conflict => {
                let id = &placement.placement_id;
                let message = format!("placement {id} was asked for before with other content");
                incoming.refuse(Status::Conflict, message);
            }
            PlacementVerdict::Busy => self.refuse_busy(incoming),
            PlacementVerdict::Stale => {
                let message = format!(
                    "it was planned on state {} of the cell, which is now in state {}: plan anew",
                    placement.state_number,
                    self.ledger.head().state_number
                );
                incoming.refuse(Status::Stale, message);
            }
            PlacementVerdict::Forgotten => {
                let message = format!(
                    "it was planned on state {} of the cell, of which nothing is known here: whether it was carried out has to be \
                     seen",
                    placement.state_number
                );
                incoming.refuse(Status::Forgotten, message);
            }
            PlacementVerdict::Held(holds) => refuse_held(incoming, holds),
            PlacementVerdict::New => match self.limits.expired(incoming.message().decided_at_ns) {
                Some(reason) => self.refuse_expired(incoming, reason),
                None => self.accept(incoming, placement),
            },
        }
    }

    /// Refuses a decision that is too old. The cell's state counts up: it begins never more, also where a clock is set back.
    fn refuse_expired(&mut self, incoming: Incoming<v1::PlaceRequest>, reason: String) {
        if let Err(error) = self.change(self.ledger.change_by_hand(&[])) {
            return incoming.refuse(Status::Unavailable, error.to_string());
        }
        self.show();
        tracing::info!(
            placement = incoming.message().placement_id,
            reason,
            "not begun"
        );
        incoming.refuse(Status::Stale, reason);
    }

    fn accept(&mut self, incoming: Incoming<v1::PlaceRequest>, placement: Placement) {
        if let Err((status, message)) = self.reach.check(&placement) {
            return incoming.refuse(status, message);
        }
        let break_off = self.cut_off.of_part();
        if let Err(taken) = self.share.begin(&break_off) {
            return self.refuse_taken(incoming, taken);
        }
        let change = self.ledger.accept(placement.clone());
        let stage = match self.commit(change) {
            Ok(stage) => stage,
            Err(error) => {
                self.share.end();
                return incoming.refuse(Status::Unavailable, error.to_string());
            }
        };
        // Where it was the last of a step.
        for hold in self.ledger.head().holds.iter() {
            self.share.hold(hold.clone(), false);
        }
        let execution = message::execution(&placement, None);
        self.is_robot_busy = true;
        self.watch_over(placement.cycle.as_deref());
        self.send(Job::Place(placement, break_off));
        let done = Done {
            stages: vec![stage],
            ..Done::default()
        };
        incoming.reply(reply(execution), done);
        self.streams.tell_state(&self.ledger);
    }

    /// Refuses what cannot begin because something else has not ended.
    pub(super) fn refuse_busy<R: Request>(&self, incoming: Incoming<R>) {
        if let (Some(_), Some((error, _))) = (&self.unwritten, &self.trouble) {
            let message = format!("what was done is not written down yet: {error}");
            return incoming.refuse(Status::Unavailable, message);
        }
        let message = match self.ledger.under_way() {
            Some(Record::Placement { placement, .. }) => {
                format!("placement {} is being carried out", placement.placement_id)
            }
            _ => "the container is being renewed".to_owned(),
        };
        incoming.refuse(Status::Busy, message);
    }

    /// Refuses what would begin something that the robot cannot, for another container's sake.
    pub(super) fn refuse_taken<R: Request>(&mut self, incoming: Incoming<R>, taken: Taken) {
        let text = taken.to_string();
        match taken {
            Taken::Held(holds) => {
                // What is refused so begins never more: the state has to count up when the cell goes on.
                self.be_held_by(holds);
                incoming.refuse(Status::Held, text);
            }
            Taken::Busy(_) => incoming.refuse(Status::Busy, text),
            Taken::NotOpen(_) => incoming.refuse(Status::Unavailable, text),
        }
    }
}

/// Refuses what would begin something.
pub(super) fn refuse_held<R: Request>(incoming: Incoming<R>, holds: &Holds) {
    incoming.refuse(Status::Held, format!("the cell is held: {holds}"));
}

fn reply(execution: v1::Execution) -> v1::PlaceReply {
    v1::PlaceReply {
        header: None,
        execution: Some(execution),
    }
}
