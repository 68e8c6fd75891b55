//! Requests for outcomes, and outcomes themselves.

use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{header, rpc};

use super::Desk;
use crate::ledger::Outcome;
use crate::message;
use crate::robot::Placement;

/// Requests that wait for the end of a placement at most.
const MAX_WAITING: usize = 256;

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
                let execution = message::execution(placement, Some(outcome));
                incoming.reply(reply(execution), Done::default());
            }
            Some((_, None)) if self.progress.outcomes.len() < MAX_WAITING => {
                self.progress.outcomes.push(incoming);
            }
            Some((_, None)) => incoming.refuse(Status::Busy, "too many wait for this outcome"),
        }
    }

    /// Answers those who wait for the end of a placement, and publishes it.
    pub(super) fn tell_outcome(&mut self, placement: &Placement, outcome: Option<&Outcome>) {
        let execution = message::execution(placement, outcome);
        let id = &placement.placement_id;
        let waiting = &mut self.progress.outcomes;
        for incoming in waiting.extract_if(.., |waiting| waiting.message().placement_id == *id) {
            incoming.reply(reply(execution.clone()), Done::default());
        }
        if let Some(outcome) = &execution.outcome {
            self.streams.tell_outcome(outcome);
        }
    }

    /// The time limit passed.
    pub(super) fn refuse_outcome(&self, incoming: Incoming<v1::OutcomeRequest>) {
        let id = &incoming.message().placement_id;
        let known = self.ledger.placement(id);
        let execution = known.map(|(placement, outcome)| message::execution(placement, outcome));
        let reply = execution.map(reply).unwrap_or_default();
        let message = format!("placement {id} is still being carried out");
        incoming.refuse_with(reply, Status::TimedOut, message);
    }
}

fn reply(execution: v1::Execution) -> <v1::OutcomeRequest as rpc::Request>::Reply {
    v1::OutcomeReply {
        header: None,
        execution: Some(execution),
    }
}
