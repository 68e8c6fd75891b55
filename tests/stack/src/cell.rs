//! A cell controller for tests and measurements.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, ExecutionPhase, ItemState, PlanResult};

/// The maximum time for a request, restarts of services included.
const LIMIT: Duration = Duration::from_secs(20);

/// The maximum time for tries, and the pause between two.
const PATIENCE: Duration = Duration::from_secs(60);
const PAUSE: Duration = Duration::from_millis(100);

/// Asks the services of one cell.
#[derive(Clone)]
pub(crate) struct CellClient {
    client: Client,
    cell: Cell,
}

impl CellClient {
    pub(crate) fn new(client: Client, cell: Cell) -> Self {
        Self { client, cell }
    }

    pub(crate) fn cell(&self) -> &Cell {
        &self.cell
    }

    /// A client of one of its containers, as sessions and decisions name it.
    pub(crate) fn container(&self, name: &str) -> Result<Self> {
        let cell = match name {
            "" => self.cell.clone(),
            name => Cell::new(name)?,
        };
        Ok(Self::new(self.client.clone(), cell))
    }

    /// Does something, and again for a minute while requests are refused or not answered: services
    /// may be away. Fails at once with any other error.
    pub(crate) fn patiently<T>(&self, mut work: impl FnMut(&Self) -> Result<T>) -> Result<T> {
        let until = Instant::now() + PATIENCE;
        loop {
            match work(self) {
                Err(error) if error.is::<CallError>() && Instant::now() < until => {
                    std::thread::sleep(PAUSE);
                }
                done => return done,
            }
        }
    }

    pub(crate) fn ask<R: Request>(&self, request: R) -> Result<R::Reply, CallError> {
        self.ask_within(request, LIMIT)
    }

    pub(crate) fn ask_within<R: Request>(
        &self,
        request: R,
        limit: Duration,
    ) -> Result<R::Reply, CallError> {
        self.client
            .call(&self.cell, request, Instant::now() + limit)
    }

    /// Begins a session, and announces these objects, if any.
    pub(crate) fn begin(
        &self,
        session_id: &str,
        objects: &[&str],
        is_automatic: bool,
    ) -> Result<()> {
        self.ask(v1::BeginRequest {
            session_id: session_id.to_owned(),
            is_automatic,
            least_state_number: self.state()?.state_number,
            ..v1::BeginRequest::default()
        })?;
        match objects {
            [] => Ok(()),
            _ => self.announce(objects),
        }
    }

    /// Announces these objects, in this order; item `i` is called `item-i`.
    pub(crate) fn announce(&self, objects: &[&str]) -> Result<()> {
        let items = objects.iter().enumerate();
        let items = items.map(|(index, object)| v1::Announcement {
            item_id: format!("item-{index}"),
            shape: Some(v1::announcement::Shape::Object((*object).to_owned())),
            ..v1::Announcement::default()
        });
        self.ask(v1::AnnounceRequest {
            items: items.collect(),
            ..v1::AnnounceRequest::default()
        })?;
        Ok(())
    }

    /// Takes the container away and brings an empty one.
    pub(crate) fn renew(&self) -> Result<()> {
        self.ask(v1::RenewRequest {
            state_number: self.state()?.state_number,
            ..v1::RenewRequest::default()
        })?;
        Ok(())
    }

    pub(crate) fn hold(&self, reason: &str) -> Result<v1::HoldReply> {
        Ok(self.ask(v1::HoldRequest {
            reason: reason.to_owned(),
            ..v1::HoldRequest::default()
        })?)
    }

    pub(crate) fn resume(&self) -> Result<()> {
        let holds = self.state()?.holds.into_iter();
        let hold_ids: Vec<String> = holds.map(|hold| hold.id).collect();
        if !hold_ids.is_empty() {
            self.ask(v1::ResumeRequest {
                hold_ids,
                ..v1::ResumeRequest::default()
            })?;
        }
        Ok(())
    }

    /// Switches the automatic mode on, which acknowledges a failure.
    pub(crate) fn acknowledge(&self) -> Result<()> {
        self.ask(v1::AutomaticRequest {
            is_automatic: true,
            failure_id: self.session()?.failure_id,
            ..v1::AutomaticRequest::default()
        })?;
        Ok(())
    }

    pub(crate) fn state(&self) -> Result<v1::CellState> {
        let reply = self.ask(v1::CellStateRequest::default())?;
        reply.state.context("the bridge told no state")
    }

    pub(crate) fn session(&self) -> Result<v1::Session> {
        let reply = self.ask(v1::SessionRequest::default())?;
        reply.session.context("the planner told no session")
    }

    /// Asks for a decision; `None` where nothing is left to decide.
    pub(crate) fn plan(&self) -> Result<Option<v1::Decision>> {
        let reply = self.ask(v1::PlanRequest::default())?;
        let is_decided = reply.result() == PlanResult::Decided;
        Ok(reply.decision.filter(|_| is_decided))
    }

    pub(crate) fn place(&self, decision: &v1::Decision) -> Result<v1::Outcome> {
        let container = self.container(&decision.container)?;
        let reply = container.ask(v1::PlaceRequest::from(decision))?;
        let mut execution = reply.execution.unwrap_or_default();
        while execution.phase() != ExecutionPhase::Ended {
            let reply = container.ask(v1::OutcomeRequest {
                placement_id: decision.decision_id.clone(),
                ..v1::OutcomeRequest::default()
            })?;
            execution = reply.execution.unwrap_or_default();
        }
        execution.outcome.context("the bridge told no outcome")
    }

    pub(crate) fn report(&self, decision: &v1::Decision, outcome: v1::Outcome) -> Result<()> {
        self.ask(v1::ReportRequest {
            decision_id: decision.decision_id.clone(),
            outcome: Some(outcome),
            ..v1::ReportRequest::default()
        })?;
        Ok(())
    }

    pub(crate) fn carry_out(&self, decision: &v1::Decision) -> Result<()> {
        let outcome = self.place(decision)?;
        self.report(decision, outcome)
    }

    /// Plans, places and reports one step, or ends the one that was begun. Gives the decision,
    /// `None` where nothing is left.
    #[cfg(test)]
    pub(crate) fn step(&self) -> Result<Option<v1::Decision>> {
        let begun = self.session()?.pending;
        let Some(decision) = begun.map_or_else(|| self.plan(), |begun| Ok(Some(begun)))? else {
            return Ok(None);
        };
        self.carry_out(&decision)?;
        Ok(Some(decision))
    }

    /// Checks that planner and bridge agree: every packed item lies once in its container, and
    /// nothing else does but the item of a decision whose outcome was not reported yet.
    ///
    /// # Errors
    /// Where an item is lost, there twice or unknown, or a request was refused.
    pub(crate) fn check_consistent(&self) -> Result<()> {
        let (session, states) = self.session_with_states()?;
        for (container, state) in &states {
            let checked = check_container(&session, container, state);
            checked.with_context(|| format!("container '{}'", container.container))?;
        }
        Ok(())
    }

    /// The session, and the states of its open containers while it was so.
    fn session_with_states(
        &self,
    ) -> Result<(v1::Session, Vec<(v1::SessionContainer, v1::CellState)>)> {
        loop {
            let session = self.session()?;
            let containers = session.containers.iter();
            let open = containers.filter(|container| container.is_open);
            let states = open.map(|container| {
                let state = self.container(&container.container)?.state()?;
                Ok((container.clone(), state))
            });
            let states: Vec<_> = states.collect::<Result<_>>()?;
            let after = self.session()?;
            // Of several containers one may be closed and renewed meanwhile.
            if after.containers.len() < 2 || after.containers == session.containers {
                return Ok((session, states));
            }
        }
    }
}

fn check_container(
    session: &v1::Session,
    container: &v1::SessionContainer,
    state: &v1::CellState,
) -> Result<()> {
    let mut bodies: BTreeMap<&str, usize> = BTreeMap::new();
    for body in &state.bodies {
        *bodies.entry(&body.item_id).or_default() += 1;
    }
    let lies_here = |item: &&v1::SessionItem| {
        item.state() == ItemState::Packed
            && item.container == container.container
            && item.container_sequence == container.sequence
    };
    let may_lie_here = |item: &&v1::SessionItem| match item.state() {
        ItemState::Packed => lies_here(item),
        ItemState::Decided => session
            .pending
            .as_ref()
            .is_none_or(|pending| pending.container == container.container),
        ItemState::Gone => true,
        _ => false,
    };
    let ids = |is_one: &dyn Fn(&&v1::SessionItem) -> bool| -> BTreeSet<&str> {
        let items = session.items.iter().filter(is_one);
        items.map(|item| item.item_id.as_str()).collect()
    };
    let (packed, known) = (ids(&lies_here), ids(&may_lie_here));
    let there = || bodies.keys().copied();
    let twice: Vec<_> = there().filter(|item| bodies.get(item) > Some(&1)).collect();
    ensure!(twice.is_empty(), "placed twice: {twice:?}");
    let lost: Vec<_> = packed
        .iter()
        .filter(|item| !bodies.contains_key(**item))
        .collect();
    ensure!(
        lost.is_empty(),
        "acknowledged as packed, but not there: {lost:?}"
    );
    let unknown: Vec<_> = there().filter(|item| !known.contains(item)).collect();
    ensure!(unknown.is_empty(), "placed, but not decided: {unknown:?}");
    Ok(())
}
