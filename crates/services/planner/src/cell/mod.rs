//! One cell: an actor that owns its session.

mod answers;
mod automatic;
mod believed;
mod bridge_clock;
mod closing;
mod content;
mod counts;
mod decide;
mod footprint;
mod inspect;
mod known;
mod leaving;
mod orders;
mod place;
mod poses;
mod prepare;
mod recording;
mod refusal;
mod renew;
mod reported;

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_catalogue::seen::SeenSolids;
use ppnpack_packing::candidate::{Candidate, Lying};
use ppnpack_packing::item::Item;
use ppnpack_packing::model::Model;
use ppnpack_service::ServiceError;
use ppnpack_service::actor::{Actor, PendingRequests, WeakAddress};
use ppnpack_service::health::HealthLatch;
use ppnpack_service::process::{Process, thread};
use ppnpack_service::rpc::{CallError, Incoming, Once};
use ppnpack_service::stream::Publisher;
use ppnpack_wire::WireError;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1;

use crate::interruption::{Interrupting, Interruption};
use crate::objects::{GridObjects, Object, Objects};
use crate::planning::Helpers;
use crate::record::Recorder;
use crate::settings::CellSettings;
use crate::store::{Store, StoreError};
use automatic::Automatic;
use inspect::ToInspect;
use place::Place;
use ppnpack_protocol::session::item::{arrival, may_be_in, stop};
use ppnpack_protocol::session::{End, Session, SessionError, message};
use refusal::Refusal;

/// How long the actor sleeps at most, so that a lost message of the bridge is made up for.
const TICK: Duration = Duration::from_millis(250);

/// How much longer than its request a thread that makes one may take to say what came of it.
const ANSWER_SLACK: Duration = Duration::from_secs(1);

/// Plans that wait for an inspection at most.
const MOST_PLANS: usize = 64;

/// What a cell is told.
pub(crate) enum Message {
    Begin(Incoming<v1::BeginRequest>),
    Announce(Incoming<v1::AnnounceRequest>),
    Withdraw(Incoming<v1::WithdrawRequest>),
    Plan(Incoming<v1::PlanRequest>),
    Report(Incoming<v1::ReportRequest>),
    Open(Incoming<v1::OpenRequest>),
    Close(Incoming<v1::CloseRequest>),
    Explain(Incoming<v1::ExplainRequest>),
    /// Where it is switched off, the plan that is being made is interrupted until this is dropped.
    Automatic(Incoming<v1::AutomaticRequest>, Option<Interrupting>),
    Session(Incoming<v1::SessionRequest>),
    Shapes(Incoming<v1::ShapesRequest>),
    /// The bridge says how a placement ended.
    Outcome(v1::Outcome),
    /// What perception answered about the placement of this decision.
    Inspected(String, Box<Result<v1::InspectReply, CallError>>),
    /// What the bridge answered to the request of this id for an empty container.
    Renewed(String, Result<v1::RenewReply, CallError>),
}

/// A cell and its session.
pub(crate) struct CellPlanner {
    cell: Cell,
    settings: CellSettings,
    shared: Arc<Shared>,
    /// What can be announced by name.
    objects: Option<Arc<GridObjects>>,
    /// The items of the session that have heightmaps of their own.
    shapes: HashMap<ItemId, Arc<Item>>,
    /// Of these, the solids of those that the catalogue has, as they lie.
    posed_models: HashMap<ItemId, Arc<Model>>,
    /// Of the others: the solids of what was seen of them.
    seen: SeenSolids,
    session: Session,
    /// Whether the session is known to be the newest, by what the bridges know.
    is_compared: bool,
    /// Where its containers stand.
    places: Vec<Place>,
    /// When the bridge is asked again for empty containers, by the ids of the requests.
    renewals: BTreeMap<String, Instant>,
    decisions: Publisher<v1::Decision>,
    sessions: Publisher<v1::Session>,
    recorder: Recorder,
    news: News,
    /// The last decision's item, until it is known how it lies.
    to_inspect: Option<ToInspect>,
    /// Wait until it is inspected.
    plans: PendingRequests<Incoming<v1::PlanRequest>>,
    automatic: Automatic,
    /// Requests that switched it.
    switched: Once,
    /// When containers are looked at that may be closed; `None` until something changes.
    closes_at: Option<Instant>,
    own: Own,
}

/// Where a cell is reached itself, and interrupted.
pub(crate) struct Own {
    pub(crate) address: WeakAddress<Message>,
    pub(crate) interruption: Interruption,
}

/// What is published after the request that led to it is answered.
#[derive(Debug, Default)]
struct News {
    decisions: Vec<v1::Decision>,
    records: Vec<v1::PlanningRecord>,
    is_session_new: bool,
}

impl Actor for CellPlanner {
    type Message = Message;

    fn handle(&mut self, message: Message) {
        self.answer(message);
    }

    fn tick(&mut self) {
        self.publish_news();
        self.inspect();
        self.answer_plans();
        self.close_done();
        self.renew_closed();
        self.advance();
        self.publish_news();
    }

    fn next_tick(&self) -> Option<Instant> {
        // How the last item lies is known before the automatic mode goes on.
        let automatic = match self.is_inspecting() {
            true => None,
            false => self.automatic.wakes_at(&self.session),
        };
        let inspection = self.to_inspect.as_ref().and_then(ToInspect::goes_on_at);
        let due = [
            automatic,
            inspection,
            self.plans.next_expiry(),
            self.next_renewal(),
            self.closes_at,
        ];
        let latest = Instant::now() + TICK;
        Some(due.into_iter().flatten().fold(latest, Instant::min))
    }
}

impl CellPlanner {
    /// Takes up the session that is on disk.
    pub(crate) fn new(
        process: &Process,
        cell: &Cell,
        settings: &CellSettings,
        shared: &Arc<Shared>,
        own: Own,
    ) -> Result<Self, ServiceError> {
        let plans = settings.container_plans(cell)?;
        let places = plans
            .into_iter()
            .map(|plan| Place::new(process, plan, shared, &own));
        let places = places.collect::<Result<Vec<Place>, _>>()?;
        let session = shared.store.session(cell).map_err(ServiceError::start)?;
        counts::begin(cell);
        let mut planner = Self {
            cell: cell.clone(),
            settings: settings.clone(),
            shared: Arc::clone(shared),
            objects: shared.objects.of(settings),
            shapes: HashMap::new(),
            posed_models: HashMap::new(),
            seen: SeenSolids::default(),
            is_compared: session.id().is_empty() || session.has_failed(),
            session,
            places,
            renewals: BTreeMap::new(),
            decisions: Publisher::new(process, cell, Stream::Plan)?,
            sessions: Publisher::new(process, cell, Stream::Session)?,
            recorder: Recorder::new(process, cell, settings)?,
            news: News {
                is_session_new: true,
                ..News::default()
            },
            to_inspect: None,
            plans: PendingRequests::new(MOST_PLANS),
            automatic: Automatic::default(),
            switched: Once::default(),
            // What was closed last may not be on disk.
            closes_at: Some(Instant::now()),
            own,
        };
        planner.must_have_its_containers()?;
        Ok(planner)
    }

    /// Ends a session whose containers are not those of the cell any more: the settings were changed since.
    fn must_have_its_containers(&mut self) -> Result<(), ServiceError> {
        let known = self.session.containers().iter();
        let known: Vec<&str> = known
            .map(|container| container.container.as_str())
            .collect();
        let own: Vec<&str> = self
            .places
            .iter()
            .map(|place| place.name.as_str())
            .collect();
        if known == own || self.session.id().is_empty() {
            return Ok(());
        }
        let failure = format!(
            "the session has containers '{}', but the settings have '{}': begin a new session",
            known.join("', '"),
            own.join("', '")
        );
        let ended = self.change(|session| {
            session.end(End::Failed(failure));
            Ok(())
        });
        ended.map_err(|refusal| ServiceError::start(refusal.message))
    }

    /// Where a container stands.
    fn place_of(&mut self, container: &str) -> Result<&mut Place, SessionError> {
        let mut places = self.places.iter_mut();
        let place = places.find(|place| place.name == container);
        place.ok_or_else(|| SessionError::UnknownContainer(container.to_owned()))
    }

    /// Makes a request from a thread of its own, which sends the answer to the cell's actor.
    fn ask_aside<R: Request>(
        &self,
        thread_name: &str,
        address: Cell,
        request: R,
        limit: Duration,
        tell: impl FnOnce(Result<R::Reply, CallError>) -> Message + Send + 'static,
    ) -> Result<(), ServiceError> {
        let client = self.shared.helpers.client.clone();
        let own = self.own.address.clone();
        let ask = move || {
            let answer = client.call(&address, request, Instant::now() + limit);
            if let Some(actor) = own.upgrade() {
                // An actor that has ended needs no answer.
                actor.send(tell(answer)).ok();
            }
        };
        thread(thread_name, ask).map(drop)
    }

    /// Changes the session and has it on disk before anything else happens; on an error nothing has changed.
    fn change(
        &mut self,
        change: impl FnOnce(&mut Session) -> Result<(), SessionError>,
    ) -> Result<(), Refusal> {
        self.change_with(&[], change)
    }

    /// As [`Self::change`]; saves the heightmaps of items that are new in the session along with it.
    fn change_with(
        &mut self,
        shapes: &[v1::Item],
        change: impl FnOnce(&mut Session) -> Result<(), SessionError>,
    ) -> Result<(), Refusal> {
        let mut next = self.session.clone();
        change(&mut next)?;
        if next == self.session {
            return Ok(());
        }
        let saved = self.shared.store.save(&self.cell, &next, shapes);
        self.saved(saved)?;
        let had_ended = self.session.has_ended();
        self.session = next;
        if self.session.has_ended() && !had_ended {
            counts::sessions_ended(&self.cell, self.message().end(), 1);
        }
        self.news.is_session_new = true;
        self.closes_at = Some(Instant::now());
        Ok(())
    }

    /// Notes whether the disk serves.
    fn saved(&self, saved: Result<(), StoreError>) -> Result<(), Refusal> {
        match saved {
            Ok(()) => {
                self.shared.store_health.pass();
                Ok(())
            }
            // The disk is as good as before.
            Err(error @ StoreError::TooManyShapes { .. }) => Err(error.into()),
            Err(error) => {
                tracing::error!(cell = %self.cell, %error, "nothing is acknowledged");
                self.shared.store_health.fail(error.to_string());
                Err(error.into())
            }
        }
    }

    fn message(&self) -> v1::Session {
        self.session.to_message(self.settings.method.buffer)
    }

    fn publish_news(&mut self) {
        let News {
            decisions,
            records,
            is_session_new,
        } = std::mem::take(&mut self.news);
        for decision in decisions {
            if let Err(error) = self.decisions.put(&decision) {
                tracing::warn!(cell = %self.cell, %error, "a decision is not published");
            }
        }
        for record in &records {
            self.recorder.publish(record);
        }
        if is_session_new && let Err(error) = self.sessions.put(&self.message()) {
            tracing::warn!(cell = %self.cell, %error, "the session is not published");
        }
    }

    /// An item of the session as a step may choose it: in each pose in which it may be packed, as announced first.
    fn candidates(&mut self, item: &v1::SessionItem) -> Result<Vec<Candidate>, Refusal> {
        let mass_kg = self.mass_kg(item);
        let rules = message::read_rules(item.rules.as_ref())?;
        let own = lying(item)?;
        if let Some(known) = self.object(item) {
            let posed = known.poses.iter().take(self.settings.poses);
            let allowed = posed.filter(|posed| may_be_in(item, posed.pose));
            let posed = allowed.map(|posed| Candidate {
                arrival: arrival(item),
                mass_kg,
                lying: match posed.pose {
                    0 => own,
                    _ => posed.lying,
                },
                rules,
                stop: stop(item),
                ..posed.clone()
            });
            let posed: Vec<Candidate> = posed.collect();
            if posed.is_empty() {
                let allowed = &item.allowed_poses;
                return Err(unknown_poses(item, "may only be packed", allowed));
            }
            return Ok(posed);
        }
        let Shape { item: shape, model } = self.shape(item)?;
        Ok(vec![Candidate {
            model,
            mass_kg,
            lying: own,
            rules,
            stop: stop(item),
            ..Candidate::new(arrival(item), shape)
        }])
    }

    /// The heightmaps of an item of the session in one of its poses.
    fn heightmaps(&mut self, item: &v1::SessionItem, pose: usize) -> Result<Arc<Item>, Refusal> {
        if pose == 0 {
            return Ok(self.shape(item)?.item);
        }
        let posed = self.object(item).and_then(|known| known.poses.get(pose));
        let posed = posed.ok_or_else(|| unknown_poses(item, "was packed", &[pose]))?;
        Ok(Arc::clone(&posed.item))
    }

    /// An object of the catalogue by its name.
    fn named(&self, object: &str) -> Option<&Object> {
        self.objects.as_ref()?.named(object)
    }

    /// The object of the catalogue that an item is, where it stands as that has it.
    fn object(&self, item: &v1::SessionItem) -> Option<&Object> {
        let known = self.named(&item.object);
        known.filter(|known| known.shape.to_bytes() == item.shape)
    }

    /// The heightmaps of an item of the session as it was announced, and its solid where the catalogue has it.
    fn shape(&mut self, item: &v1::SessionItem) -> Result<Shape, Refusal> {
        if let Some(known) = self.object(item) {
            return Ok(Shape {
                item: Arc::clone(&known.item),
                model: Some(Arc::clone(&known.model)),
            });
        }
        Ok(Shape {
            item: self.own_shape(item)?,
            model: self.posed_model(item)?,
        })
    }

    /// The solid of an object of the catalogue that lies otherwise than there.
    fn posed_model(&mut self, item: &v1::SessionItem) -> Result<Option<Arc<Model>>, Refusal> {
        let shape = ItemId::from_bytes("items.shape", &item.shape)?;
        if let Some(known) = self.posed_models.get(&shape) {
            return Ok(Some(Arc::clone(known)));
        }
        let frame = lying(item)?.heightmap_from_item;
        let Some((frame, known)) = frame.zip(self.named(&item.object)) else {
            return Ok(None);
        };
        let model = Arc::new(known.model.turned(&frame.rotation));
        self.posed_models.insert(shape, Arc::clone(&model));
        Ok(Some(model))
    }

    /// The heightmaps that an item was announced with.
    fn own_shape(&mut self, item: &v1::SessionItem) -> Result<Arc<Item>, Refusal> {
        let object = &item.object;
        let shape = ItemId::from_bytes("items.shape", &item.shape)?;
        if let Some(item) = self.shapes.get(&shape) {
            return Ok(Arc::clone(item));
        }
        let message = self.shared.store.shape(&self.cell, shape)?.ok_or_else(|| {
            Refusal::unavailable(format_args!(
                "the heightmaps of {object} are not known any more: withdraw the item and announce it anew"
            ))
        })?;
        let item = Arc::new(ppnpack_wire::convert::item::read(&message)?);
        self.shapes.insert(shape, Arc::clone(&item));
        Ok(item)
    }
}

/// How an item lies.
fn lying(item: &v1::SessionItem) -> Result<Lying, WireError> {
    message::read_lying(item.heightmap_from_item.as_ref(), item.waits_at.as_deref())
}

/// Refuses what needs poses of an item that the cell does not know.
fn unknown_poses<N: ToString>(item: &v1::SessionItem, what: &str, poses: &[N]) -> Refusal {
    let v1::SessionItem {
        item_id, object, ..
    } = item;
    let poses: Vec<String> = poses.iter().map(ToString::to_string).collect();
    Refusal::unavailable(format_args!(
        "item {item_id} {what} in pose {} of {object}, which is not known any more: `poses` of the cell has to be as great as \
         then",
        poses.join(" or ")
    ))
}

/// What is known of an item's shape.
struct Shape {
    item: Arc<Item>,
    /// In the frame of the heightmaps.
    model: Option<Arc<Model>>,
}

/// What the cells of one planner share.
pub(crate) struct Shared {
    pub(crate) store: Store,
    pub(crate) store_health: HealthLatch,
    pub(crate) objects: Objects,
    pub(crate) helpers: Helpers,
}
