//! One step of Algorithm 1 for a cell, on a thread of its own: pictures, content, plan.
//!
//! It is given the session as it is, and says what would be entered. The cell's actor answers
//! others meanwhile, enters what still holds, and has planned again what does not.

mod believed;
mod container;
mod content;
mod decide;
mod footprint;
mod inspect;
mod known;
mod leaving;
pub(crate) mod plan;
mod prepare;

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;

use ppnpack_protocol::session::{Session, SessionError};
use ppnpack_service::ServiceError;
use ppnpack_service::actor::{self, Actor, Address, WeakAddress};
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{Client, Incoming};
use ppnpack_wire::WireError;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::cell::{Message, Shared};
use crate::record::Recorder;
use crate::refusal::Refusal;
use crate::settings::{CellSettings, ContainerPlan};
use crate::shapes::ItemShapes;
pub(crate) use container::Change;
use container::Container;
pub(crate) use decide::{Chosen, Decided};
pub(crate) use inspect::{Inspect, NotInspected};

/// The work of a step's thread.
pub(crate) struct Step {
    /// The session as it is.
    pub(crate) session: Session,
    /// Changes of each container since the step before, in the order of the cell.
    pub(crate) changes: Vec<Change>,
    pub(crate) work: Work,
}

/// The thing that is done in a step.
pub(crate) enum Work {
    /// Decides which item goes where, for the automatic mode, until then.
    Automatic(Instant),
    Requested(Request),
    /// Has perception inspect the item that was placed last.
    Inspect(Inspect),
}

/// A request that is answered by a step.
pub(crate) enum Request {
    /// Asks which item goes where.
    Plan(Incoming<v1::PlanRequest>),
    /// Asks where one item would go, or why nowhere.
    Explain(Incoming<v1::ExplainRequest>),
}

/// The result of a step.
pub(crate) enum Stepped {
    Automatic(Instant, Planned),
    Plan(Incoming<v1::PlanRequest>, Planned),
    Explain(
        Incoming<v1::ExplainRequest>,
        Result<Box<v1::ExplainReply>, NotPlanned>,
    ),
    /// Inspection after the decision of this id.
    Inspection(String, Result<v1::Inspection, NotInspected>),
}

/// The result of deciding.
pub(crate) struct Planned {
    /// The items that are set aside first, in their order.
    pub(crate) set_aside: Vec<v1::ItemReason>,
    pub(crate) decided: Result<Decided, NotPlanned>,
}

/// Why nothing was planned.
pub(crate) enum NotPlanned {
    /// It is not possible.
    Refused(Refusal),
    /// A picture, or the state of a bridge, is missing: it may come.
    Unseen(Refusal),
    /// The session is not what the cell is, so that somebody has to look.
    Failed(String),
}

impl From<Refusal> for NotPlanned {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl From<SessionError> for NotPlanned {
    fn from(error: SessionError) -> Self {
        Self::Refused(error.into())
    }
}

impl From<WireError> for NotPlanned {
    fn from(error: WireError) -> Self {
        Self::Refused(error.into())
    }
}

/// Plans the steps of a cell, one after another.
pub(crate) struct Stepper {
    cell: Cell,
    settings: CellSettings,
    client: Client,
    actor: WeakAddress<Message>,
    shapes: ItemShapes,
    containers: Vec<Container>,
    recorder: Arc<Recorder>,
    /// The session of the step that is planned.
    session: Session,
    /// The name of the session that was on disk as this process began, until it is held against
    /// what the bridges know.
    to_compare: Option<String>,
}

impl Stepper {
    /// Starts the thread; `session` is that on disk. It ends when nobody has its address.
    pub(crate) fn start(
        process: &Process,
        cell: &Cell,
        settings: &CellSettings,
        (shared, recorder): (&Arc<Shared>, &Arc<Recorder>),
        session: &Session,
        actor: WeakAddress<Message>,
    ) -> Result<(Address<Step>, JoinHandle<()>), ServiceError> {
        let plans = settings.container_plans(cell)?.into_iter();
        let containers = plans.map(|plan: ContainerPlan| Container::new(process, plan, shared));
        let is_known = session.id().is_empty() || session.has_failed();
        let stepper = Self {
            cell: cell.clone(),
            settings: settings.clone(),
            client: shared.helpers.client.clone(),
            actor,
            shapes: ItemShapes::new(cell, settings, shared)?,
            containers: containers.collect::<Result<_, ServiceError>>()?,
            recorder: Arc::clone(recorder),
            session: Session::default(),
            to_compare: (!is_known).then(|| session.id().to_owned()),
        };
        let (address, mailbox) = actor::mailbox(1);
        let thread = actor::spawn(process, &format!("step-{cell}"), stepper, mailbox)?;
        Ok((address, thread))
    }

    /// Goes on from the session as it is, and what happened since.
    fn take_over(&mut self, session: Session, changes: Vec<Change>) {
        if session.id() != self.session.id() {
            self.shapes.forget();
        }
        self.session = session;
        self.shapes.keep(self.session.items());
        for (container, change) in self.containers.iter_mut().zip(changes) {
            container.take_over(change);
        }
    }

    /// Finds a container.
    fn container(&mut self, name: &str) -> Result<&mut Container, SessionError> {
        let mut containers = self.containers.iter_mut();
        let container = containers.find(|container| container.name == name);
        container.ok_or_else(|| SessionError::UnknownContainer(name.to_owned()))
    }

    fn work(&mut self, work: Work) -> Stepped {
        match work {
            Work::Automatic(deadline) => {
                let span = tracing::info_span!("step", cell = %self.cell);
                let alternatives = self.settings.alternatives;
                let planned = span.in_scope(|| self.decide(None, alternatives, deadline));
                Stepped::Automatic(deadline, planned)
            }
            Work::Requested(Request::Plan(incoming)) => {
                let (id, deadline) = (&incoming.header().request_id, incoming.deadline());
                let alternatives = incoming.message().alternatives as usize;
                let span = incoming.span();
                let planned = span.in_scope(|| self.decide(Some(id), alternatives, deadline));
                Stepped::Plan(incoming, planned)
            }
            Work::Requested(Request::Explain(incoming)) => {
                let (item_id, deadline) = (&incoming.message().item_id, incoming.deadline());
                let span = incoming.span();
                let explained = span.in_scope(|| self.explain(item_id, deadline));
                Stepped::Explain(incoming, explained.map(Box::new))
            }
            Work::Inspect(inspect) => {
                let inspected = self.inspect(&inspect);
                Stepped::Inspection(inspect.decision_id, inspected)
            }
        }
    }
}

impl Actor for Stepper {
    type Message = Step;

    fn handle(&mut self, step: Step) {
        self.take_over(step.session, step.changes);
        let stepped = self.work(step.work);
        // An actor that has ended needs no answer.
        if let Some(actor) = self.actor.upgrade() {
            actor.send(Message::Stepped(Box::new(stepped))).ok();
        }
    }
}
