//! Requests for outcomes, and outcomes themselves.

use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::header;
use ppnpack_wire::v1::{self, Status};

use super::Desk;
use crate::robot::Placement;
use ppnpack_protocol::ledger::Outcome;
use ppnpack_protocol::message;

impl Desk {
    pub(super) fn outcome(&mut self, incoming: Incoming<v1::OutcomeRequest>) {
        let id = &incoming.message().placement_id;
        if let Err(error) = header::id("placement_id", id) {
            return incoming.refuse(Status::Invalid, error.to_string());
        }
        match self.ledger.placement(id) {
            None => {
                let message = format!("placement {id} was never accepted, or long ago");
                incoming.refuse(Status::NotFound, message);
            }
            Some((placement, Some(outcome))) => {
                incoming.reply(reply(placement, Some(outcome)), Done::default());
            }
            Some((_, None)) => self.outcomes.keep_or_refuse(incoming),
        }
    }

    /// Answers those who wait for the end of a placement, and publishes it.
    pub(super) fn tell_outcome(&mut self, placement: &Placement, outcome: Option<&Outcome>) {
        let reply = reply(placement, outcome);
        let id = &placement.placement_id;
        let is_asked_for =
            |incoming: &Incoming<v1::OutcomeRequest>| incoming.message().placement_id == *id;
        for incoming in self.outcomes.take(is_asked_for) {
            incoming.reply(reply.clone(), Done::default());
        }
        if let Some(outcome) = reply.execution.and_then(|execution| execution.outcome) {
            self.streams.tell_outcome(&outcome);
        }
    }

    /// Refuses a request whose time limit passed, with what is known of the placement.
    pub(super) fn refuse_outcome(&self, incoming: Incoming<v1::OutcomeRequest>) {
        let id = &incoming.message().placement_id;
        let known = self.ledger.placement(id);
        let known = known.map(|(placement, outcome)| reply(placement, outcome));
        let message = format!("placement {id} is still being carried out");
        incoming.refuse_with(known.unwrap_or_default(), Status::TimedOut, message);
    }
}

fn reply(placement: &Placement, outcome: Option<&Outcome>) -> v1::OutcomeReply {
    v1::OutcomeReply {
        header: None,
        execution: Some(message::execution(placement, outcome)),
    }
}
