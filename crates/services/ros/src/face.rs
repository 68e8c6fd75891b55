//! What each service of a cell says in ROS, and what can be asked of it there.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use ppnpack_service::process::Process;
use ppnpack_service::stream::{self, Latest, Subscription};
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};

use crate::convert::{markers, messages, points};
use crate::error::RosError;
use crate::requests::Requests;
use crate::rmw::keys::{Name, Qos};
use crate::rmw::messages::{
    Announce, Begin, Changed, Hold, PointCloud2, SetBool, TfMessage, Trigger, Withdraw,
};
use crate::rmw::{Node, Publisher, Server};

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

/// A cell in ROS: what it has of services, each with its topics.
#[derive(Default)]
pub(crate) struct Face {
    pub(crate) bridge: Option<(Vec<Subscription>, Vec<Server>)>,
    planner: Option<(Vec<Subscription>, Vec<Server>)>,
    perception: Option<Heightmaps>,
    /// Why it was not passed on when that was last tried, which is said once.
    fault: Option<String>,
}

impl Face {
    /// Has a service of the cell in ROS, where it is not yet.
    pub(crate) fn meet(
        &mut self,
        common: &Common,
        service: Service,
        name: &Name,
        cell: &Cell,
    ) -> Result<(), RosError> {
        // A perception service may be there for all cells, and name none.
        let is_seen = matches!(service, Service::Bridge | Service::Perception);
        if is_seen && self.perception.is_none() {
            self.perception = Some(Heightmaps {
                publisher: common
                    .node
                    .publisher(&name.join("heightmap"), Qos::Sensor)?,
                latest: None,
            });
        }
        match service {
            Service::Bridge if self.bridge.is_none() => {
                self.bridge = Some((
                    tell_states(common, name, cell)?,
                    serve_bridge(common, name, cell)?,
                ));
            }
            Service::Planner if self.planner.is_none() => {
                self.planner = Some((
                    tell_sessions(common, name, cell)?,
                    serve_planner(common, name, cell)?,
                ));
            }
            _ => {}
        }
        Ok(())
    }

    /// Passes on what is new and read.
    pub(crate) fn advance(&mut self, common: &Common, cell: &Cell) {
        let passed_on = self
            .perception
            .as_mut()
            .map(|own| own.advance(&common.process, cell));
        let fault = passed_on
            .and_then(Result::err)
            .map(|error| error.to_string());
        if let Some(error) = &fault
            && self.fault != fault
        {
            tracing::warn!(%cell, error, "a cell is not passed on");
        }
        self.fault = fault;
    }
}

/// The heightmaps of a container, of which the newest is passed on while somebody reads them.
struct Heightmaps {
    publisher: Publisher<PointCloud2>,
    latest: Option<Latest<v1::Heightmap>>,
}

impl Heightmaps {
    fn advance(&mut self, process: &Process, cell: &Cell) -> Result<(), RosError> {
        if !self.publisher.has_readers() {
            self.latest = None;
            return Ok(());
        }
        let Some(latest) = &self.latest else {
            let stream = Stream::Heightmap;
            let latest = Latest::subscribe(process, cell, stream, MAX_MESSAGE_BYTES)?;
            self.latest = Some(latest);
            return Ok(());
        };
        // One that is malformed is counted where it is read.
        match latest.take().and_then(|arrived| arrived.message.ok()) {
            Some(message) => self.publisher.publish(&points::heightmap(cell, &message)?),
            None => Ok(()),
        }
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

fn tell_states(common: &Common, name: &Name, cell: &Cell) -> Result<Vec<Subscription>, RosError> {
    let node = &common.node;
    let states = node.publisher(&name.join("state"), Qos::Latched)?;
    let scenes = node.publisher(&name.join("scene"), Qos::Latched)?;
    let outcomes = node.publisher(&name.join("outcomes"), Qos::Events)?;
    let moving = Arc::clone(&common.moving);
    let tell_state = move |cell: &Cell, state: &v1::CellState| {
        states.publish(&messages::state(cell, state))?;
        scenes.publish(&markers::of_state(cell, state))?;
        let transforms = messages::item_frames(cell, state);
        match transforms.is_empty() {
            true => Ok(()),
            false => moving.publish(&TfMessage { transforms }),
        }
    };
    let tell_outcome = move |cell: &Cell, outcome: &v1::Outcome| {
        outcomes.publish(&messages::outcome(cell, outcome))
    };
    Ok(vec![
        follow(common, cell, Stream::State, tell_state)?,
        follow(common, cell, Stream::Outcome, tell_outcome)?,
    ])
}

fn serve_bridge(common: &Common, name: &Name, cell: &Cell) -> Result<Vec<Server>, RosError> {
    let (node, requests) = (&common.node, &common.requests);
    // However many wait for something else, a cell can be held.
    let holds = requests.apart();
    Ok(vec![
        holds.serve(node, &name.join("hold"), cell, |asked: &Hold| {
            v1::HoldRequest {
                reason: asked.reason.clone(),
                is_aborting: asked.is_aborting,
                ..v1::HoldRequest::default()
            }
        })?,
        requests.serve(node, &name.join("resume"), cell, |_: &Trigger| {
            v1::ResumeRequest::default()
        })?,
        requests.serve(node, &name.join("renew"), cell, |_: &Trigger| {
            v1::RenewRequest::default()
        })?,
        requests.serve(node, &name.join("changed"), cell, |asked: &Changed| {
            v1::ChangedRequest {
                removed_item_ids: asked.removed_item_ids.clone(),
                ..v1::ChangedRequest::default()
            }
        })?,
    ])
}

/// Tells sessions, the one that is under way first: the planner tells it on change alone, which may not come for long.
fn tell_sessions(common: &Common, name: &Name, cell: &Cell) -> Result<Vec<Subscription>, RosError> {
    let publisher = common.node.publisher(&name.join("session"), Qos::Latched)?;
    // Whether one was told on change: what was asked for may be older, and is not told after it.
    let has_changed = Mutex::new(false);
    let tell = Arc::new(move |cell: &Cell, session: &v1::Session, is_change: bool| {
        let mut has_changed = has_changed.lock().unwrap_or_else(PoisonError::into_inner);
        *has_changed |= is_change;
        match *has_changed == is_change {
            true => publisher.publish(&messages::session(cell, session)),
            false => Ok(()),
        }
    });
    let changed = Arc::clone(&tell);
    let on_change = move |cell: &Cell, session: &v1::Session| changed(cell, session, true);
    let subscription = follow(common, cell, Stream::Session, on_change)?;
    let request = v1::SessionRequest::default();
    match common.requests.ask(cell, request, SESSION_LIMIT) {
        Ok(reply) => tell(cell, &reply.session.unwrap_or_default(), false)?,
        Err(error) => tracing::debug!(%cell, %error, "the session is told when it changes"),
    }
    Ok(vec![subscription])
}

fn serve_planner(common: &Common, name: &Name, cell: &Cell) -> Result<Vec<Server>, RosError> {
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
                items: asked
                    .items
                    .iter()
                    .map(messages::read_announcement)
                    .collect(),
                ..v1::AnnounceRequest::default()
            }
        })?,
        requests.serve(node, &name.join("withdraw"), cell, |asked: &Withdraw| {
            v1::WithdrawRequest {
                item_id: asked.item_id.clone(),
                ..v1::WithdrawRequest::default()
            }
        })?,
        requests.serve(node, &name.join("automatic"), cell, |asked: &SetBool| {
            v1::AutomaticRequest {
                is_automatic: asked.data,
                ..v1::AutomaticRequest::default()
            }
        })?,
    ])
}
