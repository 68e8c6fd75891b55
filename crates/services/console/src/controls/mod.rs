//! Controls: the operator's orders, carried out by the requests that any controller makes.

mod order;
mod resume;

use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_service::metrics::{self, Metric};
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1;

use crate::directory::Directory;
use crate::now_ms;
use crate::picture::News;
pub(crate) use order::{Action, Order};

/// How long a service may take to answer: a planner plans a step before.
const PATIENCE: Duration = Duration::from_secs(5);

/// How long a bridge may take to bring an empty container, where nobody else waits for it.
const RENEWAL_PATIENCE: Duration = Duration::from_secs(30);

const HOLDER: &str = "operator";

/// The reason of a hold where the operator gives none.
const HELD_HERE: &str = "held at the operator's page";

#[derive(Debug)]
pub(crate) enum ControlError {
    /// The order lacks something, or has something impossible.
    Invalid(String),
    UnknownCell(String),
    /// It has to be confirmed: what to ask.
    Unconfirmed(&'static str),
    /// The service refused it, or it is not possible now.
    Refused(String),
    /// Nobody answered in time: it may have been done.
    Unanswered(String),
}

impl From<CallError> for ControlError {
    fn from(error: CallError) -> Self {
        match error {
            CallError::Refused { .. } => Self::Refused(error.to_string()),
            error => Self::Unanswered(error.to_string()),
        }
    }
}

impl ControlError {
    fn invalid(text: impl Into<String>) -> Self {
        Self::Invalid(text.into())
    }

    /// Gives the label for metrics.
    fn outcome(&self) -> &'static str {
        match self {
            Self::Unanswered(_) => "unanswered",
            _ => "refused",
        }
    }
}

pub(crate) struct Controls {
    client: Client,
    directory: Arc<Directory>,
}

struct Target {
    cell: Cell,
    containers: Vec<Cell>,
}

impl Controls {
    pub(crate) fn new(client: Client, directory: Arc<Directory>) -> Self {
        Self { client, directory }
    }

    /// Carries an order out, and waits for the answer. Gives what was done, for people.
    ///
    /// # Errors
    /// [`ControlError`]
    pub(crate) fn carry_out(
        &self,
        name: &str,
        action: Action,
        order: &Order,
    ) -> Result<String, ControlError> {
        let target = self.target(order)?;
        if let Some(question) = action.question(order)
            && !order.confirmed
        {
            return Err(ControlError::Unconfirmed(question));
        }
        let result = self.perform(action, order, &target);
        let reason = result.as_ref().err();
        let outcome = reason.map_or("done", ControlError::outcome);
        let labels = [("action", name), ("outcome", outcome)];
        metrics::counter(Metric::ControlsTotal, &labels).increment(1);
        tracing::info!(cell = %target.cell, action = name, outcome, ?reason, "a control");
        if let Ok(done) = &result {
            let told = News::Control(format!("At the operator's page: {done}"));
            self.directory
                .change(|picture| picture.apply(now_ms(), &target.cell, told));
        }
        result
    }

    fn perform(
        &self,
        action: Action,
        order: &Order,
        target: &Target,
    ) -> Result<String, ControlError> {
        match action {
            Action::Hold => self.hold(target, &order.reason, false),
            Action::Abort => self.hold(target, &order.reason, true),
            Action::Resume => self.end_holds(target, order.hold_ids()?, 0, "The cell goes on."),
            Action::Step => self.step(target, order.hold_ids()?),
            Action::Touched => self.changed(&target.container(order)?, Vec::new()),
            Action::Removed => self.changed(&target.container(order)?, order.items()?),
            Action::Withdraw => self.withdraw(target, order),
            Action::NewContainer => self.new_container(target, &target.container(order)?),
            Action::Automatic => self.automatic(target, order.is_on()?, &order.failure_id),
        }
    }

    fn target(&self, order: &Order) -> Result<Target, ControlError> {
        let unknown = || ControlError::UnknownCell(order.cell.clone());
        let cell = Cell::new(&order.cell).map_err(|_| unknown())?;
        let containers = self.directory.heard_containers(&cell).ok_or_else(unknown)?;
        Ok(Target { cell, containers })
    }

    fn ask<R: Request>(
        &self,
        of: &Cell,
        request: R,
        patience: Duration,
    ) -> Result<R::Reply, ControlError> {
        let deadline = Instant::now() + patience;
        Ok(self.client.call(of, request, deadline)?)
    }

    /// Holds all containers at the same time: each may have a robot of its own, and one that fails
    /// must not keep the others going.
    fn hold(
        &self,
        target: &Target,
        reason: &str,
        is_aborting: bool,
    ) -> Result<String, ControlError> {
        let reason = if reason.is_empty() { HELD_HERE } else { reason };
        let request = &v1::HoldRequest {
            reason: reason.to_owned(),
            is_aborting,
            holder: HOLDER.to_owned(),
            ..v1::HoldRequest::default()
        };
        std::thread::scope(|scope| {
            let holding = target.containers.iter().map(|container| {
                scope.spawn(move || self.ask(container, request.clone(), PATIENCE).map(drop))
            });
            // All are asked before the first is waited for.
            let holding: Vec<_> = holding.collect();
            let lost = |_| Err(ControlError::Unanswered("the console failed".to_owned()));
            let held = holding.into_iter();
            let held = held.map(|thread| thread.join().unwrap_or_else(lost));
            held.fold(Ok(()), Result::and)
        })?;
        Ok(match is_aborting {
            true => "The cell is held, and what was under way is broken off where the robot can.",
            false => "The cell is held.",
        }
        .to_owned())
    }

    fn changed(&self, container: &Cell, removed: Vec<String>) -> Result<String, ControlError> {
        let text = match removed.as_slice() {
            [] => format!("Somebody had a hand in {container}."),
            items => format!("Taken out of {container}: {}.", items.join(", ")),
        };
        let request = v1::ChangedRequest {
            removed_item_ids: removed,
            ..v1::ChangedRequest::default()
        };
        self.ask(container, request, PATIENCE)?;
        Ok(text)
    }

    fn withdraw(&self, target: &Target, order: &Order) -> Result<String, ControlError> {
        let many = |_| ControlError::invalid("item_ids: one item is withdrawn at a time");
        let [item_id]: [String; 1] = order.items()?.try_into().map_err(many)?;
        let text = format!("{item_id} does not come.");
        let request = v1::WithdrawRequest {
            item_id,
            ..v1::WithdrawRequest::default()
        };
        self.ask(&target.cell, request, PATIENCE)?;
        Ok(text)
    }

    fn automatic(
        &self,
        target: &Target,
        is_automatic: bool,
        failure_id: &str,
    ) -> Result<String, ControlError> {
        let request = v1::AutomaticRequest {
            is_automatic,
            failure_id: failure_id.to_owned(),
            ..v1::AutomaticRequest::default()
        };
        self.ask(&target.cell, request, PATIENCE)?;
        let state = if is_automatic { "on" } else { "off" };
        Ok(format!("The automatic mode is {state}."))
    }

    /// Has the planner close a container and open an empty one; where nobody packs it, the bridge
    /// brings one all the same.
    fn new_container(&self, target: &Target, container: &Cell) -> Result<String, ControlError> {
        let reply = self.ask(&target.cell, v1::SessionRequest::default(), PATIENCE)?;
        let session = reply.session.unwrap_or_default();
        // In a cell with one container it has no name in the session.
        let is_meant = |name: &str| name == container.as_str() || name.is_empty();
        let mut containers = session.containers.into_iter();
        let standing = containers.find(|standing| is_meant(&standing.container));
        let is_begun = !session.session_id.is_empty();
        match standing.filter(|_| is_begun) {
            Some(standing) if standing.is_open => {
                let request = v1::CloseRequest {
                    container: standing.container,
                    sequence: standing.sequence,
                    is_renewed: true,
                    text: "asked for at the operator's page".to_owned(),
                    ..v1::CloseRequest::default()
                };
                self.ask(&target.cell, request, PATIENCE)?;
                let done = "is closed, and an empty one is brought.";
                Ok(format!("{container} {done}"))
            }
            Some(standing) if !standing.renewal_id.is_empty() => {
                let text = format!("an empty container is being brought to {container}");
                Err(ControlError::Refused(text))
            }
            Some(standing) => self.open_renewed(target, container, standing),
            None => {
                self.renew(container)?;
                Ok(format!("An empty container stands at {container}."))
            }
        }
    }

    /// Brings an empty container where one was closed, and has the session go on with it.
    fn open_renewed(
        &self,
        target: &Target,
        container: &Cell,
        standing: v1::SessionContainer,
    ) -> Result<String, ControlError> {
        let least_state_number = self.renew(container)?;
        let request = v1::OpenRequest {
            start: Some(v1::ContainerStart {
                container: standing.container,
                least_state_number,
                ..v1::ContainerStart::default()
            }),
            sequence: standing.sequence,
            ..v1::OpenRequest::default()
        };
        self.ask(&target.cell, request, PATIENCE)?;
        Ok(format!(
            "An empty container stands at {container}, and is packed."
        ))
    }

    /// Has an empty container brought; gives the state that shows it.
    fn renew(&self, container: &Cell) -> Result<u64, ControlError> {
        let told = self.ask(container, v1::CellStateRequest::default(), PATIENCE)?;
        let request = v1::RenewRequest {
            state_number: told.state.unwrap_or_default().state_number,
            ..v1::RenewRequest::default()
        };
        let reply = self.ask(container, request, RENEWAL_PATIENCE)?;
        Ok(reply.state_number)
    }
}

impl Target {
    /// Gives the container that an order names: the only one where it names none.
    fn container(&self, order: &Order) -> Result<Cell, ControlError> {
        let named = match (&order.container, self.containers.as_slice()) {
            (None, [only]) => Some(only),
            (None, _) => None,
            (Some(name), containers) => containers.iter().find(|it| it.as_str() == name),
        };
        named.cloned().ok_or_else(|| {
            let names: Vec<&str> = self.containers.iter().map(Cell::as_str).collect();
            ControlError::invalid(format!("container: one of {} is needed", names.join(", ")))
        })
    }
}
