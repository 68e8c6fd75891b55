//! The answers to requests.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Instant;

use nalgebra::{Isometry3, Vector3};
use ppnpack_packing::kernel::item::Item;
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::header::RequestHeader;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::Method;
use ppnpack_wire::rpc;
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{convert, header};

use super::closing::read_start;
use super::place::Place;
use super::poses::PossiblePoses;
use super::{CellPlanner, Message};
use crate::refusal::Refusal;
use crate::settings::set_aside_in_range;
use crate::step::Request;
use ppnpack_protocol::session::{Session, SessionError, closed_container, message, open_container};

/// Maximum number of regions that one session keeps free.
const MAX_REGIONS: usize = 256;

/// Maximum lean of an item's heightmaps where it waits, in radians: seen poses are not exact.
const GREATEST_LEAN_RAD: f64 = 0.15;

/// Maximum number of items that one request may announce.
const MAX_ANNOUNCED: usize = 1_000;

/// Maximum number of shapes that one request may ask for.
const MOST_SHAPES: usize = 1_024;

impl CellPlanner {
    pub(crate) fn answer(&mut self, message: Message) {
        match message {
            Message::Begin(incoming) => self.tell_session(incoming, Self::begin),
            Message::Announce(incoming) => self.tell_session(incoming, Self::announce),
            Message::Withdraw(incoming) => self.tell_session(incoming, Self::withdraw),
            Message::Plan(incoming) => self.wait_for_step(Request::Plan(incoming), None),
            Message::Report(incoming) => self.tell_session(incoming, Self::report),
            Message::Open(incoming) => self.tell_session(incoming, Self::open),
            Message::Close(incoming) => self.tell_session(incoming, Self::close),
            Message::Explain(incoming) => self.wait_for_step(Request::Explain(incoming), None),
            Message::Automatic(incoming) => self.tell_session(incoming, Self::switch),
            Message::Session(incoming) => self.tell_session(incoming, |_, _| Ok(())),
            Message::Shapes(incoming) => self.carry_out(incoming, |planner, request| {
                planner.shapes(&request.message().ids)
            }),
            Message::Outcome(outcome) => self.on_outcome(&outcome),
            Message::Stepped(stepped) => self.on_stepped(*stepped),
            Message::Renewed(id, answer) => self.on_renewed(&id, answer),
        }
    }

    /// Carries out a request that is answered with the session as it is then.
    fn tell_session<R>(
        &mut self,
        incoming: Incoming<R>,
        work: impl FnOnce(&mut Self, &Incoming<R>) -> Result<(), Refusal>,
    ) where
        R: rpc::Request<Reply: From<v1::Session>>,
    {
        self.carry_out(incoming, |planner, request| {
            work(planner, request)?;
            Ok(planner.session.message().into())
        });
    }

    fn carry_out<R: rpc::Request>(
        &mut self,
        incoming: Incoming<R>,
        work: impl FnOnce(&mut Self, &Incoming<R>) -> Result<R::Reply, Refusal>,
    ) {
        if incoming.has_expired() {
            incoming.refuse(Status::TimedOut, "the time limit passed in the queue");
            return;
        }
        // One that begins may have been carried out: then the session under way is its own.
        if R::METHOD != Method::Begin
            && let Err(refusal) = self.must_be_meant(incoming.header())
        {
            return incoming.refuse(refusal.status, refusal.message);
        }
        let started = Instant::now();
        let span = incoming.span().clone();
        match span.in_scope(|| work(self, &incoming)) {
            Ok(reply) => {
                incoming.reply(reply, Done::in_one("work", started.elapsed()));
            }
            Err(refusal) => incoming.refuse(refusal.status, refusal.message),
        }
    }

    /// Refuses what is meant for another session than the one under way, such as by a controller
    /// whose session was replaced.
    pub(super) fn must_be_meant(&self, header: &RequestHeader) -> Result<(), Refusal> {
        match (&header.session_id, self.session.id()) {
            (Some(meant), own) if meant != own => Err(Refusal::new(
                Status::Conflict,
                format_args!("it is meant for session {meant}, and session {own} is under way"),
            )),
            _ => Ok(()),
        }
    }

    fn begin(&mut self, incoming: &Incoming<v1::BeginRequest>) -> Result<(), Refusal> {
        let request = incoming.message();
        let id = header::id("session_id", &request.session_id)?;
        if id != self.session.id() {
            self.must_be_meant(incoming.header())?;
            let session = Session::begin(
                id.to_owned(),
                self.read_containers(request)?,
                request.is_automatic,
                self.read_set_aside(request.set_aside)?,
            );
            let mut session = self
                .session
                .followed_by(session, request.gives_up_pending)?;
            if !self.session.is_settled() {
                for (container, state_number) in self.void_decisions(incoming.deadline())? {
                    session.needs_state(&container, state_number);
                }
            }
            self.session.begin(session)?;
            // The container may be another one since the last picture.
            self.containers_changed();
            self.to_inspect = None;
            self.shapes.forget();
            self.refuse_waiting();
        }
        Ok(())
    }

    fn read_containers(
        &self,
        request: &v1::BeginRequest,
    ) -> Result<Vec<v1::SessionContainer>, Refusal> {
        let starts = request.containers.iter().map(read_start);
        let starts = starts.collect::<Result<Vec<v1::SessionContainer>, _>>()?;
        let mut named = HashSet::new();
        for v1::SessionContainer { container, .. } in &starts {
            if !self.places.iter().any(|place| place.name == *container) {
                return Err(SessionError::UnknownContainer(container.clone()).into());
            }
            if !named.insert(container) {
                return Err(Refusal::invalid(format_args!(
                    "containers: '{container}' is there twice"
                )));
            }
        }
        let least = request.least_state_number;
        if (self.places.len() > 1 || !starts.is_empty()) && least > 0 {
            return Err(Refusal::invalid(
                "least_state_number: each container counts its own states: give it in `containers`",
            ));
        }
        let keep_out = read_regions(&request.keep_out)?;
        let containers = self.places.iter().map(|place| {
            let name = place.name.clone();
            let start = match starts.is_empty() {
                true => Some(open_container(name.clone(), keep_out.clone(), least)),
                false => starts.iter().find(|start| start.container == name).cloned(),
            };
            start.unwrap_or_else(|| closed_container(name))
        });
        Ok(containers.collect())
    }

    /// Has the bridge void what was decided for each container. Gives the states where known.
    fn void_decisions(&mut self, deadline: Instant) -> Result<Vec<(String, Option<u64>)>, Refusal> {
        // Only a bridge tells its clock.
        let pending = self.session.pending();
        let is_by_bridge = pending.is_some_and(|pending| pending.decided_at_ns != 0);
        let void = |place: &mut Place| {
            let state_number = place.void_decisions(is_by_bridge, deadline)?;
            Ok((place.name.clone(), state_number))
        };
        self.places.iter_mut().map(void).collect()
    }

    /// Notes that every container may look otherwise than in the last pictures.
    pub(super) fn containers_changed(&mut self) {
        for place in &mut self.places {
            place.changed(None);
        }
    }

    fn read_set_aside(&self, asked: Option<u32>) -> Result<usize, Refusal> {
        let Some(asked) = asked else {
            return Ok(self.settings.set_aside);
        };
        let limit = usize::try_from(asked).unwrap_or(usize::MAX);
        set_aside_in_range(limit).map_err(Refusal::invalid)?;
        Ok(limit)
    }

    fn announce(&mut self, incoming: &Incoming<v1::AnnounceRequest>) -> Result<(), Refusal> {
        let request = incoming.message();
        if !(1..=MAX_ANNOUNCED).contains(&request.items.len()) {
            return Err(Refusal::invalid(format_args!(
                "items: {} where 1 to {MAX_ANNOUNCED} are possible",
                request.items.len()
            )));
        }
        let mut shapes = Vec::new();
        let mut items = Vec::new();
        let mut announced = Vec::with_capacity(request.items.len());
        for item in &request.items {
            announced.push(self.read_announcement(item, &mut shapes, &mut items)?);
        }
        self.must_not_lie_there(&announced, incoming.deadline())?;
        self.session
            .announce(&shapes, |session| session.announce(announced))?;
        self.automatic.go_on();
        self.shapes.keep(self.session.items());
        self.shapes.add(items);
        Ok(())
    }

    fn read_announcement(
        &self,
        item: &v1::Announcement,
        shapes: &mut Vec<v1::Item>,
        items: &mut Vec<(ItemId, Arc<Item>)>,
    ) -> Result<v1::SessionItem, Refusal> {
        let item_id = header::id("items.item_id", &item.item_id)?.to_owned();
        let rules = message::read_rules(item.rules.as_ref())?;
        let lying = message::read_lying(item.heightmap_from_item.as_ref(), item.waits_at.as_ref())?;
        let frame = lying.heightmap_frame();
        let lean_rad = frame.map_or(0.0, |frame| lean_rad(&frame));
        if lean_rad > GREATEST_LEAN_RAD {
            let lean_deg = lean_rad.to_degrees();
            return Err(Refusal::invalid(format_args!(
                "item {item_id}: where it waits its heightmaps lean by {lean_deg:.0} degrees: \
                     announce it with heightmaps of how it lies"
            )));
        }
        let (object, shape) = match &item.shape {
            Some(v1::announcement::Shape::Object(_)) if lying.heightmap_from_item.is_some() => {
                return Err(Refusal::invalid(format_args!(
                    "item {item_id}: an object lies as the catalogue has it: with heightmap_from_item, announce it with \
                         heightmaps of how it lies"
                )));
            }
            Some(v1::announcement::Shape::Object(name)) => {
                let unknown = || {
                    let text = format!("item {item_id}: the catalogue has no object '{name}'");
                    Refusal::new(Status::NotFound, text)
                };
                let object = self.shapes.named(name);
                (name.clone(), object.ok_or_else(unknown)?.shape)
            }
            Some(v1::announcement::Shape::Item(message)) => {
                let item = Arc::new(convert::item::read(message)?);
                if item.views().len() != self.settings.grid.yaws {
                    return Err(Refusal::invalid(format_args!(
                        "item {item_id} has {} views, but the cell {} yaws",
                        item.views().len(),
                        self.settings.grid.yaws
                    )));
                }
                let shape = ItemId::of(message);
                items.push((shape, item));
                shapes.push(message.clone());
                (message.name.clone(), shape)
            }
            None => {
                return Err(Refusal::invalid(format_args!(
                    "item {item_id}: give the name of an object, or its heightmaps"
                )));
            }
        };
        let read = self.possible_poses(item).read(item);
        let (poses, allowed_poses) =
            read.map_err(|why| Refusal::invalid(format_args!("item {item_id}: {why}")))?;
        let line = message::read_order_line(item.order_line.as_ref())?;
        if !line.bundle.is_empty() || line.urgency > 0 {
            return Err(Refusal::invalid(format_args!(
                "item {item_id}: order_line: bundle and urgency are known no more: give groups of rules.together, and announce \
                     first what is urgent"
            )));
        }
        let frame = |pose: &Isometry3<f64>| convert::pose::write(pose);
        Ok(v1::SessionItem {
            item_id,
            order_line: (line != v1::OrderLine::default()).then(|| Box::new(line)),
            object,
            shape: shape.to_bytes(),
            rules: message::write_rules(&rules),
            heightmap_from_item: lying.heightmap_from_item.as_ref().map(frame),
            waits_at: lying.waits_at.as_ref().map(frame).map(Box::new),
            poses,
            allowed_poses,
            ..v1::SessionItem::default()
        })
    }

    fn possible_poses(&self, item: &v1::Announcement) -> PossiblePoses {
        match &item.shape {
            Some(v1::announcement::Shape::Object(name)) if item.waits_at.is_none() => {
                let object = self.shapes.named(name);
                PossiblePoses {
                    most: u32::try_from(self.settings.poses).unwrap_or(u32::MAX),
                    because: "see `poses` of the planner's cell",
                    known: object.map_or(1, |object| {
                        u32::try_from(object.poses.len()).unwrap_or(u32::MAX)
                    }),
                }
            }
            _ => PossiblePoses {
                most: 1,
                because: "with heightmaps, or with waits_at, it is packed as it lies",
                known: 1,
            },
        }
    }

    fn withdraw(&mut self, incoming: &Incoming<v1::WithdrawRequest>) -> Result<(), Refusal> {
        let v1::WithdrawRequest { item_id, order, .. } = incoming.message();
        match (item_id.as_str(), order.as_str()) {
            (_, "") => self.session.change(|session| session.withdraw(item_id)),
            ("", order) => self
                .session
                .change(|session| session.expects_no_more(order)),
            (_, _) => Err(Refusal::invalid(
                "item_id and order: name an item, or an order of which no more comes, each in a request of its own",
            )),
        }
    }

    fn shapes(&self, ids: &[Vec<u8>]) -> Result<v1::ShapesReply, Refusal> {
        if !(1..=MOST_SHAPES).contains(&ids.len()) {
            return Err(Refusal::invalid(format_args!(
                "ids: {} where 1 to {MOST_SHAPES} are possible",
                ids.len()
            )));
        }
        Ok(self.recorder.shapes(ids))
    }

    fn report(&mut self, incoming: &Incoming<v1::ReportRequest>) -> Result<(), Refusal> {
        let request = incoming.message();
        let missing = || Refusal::invalid("outcome is missing: say how the decision ended");
        let outcome = request.outcome.as_ref().ok_or_else(missing)?;
        self.check_reported(&request.decision_id, outcome, incoming.deadline())?;
        self.enter_outcome(&request.decision_id, outcome)
    }

    /// Enters the outcome of a decision, after which only newer heightmaps count.
    pub(crate) fn enter_outcome(
        &mut self,
        decision_id: &str,
        outcome: &v1::Outcome,
    ) -> Result<(), Refusal> {
        let pending = self.session.pending();
        let container = pending.map(|pending| pending.container.clone());
        self.session
            .change(|session| session.report(decision_id, outcome))?;
        if let Some(container) = container.filter(|_| self.session.pending().is_none()) {
            let state_number = Some(outcome.state_number).filter(|number| *number > 0);
            self.place_of(&container)?.changed(state_number);
            self.has_ended(decision_id, outcome);
        }
        Ok(())
    }

    fn switch(&mut self, incoming: &Incoming<v1::AutomaticRequest>) -> Result<(), Refusal> {
        let (request, request_id) = (incoming.message(), &incoming.header().request_id);
        if self.session.was_switched_by(request_id) {
            return Ok(());
        }
        let is_automatic = request.is_automatic;
        let mut changed = Vec::new();
        if is_automatic && self.session.has_failed() {
            self.session.must_be_acknowledged(&request.failure_id)?;
            // Whoever acknowledges a failure has looked, and may have had a hand in the cell.
            changed = self.void_decisions(incoming.deadline())?;
        }
        self.session.change(|session| {
            for (container, state_number) in &changed {
                session.goes_on_at(container, *state_number);
            }
            session.remember_switch(request_id);
            session.set_automatic(is_automatic, &request.failure_id)
        })
    }
}

pub(super) fn read_regions(regions: &[v1::Region]) -> Result<Vec<v1::Region>, Refusal> {
    if regions.len() > MAX_REGIONS {
        return Err(Refusal::invalid(format_args!(
            "keep_out: {} regions where at most {MAX_REGIONS} are possible",
            regions.len()
        )));
    }
    let is_possible = |region: &v1::Region| {
        let sides = [
            (region.x_min_m, region.x_max_m),
            (region.y_min_m, region.y_max_m),
        ];
        let mut sides = sides.iter();
        sides.all(|(least, most)| least.is_finite() && most.is_finite() && least <= most)
    };
    match regions.iter().all(is_possible) {
        true => Ok(regions.to_vec()),
        false => Err(Refusal::invalid(
            "keep_out: a region needs finite sides, the least before the greatest",
        )),
    }
}

/// Gives the angle between a frame's z axis and the vertical, in radians.
fn lean_rad(frame: &Isometry3<f64>) -> f64 {
    (frame.rotation * Vector3::z()).angle(&Vector3::z())
}
