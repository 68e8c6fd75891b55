//! Requests for empty containers.

use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::v1::{self, Status};

use super::place::held;
use super::{Desk, Refusal};
use crate::robot::RobotError;
use crate::runner::Job;
use ppnpack_protocol::ledger::RenewalVerdict;

impl Desk {
    pub(super) fn renew(&mut self, incoming: Incoming<v1::RenewRequest>) {
        match self.renewal(&incoming) {
            Ok(Some(state_number)) => incoming.reply(reply(state_number), Done::default()),
            Ok(None) => self.renewals.keep_or_refuse(incoming),
            Err(Refusal(status, message)) => incoming.refuse(status, message),
        }
    }

    /// Begins a new renewal. Gives the state after one that has ended, `None` while it is under
    /// way.
    fn renewal(&mut self, incoming: &Incoming<v1::RenewRequest>) -> Result<Option<u64>, Refusal> {
        let request_id = &incoming.header().request_id;
        let asked = incoming.message().state_number;
        let now = self.ledger.head().state_number;
        if asked == 0 {
            let message = "state_number: 0 is no state: name the one whose container is to go, as \
                           bridge/state tells it";
            return Err(Refusal(Status::Invalid, message.to_owned()));
        }
        match self.ledger.judge_renewal(request_id) {
            RenewalVerdict::Done(state_number) => Ok(Some(state_number)),
            RenewalVerdict::UnderWay => Ok(None),
            RenewalVerdict::Busy => Err(self.busy()),
            RenewalVerdict::Held(holds) => Err(held(holds)),
            RenewalVerdict::New if asked != now => {
                let message = format!(
                    "state_number: the cell is in state {now}, not {asked}: ask anew where its \
                     container is still to go"
                );
                Err(Refusal(Status::Stale, message))
            }
            RenewalVerdict::New => {
                let free = self.robot.share.check_free();
                free.map_err(|taken| self.taken(taken))?;
                let change = self.ledger.begin_renewal(request_id.clone());
                self.commit(change)?;
                self.is_robot_busy = true;
                self.send(Job::Renew);
                Ok(None)
            }
        }
    }

    /// Answers those who wait for the renewal: with the state afterwards, or why it failed.
    pub(super) fn tell_renewed(&mut self, renewed: &Result<u64, RobotError>) {
        for incoming in self.renewals.take(|_| true) {
            match renewed {
                Ok(state_number) => incoming.reply(reply(*state_number), Done::default()),
                Err(error) => incoming.refuse(Status::Failed, error.to_string()),
            }
        }
    }
}

fn reply(state_number: u64) -> v1::RenewReply {
    v1::RenewReply {
        header: None,
        state_number,
    }
}
