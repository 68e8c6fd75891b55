//! Requests for empty containers.

use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::v1::{self, Status};

use super::Desk;
use super::place::refuse_held;
use crate::runner::Job;
use ppnpack_protocol::ledger::RenewalVerdict;

impl Desk {
    pub(super) fn renew(&mut self, incoming: Incoming<v1::RenewRequest>) {
        let request_id = incoming.header().request_id.clone();
        let (asked, now) = (
            incoming.message().state_number,
            self.ledger.head().state_number,
        );
        if asked == 0 {
            let message = "state_number: 0 is no state: name the one whose container is to go, as \
                           bridge/state tells it";
            return incoming.refuse(Status::Invalid, message);
        }
        match self.ledger.judge_renewal(&request_id) {
            RenewalVerdict::Done(state_number) => {
                incoming.reply(reply(state_number), Done::default());
            }
            RenewalVerdict::UnderWay => self.renewals.keep_or_refuse(incoming),
            RenewalVerdict::Busy => self.refuse_busy(incoming),
            RenewalVerdict::Held(holds) => refuse_held(incoming, holds),
            RenewalVerdict::New if asked != now => {
                let message = format!(
                    "state_number: the cell is in state {now}, not {asked}: ask anew where its \
                     container is still to go"
                );
                incoming.refuse(Status::Stale, message);
            }
            RenewalVerdict::New => {
                if let Err(taken) = self.share.may_begin() {
                    return self.refuse_taken(incoming, taken);
                }
                let change = self.ledger.begin_renewal(request_id);
                if let Err(error) = self.commit(change) {
                    return incoming.refuse(Status::Unavailable, error.to_string());
                }
                self.renewals.keep_or_refuse(incoming);
                self.is_robot_busy = true;
                self.send(Job::Renew);
            }
        }
    }

    /// Answers those who wait for the renewal, which has happened.
    pub(super) fn tell_renewed(&mut self, state_number: Option<u64>) {
        for incoming in self.renewals.take(|_| true) {
            incoming.reply(reply(state_number.unwrap_or_default()), Done::default());
        }
    }

    /// Answers those who wait for the renewal, which has failed.
    pub(super) fn tell_not_renewed(&mut self, failure: &str) {
        for incoming in self.renewals.take(|_| true) {
            incoming.refuse(Status::Failed, failure);
        }
    }
}

fn reply(state_number: u64) -> v1::RenewReply {
    v1::RenewReply {
        header: None,
        state_number,
    }
}
