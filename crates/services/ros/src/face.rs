//! The services of a cell in ROS: what each says, and what can be asked of it.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use ppnpack_service::process::Process;
use ppnpack_service::stream::{self, Subscription};
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, rpc, v1};

use crate::convert;
use crate::error::RosError;
use crate::requests::Requests;
use crate::rmw::keys::{Name, Qos};
use crate::rmw::messages::{
    self, Announce, Begin, Changed, Done, Hold, SetBool, TfMessage, Trigger, Withdraw,
};
use crate::rmw::{Node, Publisher, Server};

/// The holder where a node of ROS asks for a hold.
const HOLDER: &str = "ROS";

/// How long the planner may take to tell the session that is under way.
const SESSION_LIMIT: Duration = Duration::from_secs(1);

pub(crate) struct Common {
    pub(crate) process: Process,
    pub(crate) node: Node,
    pub(crate) requests: Requests,
    pub(crate) moving: Arc<Publisher<TfMessage>>,
}

/// The topics and services of a service of a cell, until they are dropped.
type Parts = (Subscription, Vec<Server>);

/// The services of a cell that are in ROS.
#[derive(Default)]
pub(crate) struct Face {
    pub(crate) bridge: Option<Parts>,
    planner: Option<Parts>,
}

/// The ids that were told last in ROS: a request without content names what its caller saw.
type Told<T> = Arc<Mutex<T>>;

impl Face {
    /// Puts a service of the cell into ROS, where it is not there yet.
    pub(crate) fn meet(
        &mut self,
        common: &Common,
        service: Service,
        name: &Name,
        cell: &Cell,
    ) -> Result<(), RosError> {
        let met = Met { common, name, cell };
        match service {
            Service::Bridge if self.bridge.is_none() => {
                let holds = Told::default();
                self.bridge = Some((met.tell_states(&holds)?, met.serve_bridge(holds)?));
            }
            Service::Planner if self.planner.is_none() => {
                let failure = Told::default();
                self.planner = Some((met.tell_sessions(&failure)?, met.serve_planner(failure)?));
            }
            _ => {}
        }
        Ok(())
    }
}

/// A cell, and its name in ROS.
struct Met<'a> {
    common: &'a Common,
    name: &'a Name,
    cell: &'a Cell,
}

impl Met<'_> {
    /// Passes each message of a stream on. It runs on Zenoh's thread: `pass_on` waits for nothing.
    fn follow<M: prost::Message + prost::Name + Default + 'static>(
        &self,
        stream: Stream,
        pass_on: impl Fn(&Cell, &M) -> Result<(), RosError> + Send + Sync + 'static,
    ) -> Result<Subscription, RosError> {
        let own = self.cell.clone();
        let on_message = move |_, message: M| {
            if let Err(error) = pass_on(&own, &message) {
                tracing::debug!(cell = %own, %stream, %error, "not passed on");
            }
        };
        let (session, cell) = (self.common.process.session(), Some(self.cell));
        let followed = stream::subscribe(session, cell, stream, MAX_MESSAGE_BYTES, on_message);
        Ok(followed?)
    }

    /// Answers a service by whether the stack does what the request of ROS is made to.
    fn serve<S: messages::Service<Response = Done>, R: rpc::Request + 'static>(
        &self,
        requests: &Requests,
        service: &str,
        to_request: impl Fn(&S) -> R + Send + Sync + 'static,
    ) -> Result<Server, RosError> {
        let (node, name) = (&self.common.node, self.name.join(service));
        requests.serve(node, &name, self.cell, to_request, Requests::pass_on)
    }

    /// Tells states, and notes what holds the cell by the last.
    fn tell_states(&self, holds: &Told<Vec<String>>) -> Result<Subscription, RosError> {
        let (node, topic) = (&self.common.node, self.name.join("state"));
        let states = node.publisher(&topic, Qos::Latched)?;
        let moving = Arc::clone(&self.common.moving);
        let holds = Arc::clone(holds);
        self.follow(Stream::State, move |cell, state: &v1::CellState| {
            // Whoever asks because of this state waits until it is noted.
            let mut told = lock(&holds);
            states.publish(&convert::state(cell, state))?;
            *told = state.holds.iter().map(|hold| hold.id.clone()).collect();
            drop(told);
            let transforms = convert::item_frames(cell, state);
            match transforms.is_empty() {
                true => Ok(()),
                false => moving.publish(&TfMessage { transforms }),
            }
        })
    }

    fn serve_bridge(&self, told: Told<Vec<String>>) -> Result<Vec<Server>, RosError> {
        let Common { node, requests, .. } = self.common;
        let renew = self.name.join("renew");
        // However many wait for something else, a cell can be held.
        let holds = &requests.apart();
        Ok(vec![
            self.serve(holds, "hold", |asked: &Hold| v1::HoldRequest {
                reason: asked.reason.clone(),
                is_aborting: asked.is_aborting,
                holder: HOLDER.to_owned(),
                ..v1::HoldRequest::default()
            })?,
            self.serve(requests, "resume", move |_: &Trigger| v1::ResumeRequest {
                hold_ids: lock(&told).clone(),
                ..v1::ResumeRequest::default()
            })?,
            requests.serve(node, &renew, self.cell, |_: &Trigger| (), Requests::renew)?,
            self.serve(requests, "changed", |asked: &Changed| v1::ChangedRequest {
                removed_item_ids: asked.removed_item_ids.clone(),
                ..v1::ChangedRequest::default()
            })?,
        ])
    }

    /// Tells sessions, and notes the failure of the last. The one that is under way comes first:
    /// the planner tells it on change alone, which may not come for long.
    fn tell_sessions(&self, failure: &Told<String>) -> Result<Subscription, RosError> {
        let (node, topic) = (&self.common.node, self.name.join("session"));
        let publisher = node.publisher(&topic, Qos::Latched)?;
        // A session that was asked for may be older than one told on change, and is not told after
        // it.
        let has_changed = Mutex::new(false);
        let failure = Arc::clone(failure);
        let tell = Arc::new(move |cell: &Cell, session: &v1::Session, is_change: bool| {
            let mut has_changed = lock(&has_changed);
            *has_changed |= is_change;
            if *has_changed != is_change {
                return Ok(());
            }
            let mut told = lock(&failure);
            publisher.publish(&convert::session(cell, session))?;
            told.clone_from(&session.failure_id);
            Ok(())
        });
        let changed = Arc::clone(&tell);
        let on_change = move |cell: &Cell, session: &v1::Session| changed(cell, session, true);
        let subscription = self.follow(Stream::Session, on_change)?;
        let (requests, request) = (&self.common.requests, v1::SessionRequest::default());
        match requests.ask(self.cell, request, SESSION_LIMIT) {
            Ok(reply) => tell(self.cell, &reply.session.unwrap_or_default(), false)?,
            Err(error) => tracing::debug!(cell = %self.cell, %error, "told when it changes"),
        }
        Ok(subscription)
    }

    fn serve_planner(&self, told: Told<String>) -> Result<Vec<Server>, RosError> {
        let requests = &self.common.requests;
        Ok(vec![
            self.serve(requests, "begin", |asked: &Begin| v1::BeginRequest {
                session_id: asked.session_id.clone(),
                is_automatic: asked.is_automatic,
                least_state_number: asked.least_state_number,
                gives_up_pending: asked.gives_up_pending,
                ..v1::BeginRequest::default()
            })?,
            self.serve(requests, "announce", |asked: &Announce| {
                v1::AnnounceRequest {
                    items: asked.items.iter().map(convert::read_announcement).collect(),
                    ..v1::AnnounceRequest::default()
                }
            })?,
            self.serve(requests, "withdraw", |asked: &Withdraw| {
                v1::WithdrawRequest {
                    item_id: asked.item_id.clone(),
                    ..v1::WithdrawRequest::default()
                }
            })?,
            self.serve(requests, "automatic", move |asked: &SetBool| {
                v1::AutomaticRequest {
                    is_automatic: asked.data,
                    failure_id: lock(&told).clone(),
                    ..v1::AutomaticRequest::default()
                }
            })?,
        ])
    }
}
