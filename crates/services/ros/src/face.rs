//! What each service of a cell says in ROS, and what can be asked of it there.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use ppnpack_service::process::Process;
use ppnpack_service::stream::{self, Subscription};
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};

use crate::convert;
use crate::error::RosError;
use crate::requests::Requests;
use crate::rmw::keys::{Name, Qos};
use crate::rmw::messages::{Announce, Begin, Changed, Hold, SetBool, TfMessage, Trigger, Withdraw};
use crate::rmw::{Node, Publisher, Server};

/// Who holds where a node of ROS asks for it.
const HOLDER: &str = "ROS";

/// How long the planner may take to tell the session that is under way.
const SESSION_LIMIT: Duration = Duration::from_secs(1);

/// What all cells share.
pub(crate) struct Common {
    pub(crate) process: Process,
    pub(crate) node: Node,
    pub(crate) requests: Requests,
    /// Where items are.
    pub(crate) moving: Arc<Publisher<TfMessage>>,
}

/// What a service of a cell says and answers in ROS, until it is dropped.
type Parts = (Subscription, Vec<Server>);

/// A cell in ROS: what it has of services.
#[derive(Default)]
pub(crate) struct Face {
    pub(crate) bridge: Option<Parts>,
    planner: Option<Parts>,
}

/// What was told last in ROS: by that a request without content is made to say what its caller saw.
type Told<T> = Arc<Mutex<T>>;

impl Face {
    /// Has a service of the cell in ROS, where it is not yet.
    pub(crate) fn meet(
        &mut self,
        common: &Common,
        service: Service,
        name: &Name,
        cell: &Cell,
    ) -> Result<(), RosError> {
        match service {
            Service::Bridge if self.bridge.is_none() => {
                let holds = Told::default();
                let stream = tell_states(common, name, cell, &holds)?;
                self.bridge = Some((stream, serve_bridge(common, name, cell, holds)?));
            }
            Service::Planner if self.planner.is_none() => {
                let failure = Told::default();
                let stream = tell_sessions(common, name, cell, &failure)?;
                self.planner = Some((stream, serve_planner(common, name, cell, failure)?));
            }
            _ => {}
        }
        Ok(())
    }
}

/// Passes each message of a stream on. It runs on Zenoh's thread: `pass_on` waits for nothing.
fn follow<M: prost::Message + prost::Name + Default + 'static>(
    common: &Common,
    cell: &Cell,
    stream: Stream,
    pass_on: impl Fn(&Cell, &M) -> Result<(), RosError> + Send + Sync + 'static,
) -> Result<Subscription, RosError> {
    let own = cell.clone();
    let on_message = move |_, message: M| {
        if let Err(error) = pass_on(&own, &message) {
            tracing::debug!(cell = %own, %stream, %error, "not passed on");
        }
    };
    let (session, cell, limit) = (common.process.session(), Some(cell), MAX_MESSAGE_BYTES);
    Ok(stream::subscribe(session, cell, stream, limit, on_message)?)
}

/// Tells states, and notes what holds the cell by the last.
fn tell_states(
    common: &Common,
    name: &Name,
    cell: &Cell,
    holds: &Told<Vec<String>>,
) -> Result<Subscription, RosError> {
    let states = common.node.publisher(&name.join("state"), Qos::Latched)?;
    let moving = Arc::clone(&common.moving);
    let holds = Arc::clone(holds);
    follow(common, cell, Stream::State, move |cell, state| {
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

fn serve_bridge(
    common: &Common,
    name: &Name,
    cell: &Cell,
    told: Told<Vec<String>>,
) -> Result<Vec<Server>, RosError> {
    let (node, requests) = (&common.node, &common.requests);
    // However many wait for something else, a cell can be held.
    let holds = requests.apart();
    Ok(vec![
        holds.serve(node, &name.join("hold"), cell, |asked: &Hold| {
            v1::HoldRequest {
                reason: asked.reason.clone(),
                is_aborting: asked.is_aborting,
                holder: HOLDER.to_owned(),
                ..v1::HoldRequest::default()
            }
        })?,
        requests.serve(node, &name.join("resume"), cell, move |_: &Trigger| {
            v1::ResumeRequest {
                hold_ids: lock(&told).clone(),
                ..v1::ResumeRequest::default()
            }
        })?,
        requests.serve_by(
            node,
            &name.join("renew"),
            cell,
            |_: &Trigger| (),
            |requests, cell, ()| requests.renew(cell),
        )?,
        requests.serve(node, &name.join("changed"), cell, |asked: &Changed| {
            v1::ChangedRequest {
                removed_item_ids: asked.removed_item_ids.clone(),
                ..v1::ChangedRequest::default()
            }
        })?,
    ])
}

/// Tells sessions, and notes the failure of the last. The one that is under way comes first: the planner tells it on change alone, which
/// may not come for long.
fn tell_sessions(
    common: &Common,
    name: &Name,
    cell: &Cell,
    failure: &Told<String>,
) -> Result<Subscription, RosError> {
    let publisher = common.node.publisher(&name.join("session"), Qos::Latched)?;
    // Whether one was told on change: what was asked for may be older, and is not told after it.
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
    let subscription = follow(common, cell, Stream::Session, on_change)?;
    let request = v1::SessionRequest::default();
    match common.requests.ask(cell, request, SESSION_LIMIT) {
        Ok(reply) => tell(cell, &reply.session.unwrap_or_default(), false)?,
        Err(error) => tracing::debug!(%cell, %error, "the session is told when it changes"),
    }
    Ok(subscription)
}

fn serve_planner(
    common: &Common,
    name: &Name,
    cell: &Cell,
    told: Told<String>,
) -> Result<Vec<Server>, RosError> {
    let (node, requests) = (&common.node, &common.requests);
    Ok(vec![
        requests.serve(node, &name.join("begin"), cell, |asked: &Begin| {
            v1::BeginRequest {
                session_id: asked.session_id.clone(),
                is_automatic: asked.is_automatic,
                least_state_number: asked.least_state_number,
                gives_up_pending: asked.gives_up_pending,
                ..v1::BeginRequest::default()
            }
        })?,
        requests.serve(node, &name.join("announce"), cell, |asked: &Announce| {
            v1::AnnounceRequest {
                items: asked.items.iter().map(convert::read_announcement).collect(),
                ..v1::AnnounceRequest::default()
            }
        })?,
        requests.serve(node, &name.join("withdraw"), cell, |asked: &Withdraw| {
            v1::WithdrawRequest {
                item_id: asked.item_id.clone(),
                ..v1::WithdrawRequest::default()
            }
        })?,
        requests.serve(
            node,
            &name.join("automatic"),
            cell,
            move |asked: &SetBool| v1::AutomaticRequest {
                is_automatic: asked.data,
                failure_id: lock(&told).clone(),
                ..v1::AutomaticRequest::default()
            },
        )?,
    ])
}
