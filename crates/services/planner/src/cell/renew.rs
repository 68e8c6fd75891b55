//! Containers that were closed: the bridge takes them away and brings empty ones, which are opened
//! or stand ready.
//!
//! The id of the request is on disk before it is sent: whatever is cut off, a container is renewed
//! once. It names the state that the bridge is in while the session wants this: a request that
//! comes late empties nothing that came after. The cell's actor packs the others meanwhile: a
//! thread of its own waits for the bridge and sends the answer to the actor.

use std::time::{Duration, Instant};

use ppnpack_protocol::session::open_container;
use ppnpack_service::process::thread;
use ppnpack_service::rpc::CallError;
use ppnpack_wire::v1;

use super::{CellPlanner, Message};

/// Pause before a container is asked for again.
const PAUSE: Duration = Duration::from_secs(1);

/// Slack, beyond the time of the request, for its thread to send the answer.
const ANSWER_SLACK: Duration = Duration::from_secs(1);

/// Maximum wait for the bridge to say which state that is.
const PATIENCE: Duration = Duration::from_millis(100);

impl CellPlanner {
    pub(super) fn next_renewal(&self) -> Option<Instant> {
        // A last item that is still inspected is looked for where it lies.
        let due = self.session.to_be_renewed();
        let due = due.filter(|(container, _)| !self.is_inspecting_in(&container.container));
        let due = due.map(|(_, id)| {
            let again_at = self.renewals.get(id).copied();
            again_at.unwrap_or_else(Instant::now)
        });
        due.min()
    }

    /// Asks the bridge for an empty container in place of each that was closed so.
    pub(super) fn renew_closed(&mut self) {
        let now = Instant::now();
        let wanted = self.session.to_be_renewed();
        let wanted = wanted.map(|(container, id)| (container.container.clone(), id.to_owned()));
        let wanted: Vec<(String, String)> = wanted.collect();
        self.renewals
            .retain(|id, _| wanted.iter().any(|(_, wanted)| wanted == id));
        for (name, id) in wanted {
            let is_due = self
                .renewals
                .get(&id)
                .is_none_or(|again_at| *again_at <= now);
            if is_due && !self.is_inspecting_in(&name) {
                self.ask_renewal(&name, &id);
            }
        }
    }

    fn ask_renewal(&mut self, name: &str, id: &str) {
        let again_after = match self.try_ask_renewal(name, id) {
            Ok(limit) => limit + ANSWER_SLACK,
            Err(reason) => {
                tracing::warn!(
                    cell = %self.cell, container = name, reason, "a container is not asked for yet"
                );
                PAUSE
            }
        };
        let again_at = Instant::now() + again_after;
        self.renewals.insert(id.to_owned(), again_at);
    }

    /// Asks for a container; gives how long that may take, or says why it is not asked for.
    fn try_ask_renewal(&mut self, name: &str, id: &str) -> Result<Duration, String> {
        let place = self.place_of(name).map_err(|error| error.to_string())?;
        let state = place.bridge.ask_state(Instant::now() + PATIENCE);
        let state = state.ok_or("the bridge does not say its state")?;
        let address = place.address.clone();
        let limit = Duration::from_secs_f64(self.settings.place_limit_s);
        let request_id = id.to_owned();
        let request = v1::RenewRequest {
            header: Some(v1::RequestHeader {
                request_id: request_id.clone(),
                ..v1::RequestHeader::default()
            }),
            state_number: state.state_number,
        };
        let (client, own) = (self.client.clone(), self.own_address.clone());
        let ask = move || {
            let answer = client.call(&address, request, Instant::now() + limit);
            if let Some(actor) = own.upgrade() {
                // An actor that has ended needs no answer.
                actor.send(Message::Renewed(request_id, answer)).ok();
            }
        };
        let asked = thread("renewal", ask);
        asked.map(|_| limit).map_err(|error| error.to_string())
    }

    pub(super) fn on_renewed(&mut self, id: &str, answer: Result<v1::RenewReply, CallError>) {
        let wanted = self
            .session
            .to_be_renewed()
            .find(|(_, wanted)| *wanted == id);
        // Of a session that is gone it is of no use.
        let Some(closed) = wanted.map(|(container, _)| container.clone()) else {
            return;
        };
        let opened = match answer {
            Ok(reply) => self.open_renewed(&closed, reply.state_number),
            Err(error) => Err(error.to_string()),
        };
        if let Err(reason) = opened {
            tracing::warn!(
                cell = %self.cell, container = closed.container, reason, "there is no empty container yet"
            );
            let again_at = Instant::now() + PAUSE;
            self.renewals.insert(id.to_owned(), again_at);
        }
    }

    fn open_renewed(
        &mut self,
        closed: &v1::SessionContainer,
        state_number: u64,
    ) -> Result<(), String> {
        let (name, keep_out) = (closed.container.clone(), closed.keep_out.clone());
        let start = v1::SessionContainer {
            sequence: closed.sequence,
            ..open_container(name, keep_out, state_number)
        };
        self.open_container(start)
            .map_err(|refusal| refusal.message)
    }
}
