//! One cell: an actor that owns its session.

mod answers;
mod automatic;
mod closing;
mod inspect;
mod known;
mod place;
mod poses;
mod renew;
mod reported;
mod session;
mod steps;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ppnpack_service::ServiceError;
use ppnpack_service::actor::{Actor, Address, PendingRequests, WeakAddress};
use ppnpack_service::health::HealthLatch;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{CallError, Client, Incoming};
use ppnpack_service::stream::Publisher;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1;

use crate::counts;
use crate::objects::Objects;
use crate::planning::Helpers;
use crate::record::Recorder;
use crate::settings::CellSettings;
use crate::shapes::ItemShapes;
use crate::step::{Step, Stepped, Stepper};
use crate::store::Store;
use automatic::Automatic;
use inspect::ToInspect;
use place::Place;
use ppnpack_protocol::session::{End, SessionError};
use session::KeptSession;
use steps::{UnderWay, Waiting};

/// Maximum sleep of the actor, so that a lost message of the bridge is made up for.
const TICK: Duration = Duration::from_millis(250);

/// Maximum number of requests that wait for a step.
const MOST_WAITING: usize = 64;

/// A message to a cell's actor.
pub(crate) enum Message {
    Begin(Incoming<v1::BeginRequest>),
    Announce(Incoming<v1::AnnounceRequest>),
    Withdraw(Incoming<v1::WithdrawRequest>),
    Plan(Incoming<v1::PlanRequest>),
    Report(Incoming<v1::ReportRequest>),
    Open(Incoming<v1::OpenRequest>),
    Close(Incoming<v1::CloseRequest>),
    Explain(Incoming<v1::ExplainRequest>),
    Automatic(Incoming<v1::AutomaticRequest>),
    Session(Incoming<v1::SessionRequest>),
    Shapes(Incoming<v1::ShapesRequest>),
    /// Says how a placement ended, by the bridge.
    Outcome(v1::Outcome),
    /// Gives the result of the step that was under way.
    Stepped(Box<Stepped>),
    /// Gives the bridge's answer to the request of this id for an empty container.
    Renewed(String, Result<v1::RenewReply, CallError>),
}

/// A cell and its session.
pub(crate) struct CellPlanner {
    cell: Cell,
    settings: CellSettings,
    client: Client,
    shapes: ItemShapes,
    session: KeptSession,
    /// The places of its containers.
    places: Vec<Place>,
    /// Times when the bridge is asked again for empty containers, by the ids of the requests.
    renewals: BTreeMap<String, Instant>,
    decisions: Publisher<v1::Decision>,
    recorder: Arc<Recorder>,
    news: News,
    /// The last decision's item, until it is known how it lies.
    to_inspect: Option<ToInspect>,
    stepper: Address<Step>,
    step_under_way: Option<UnderWay>,
    waiting: PendingRequests<Waiting>,
    automatic: Automatic,
    own_address: WeakAddress<Message>,
}

/// Messages that are published after the request that led to them is answered.
#[derive(Debug, Default)]
struct News {
    decision: Option<v1::Decision>,
    record: Option<v1::PlanningRecord>,
}

impl Actor for CellPlanner {
    type Message = Message;

    fn handle(&mut self, message: Message) {
        self.answer(message);
    }

    fn tick(&mut self) {
        self.publish_news();
        self.go_on_inspecting();
        self.go_on_with_requests();
        self.close_done();
        self.renew_closed();
        self.advance();
        self.publish_news();
    }

    fn next_tick(&self) -> Option<Instant> {
        // How the last item lies is known before the automatic mode goes on.
        let is_free = self.step_under_way.is_none();
        let goes_on = is_free && !self.is_inspecting();
        let automatic = goes_on.then(|| self.automatic.wakes_at(&self.session));
        let inspection = self.next_inspection().filter(|_| is_free);
        let due = [
            automatic.flatten(),
            inspection,
            self.waiting.next_expiry(),
            self.next_renewal(),
            self.session.closes_at,
        ];
        let latest = Instant::now() + TICK;
        Some(due.into_iter().flatten().fold(latest, Instant::min))
    }
}

impl CellPlanner {
    pub(crate) fn new(
        process: &Process,
        cell: &Cell,
        settings: &CellSettings,
        shared: &Arc<Shared>,
        own_address: WeakAddress<Message>,
    ) -> Result<(Self, JoinHandle<()>), ServiceError> {
        let plans = settings.container_plans(cell)?;
        let places = plans
            .into_iter()
            .map(|plan| Place::new(process, plan, shared));
        let places = places.collect::<Result<Vec<Place>, _>>()?;
        let session = KeptSession::read(process, cell, settings, shared)?;
        counts::begin(cell);
        let recorder = Arc::new(Recorder::new(process, cell, settings)?);
        let (stepper, thread) = Stepper::start(
            process,
            cell,
            settings,
            (shared, &recorder),
            &session,
            own_address.clone(),
        )?;
        let mut planner = Self {
            cell: cell.clone(),
            settings: settings.clone(),
            client: shared.helpers.client.clone(),
            shapes: ItemShapes::new(cell, settings, shared)?,
            session,
            places,
            renewals: BTreeMap::new(),
            decisions: Publisher::new(process, cell, Stream::Plan)?,
            recorder,
            news: News::default(),
            to_inspect: None,
            stepper,
            step_under_way: None,
            waiting: PendingRequests::new(MOST_WAITING),
            automatic: Automatic::default(),
            own_address,
        };
        planner.must_have_its_containers()?;
        Ok((planner, thread))
    }

    /// Ends a session whose containers are not those of the settings any more.
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
        let ended = self.session.end(End::Failed(failure));
        ended.map_err(|refusal| ServiceError::start(refusal.message))
    }

    /// Finds the place of a container.
    fn place_of(&mut self, container: &str) -> Result<&mut Place, SessionError> {
        let mut places = self.places.iter_mut();
        let place = places.find(|place| place.name == container);
        place.ok_or_else(|| SessionError::UnknownContainer(container.to_owned()))
    }

    fn publish_news(&mut self) {
        let News { decision, record } = std::mem::take(&mut self.news);
        if let Some(decision) = decision
            && let Err(error) = self.decisions.put(&decision)
        {
            tracing::warn!(cell = %self.cell, %error, "a decision is not published");
        }
        if let Some(record) = record {
            self.recorder.publish(&record);
        }
        self.session.publish();
    }
}

/// Parts that the cells of one planner share.
pub(crate) struct Shared {
    pub(crate) store: Store,
    pub(crate) store_health: HealthLatch,
    pub(crate) objects: Objects,
    pub(crate) helpers: Helpers,
}
