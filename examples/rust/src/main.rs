//! A cell controller: announces items, asks for placements, has them executed and reports. It keeps
//! nothing that matters: it, the planner and the bridge may be restarted at any time, and it goes
//! on with the same session.

use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow};
use clap::Parser;
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, ExecutionPhase, ItemState, OutcomeKind, Status};
use zenoh::Wait;

/// Packs objects through a running ppnpack stack.
#[derive(Debug, Parser)]
struct Arguments {
    /// A Zenoh router, or `ppnpack up`; the environment's PPNPACK_ENDPOINT is another default
    #[arg(long, default_value_t = default_endpoint())]
    connect: String,
    /// The cell
    #[arg(long, default_value = "cell-1")]
    cell: String,
    /// Names the session; give it again to go on with it
    #[arg(long)]
    session: Option<String>,
    /// Objects of the planner's catalogue, in the order of arrival
    #[arg(required = true)]
    objects: Vec<String>,
}

/// How long a service may be away, restarts included.
const PATIENCE: Duration = Duration::from_secs(60);

/// How long to wait before a cell that is held is asked again.
const HELD_PAUSE: Duration = Duration::from_millis(200);

fn default_endpoint() -> String {
    std::env::var("PPNPACK_ENDPOINT").unwrap_or_else(|_| "tcp/127.0.0.1:7447".to_owned())
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut controller = Controller {
        client: Client::new(&open(&arguments.connect)?),
        cell: Cell::new(&arguments.cell)?,
    };
    let fresh = || format!("{:032x}", rand::random::<u128>());
    let id = arguments.session.unwrap_or_else(fresh);
    let packed = controller.pack(&id, &arguments.objects)?;
    println!("packed {packed} of {} items", arguments.objects.len());
    Ok(())
}

fn open(endpoint: &str) -> Result<zenoh::Session> {
    let config = format!(
        r#"{{mode: "client", connect: {{endpoints: ["{endpoint}"]}}, scouting: {{multicast: {{enabled: false}}}}}}"#
    );
    let config = zenoh::Config::from_json5(&config).map_err(|error| anyhow!("{error}"))?;
    let session = zenoh::open(config).wait();
    session.map_err(|error| anyhow!("{endpoint} cannot be reached: {error}"))
}

struct Controller {
    client: Client,
    cell: Cell,
}

impl Controller {
    /// Packs objects in one session; gives how many are in the container.
    fn pack(&mut self, session_id: &str, objects: &[String]) -> Result<usize> {
        self.ask(v1::BeginRequest {
            session_id: session_id.to_owned(),
            least_state_number: self.state_number()?,
            ..v1::BeginRequest::default()
        })?;
        // Once another controller has begun another session, this one is refused.
        self.client = self.client.clone().of_session(session_id);
        let items = (1..)
            .zip(objects)
            .map(|(arrival, object)| v1::Announcement {
                item_id: format!("item-{arrival}"),
                shape: Some(v1::announcement::Shape::Object(object.clone())),
                ..v1::Announcement::default()
            });
        self.ask(v1::AnnounceRequest {
            items: items.collect(),
            ..v1::AnnounceRequest::default()
        })?;
        while let Some(decision) = self.next_decision()? {
            let outcome = self.place(&decision)?;
            let how = outcome.kind().as_str_name();
            println!("step {}: {} {how}", decision.step, decision.object);
            self.ask(v1::ReportRequest {
                decision_id: decision.decision_id,
                outcome: Some(outcome),
                ..v1::ReportRequest::default()
            })?;
        }
        let items = self.session()?.items;
        let packed = items.iter().map(|item| item.state() == ItemState::Packed);
        Ok(packed.map(usize::from).sum())
    }

    /// The decision that awaits its outcome, or a new one; `None` when there is nothing left to do.
    fn next_decision(&self) -> Result<Option<v1::Decision>> {
        if let Some(pending) = self.session()?.pending {
            return Ok(Some(pending));
        }
        let reply = self.ask(v1::PlanRequest::default())?;
        for reason in &reply.reasons {
            println!("cannot be placed: {}: {}", reason.item_id, reason.text);
        }
        Ok(reply.decision)
    }

    /// Has the bridge carry a decision out. Safe to repeat: it is executed once.
    fn place(&self, decision: &v1::Decision) -> Result<v1::Outcome> {
        let mut execution = loop {
            let error = match self.ask(v1::PlaceRequest::from(decision)) {
                Ok(reply) => break reply.execution.unwrap_or_default(),
                Err(error) => error,
            };
            let kind = match error.status() {
                // Until somebody resumes it, however long that takes.
                Some(Status::Held) => {
                    std::thread::sleep(HELD_PAUSE);
                    continue;
                }
                // The container is in another state than it was planned on: the placement was never
                // begun.
                Some(Status::Stale) => OutcomeKind::NotPlaced,
                // The bridge lost what it knew: the placement may have been carried out.
                Some(Status::Forgotten) => OutcomeKind::Unknown,
                _ => return Err(error.into()),
            };
            return Ok(v1::Outcome {
                kind: kind.into(),
                failure: error.to_string(),
                state_number: self.state_number()?,
                ..v1::Outcome::default()
            });
        };
        while execution.phase() != ExecutionPhase::Ended {
            let request = v1::OutcomeRequest {
                placement_id: decision.decision_id.clone(),
                ..v1::OutcomeRequest::default()
            };
            execution = self.ask(request)?.execution.unwrap_or_default();
        }
        execution.outcome.context("the bridge told no outcome")
    }

    /// What the planner keeps of this session.
    fn session(&self) -> Result<v1::Session> {
        let reply = self.ask(v1::SessionRequest::default())?;
        Ok(reply.session.unwrap_or_default())
    }

    /// The number of the container's present state.
    fn state_number(&self) -> Result<u64> {
        let reply = self.ask(v1::CellStateRequest::default())?;
        Ok(reply.state.unwrap_or_default().state_number)
    }

    /// Sends a request until it is answered, as long as a service may be away.
    fn ask<R: Request>(&self, request: R) -> Result<R::Reply, CallError> {
        let deadline = Instant::now() + PATIENCE;
        self.client.call(&self.cell, request, deadline)
    }
}
