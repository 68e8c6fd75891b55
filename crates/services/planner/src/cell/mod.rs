//! One cell: an actor that owns its session.

mod answers;
mod automatic;
mod believed;
mod bridge;
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
mod session;
mod shapes;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_service::ServiceError;
use ppnpack_service::actor::{Actor, PendingRequests, WeakAddress};
use ppnpack_service::health::HealthLatch;
use ppnpack_service::process::{Process, thread};
use ppnpack_service::rpc::{CallError, Client, Incoming, Once};
use ppnpack_service::stream::Publisher;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1;

use crate::interruption::{Interrupting, Interruption};
use crate::objects::Objects;
use crate::planning::Helpers;
use crate::record::Recorder;
use crate::settings::CellSettings;
use crate::store::Store;
use automatic::Automatic;
use inspect::ToInspect;
use place::Place;
use ppnpack_protocol::session::{End, SessionError};
use session::KeptSession;
use shapes::ItemShapes;

/// Maximum sleep of the actor, so that a lost message of the bridge is made up for.
const TICK: Duration = Duration::from_millis(250);

/// Slack, beyond the time of its request, for a thread that makes one to send the answer.
const ANSWER_SLACK: Duration = Duration::from_secs(1);

/// Maximum number of plans that wait for an inspection.
const MOST_PLANS: usize = 64;

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
    /// Switches the automatic mode; off: the plan that is being made is interrupted until the
    /// second field is dropped.
    Automatic(Incoming<v1::AutomaticRequest>, Option<Interrupting>),
    Session(Incoming<v1::SessionRequest>),
    Shapes(Incoming<v1::ShapesRequest>),
    /// Says how a placement ended, by the bridge.
    Outcome(v1::Outcome),
    /// Gives perception's answer about the placement of this decision.
    Inspected(String, Box<Result<v1::InspectReply, CallError>>),
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
    /// Whether the session is known to be the newest, by what the bridges know.
    is_compared: bool,
    /// The places of its containers.
    places: Vec<Place>,
    /// Times when the bridge is asked again for empty containers, by the ids of the requests.
    renewals: BTreeMap<String, Instant>,
    decisions: Publisher<v1::Decision>,
    recorder: Recorder,
    news: News,
    /// The last decision's item, until it is known how it lies.
    to_inspect: Option<ToInspect>,
    /// Plans that wait until it is inspected.
    plans: PendingRequests<Incoming<v1::PlanRequest>>,
    automatic: Automatic,
    /// Requests that switched the automatic mode.
    switched: Once,
    own: Own,
}

/// Handles by which a cell's actor is reached, and its plans are interrupted.
pub(crate) struct Own {
    pub(crate) address: WeakAddress<Message>,
    pub(crate) interruption: Interruption,
}

/// Messages that are published after the request that led to them is answered.
#[derive(Debug, Default)]
struct News {
    decisions: Vec<v1::Decision>,
    records: Vec<v1::PlanningRecord>,
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
        own: Own,
    ) -> Result<Self, ServiceError> {
        let plans = settings.container_plans(cell)?;
        let places = plans
            .into_iter()
            .map(|plan| Place::new(process, plan, shared, &own));
        let places = places.collect::<Result<Vec<Place>, _>>()?;
        let session = KeptSession::read(process, cell, settings, shared)?;
        counts::begin(cell);
        let mut planner = Self {
            cell: cell.clone(),
            settings: settings.clone(),
            client: shared.helpers.client.clone(),
            shapes: ItemShapes::new(cell, settings, shared)?,
            is_compared: session.id().is_empty() || session.has_failed(),
            session,
            places,
            renewals: BTreeMap::new(),
            decisions: Publisher::new(process, cell, Stream::Plan)?,
            recorder: Recorder::new(process, cell, settings)?,
            news: News::default(),
            to_inspect: None,
            plans: PendingRequests::new(MOST_PLANS),
            automatic: Automatic::default(),
            switched: Once::default(),
            own,
        };
        planner.must_have_its_containers()?;
        Ok(planner)
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

    /// Makes a request from a thread of its own, which sends the answer to the cell's actor.
    fn ask_aside<R: Request>(
        &self,
        thread_name: &str,
        address: Cell,
        request: R,
        limit: Duration,
        tell: impl FnOnce(Result<R::Reply, CallError>) -> Message + Send + 'static,
    ) -> Result<(), ServiceError> {
        let client = self.client.clone();
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

    fn publish_news(&mut self) {
        let News { decisions, records } = std::mem::take(&mut self.news);
        for decision in decisions {
            if let Err(error) = self.decisions.put(&decision) {
                tracing::warn!(cell = %self.cell, %error, "a decision is not published");
            }
        }
        for record in &records {
            self.recorder.publish(record);
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
