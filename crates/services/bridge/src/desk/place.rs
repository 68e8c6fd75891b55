//! Requests for placements.

use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::v1::{self, Status};

use super::hold::log_unwritten;
use super::share::Taken;
use super::{Desk, Refusal};
use crate::robot::Placement;
use crate::runner::Job;
use ppnpack_protocol::ledger::{Holds, PlacementVerdict, Record};
use ppnpack_protocol::message;

/// A placement, and how long the stages of accepting it took.
type Execution = (v1::Execution, Vec<v1::StageTiming>);

impl Desk {
    pub(super) fn place(&mut self, incoming: Incoming<v1::PlaceRequest>) {
        match self.execute(incoming.message()) {
            Ok((execution, stages)) => {
                let reply = v1::PlaceReply {
                    header: None,
                    execution: Some(execution),
                };
                let model = None;
                incoming.reply(reply, Done { stages, model });
            }
            Err(Refusal(status, message)) => incoming.refuse(status, message),
        }
    }

    /// Accepts a new placement, or says how far a known one is.
    fn execute(&mut self, request: &v1::PlaceRequest) -> Result<Execution, Refusal> {
        let placement = message::read_placement(request)?;
        let asked = placement.state_number;
        Err(match self.ledger.judge(&placement) {
            PlacementVerdict::Known(outcome) => {
                return Ok((message::execution(&placement, outcome), Vec::new()));
            }
            PlacementVerdict::Conflict => {
                let id = &placement.placement_id;
                let message = format!("placement {id} was asked for before with other content");
                Refusal(Status::Conflict, message)
            }
            PlacementVerdict::Busy => self.busy(),
            PlacementVerdict::Stale => {
                let now = self.ledger.head().state_number;
                let message = format!(
                    "it was planned on state {asked} of the cell, which is now in state {now}: \
                     plan anew"
                );
                Refusal(Status::Stale, message)
            }
            PlacementVerdict::Forgotten => {
                let message = format!(
                    "it was planned on state {asked} of the cell, of which nothing is known here: \
                     whether it was carried out has to be seen"
                );
                Refusal(Status::Forgotten, message)
            }
            PlacementVerdict::Held(holds) => held(holds),
            PlacementVerdict::New => match self.limits.expired(request.decided_at_ns) {
                Some(reason) => self.expire(&placement, reason),
                None => return self.accept(placement),
            },
        })
    }

    /// Makes a decision that is too old stale: as the state counts up, it never begins, even if
    /// the clock is set back.
    fn expire(&mut self, placement: &Placement, reason: String) -> Refusal {
        if let Err(error) = self.change(self.ledger.change_by_hand(&[])) {
            return error.into();
        }
        self.show();
        tracing::info!(placement = placement.placement_id, reason, "not begun");
        Refusal(Status::Stale, reason)
    }

    fn accept(&mut self, placement: Placement) -> Result<Execution, Refusal> {
        self.robot.reach.check(&placement)?;
        let break_off = self.cut_off.of_part();
        let begun = self.robot.share.begin(&break_off);
        begun.map_err(|taken| self.taken(taken))?;
        let written = self.commit(self.ledger.accept(placement.clone()));
        let stage = written.inspect_err(|_| self.robot.share.end())?;
        // The last placement of a step holds the cell, and so the robot.
        for hold in self.ledger.head().holds.iter() {
            self.robot.share.hold(hold.clone(), false);
        }
        let execution = message::execution(&placement, None);
        self.is_robot_busy = true;
        self.watch_over(placement.cycle.as_deref());
        self.send(Job::Place(placement, break_off));
        self.streams.tell_state(&self.ledger);
        Ok((execution, vec![stage]))
    }

    /// Says what has not ended, so that nothing else begins.
    pub(super) fn busy(&self) -> Refusal {
        if let (Some(_), Some((error, _))) = (&self.unwritten, &self.trouble) {
            let message = format!("what was done is not written down yet: {error}");
            return Refusal(Status::Unavailable, message);
        }
        let message = match self.ledger.under_way() {
            Some(Record::Placement { placement, .. }) => {
                format!("placement {} is being carried out", placement.placement_id)
            }
            _ => "the container is being renewed".to_owned(),
        };
        Refusal(Status::Busy, message)
    }

    /// Says why the robot, which other containers have too, may not begin.
    pub(super) fn taken(&mut self, taken: Taken) -> Refusal {
        if let Taken::Held(holds) = &taken {
            // What is refused as held never begins: the state counts up when the cell goes on.
            log_unwritten(self.replace_holds(holds.clone(), 0));
        }
        taken.into()
    }
}

/// Says that nothing begins in a held cell.
pub(super) fn held(holds: &Holds) -> Refusal {
    Refusal(Status::Held, format!("the cell is held: {holds}"))
}
