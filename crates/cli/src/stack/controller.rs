//! A cell controller: announces items, asks for placements, has them executed, reports.

use std::time::{Duration, Instant};

use anyhow::Context;
use ppnpack_physics::moves::{LastPoses, Moves};
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, ExecutionPhase, PlanResult};

use super::report;
use crate::failure::{OrRun, Outcome};

/// Maximum time of one request.
pub const REQUEST_LIMIT: Duration = Duration::from_secs(30);

/// Maximum time of one placement.
const PLACE_LIMIT: Duration = Duration::from_secs(300);

/// Controls one cell over the wire.
pub struct Controller {
    client: Client,
    cell: Cell,
}

/// A decision and what became of it.
#[derive(Debug, Clone)]
pub(crate) struct Done {
    pub(crate) decision: v1::Decision,
    pub(crate) outcome: v1::Outcome,
    /// Its changes of how everything lies.
    pub(crate) moves: Moves,
}

/// The end of a packing.
#[derive(Debug, Clone)]
pub(crate) struct Packed {
    pub(crate) done: Vec<Done>,
    /// The reasons why nothing of the buffer fits; empty where nothing waits any more.
    pub(crate) reasons: Vec<v1::ItemReason>,
    /// The items that were set aside for the next container, and why.
    pub(crate) set_aside: Vec<v1::ItemReason>,
    /// The content of the container.
    pub(crate) state: v1::CellState,
    /// Perception's view of it.
    pub(crate) heightmap: v1::Heightmap,
}

impl Controller {
    /// Makes a controller of `cell`, which asks by `client`.
    pub fn new(client: Client, cell: Cell) -> Self {
        Self { client, cell }
    }

    /// Has the container taken away and an empty one brought.
    pub fn renew(&self) -> Outcome {
        let request = v1::RenewRequest {
            state_number: self.state()?.state_number,
            ..v1::RenewRequest::default()
        };
        self.ask("bridge", request, PLACE_LIMIT)?;
        Ok(())
    }

    /// Packs items into the container as it is, in one session, in which so many may be set aside.
    /// Beside each choice so many alternatives are asked for; `on_step` is called after each
    /// placement.
    pub(crate) fn pack(
        &self,
        items: &[v1::Announcement],
        set_aside: u32,
        alternatives: u32,
        on_step: &mut dyn FnMut(),
    ) -> Outcome<Packed> {
        let session_id = format!("pack-{:032x}", rand::random::<u128>());
        self.begin(&session_id, items, set_aside)?;
        let mut done = Vec::new();
        let mut last_poses = LastPoses::default();
        let reasons = loop {
            let request = v1::PlanRequest {
                alternatives,
                ..v1::PlanRequest::default()
            };
            let reply = self.ask("planner", request, REQUEST_LIMIT)?;
            match (reply.result(), reply.decision) {
                (PlanResult::Decided, Some(decision)) => {
                    let outcome = self.place(v1::PlaceRequest::from(&decision))?;
                    self.report(&decision.decision_id, outcome.clone())?;
                    let moves = last_poses.changed(report::poses(&self.state()?).or_run()?);
                    done.push(Done {
                        decision,
                        outcome,
                        moves,
                    });
                    on_step();
                }
                (PlanResult::NothingFits, _) => break reply.reasons,
                (PlanResult::NothingWaits, _) => break Vec::new(),
                (result, _) => {
                    return Err(anyhow::anyhow!("the planner answered {result:?}").into());
                }
            }
        };
        let session = self.ask("planner", v1::SessionRequest::default(), REQUEST_LIMIT)?;
        let state = self.state()?;
        let heightmap = self.heightmap(state.state_number)?;
        Ok(Packed {
            done,
            reasons,
            set_aside: session.session.unwrap_or_default().set_aside,
            state,
            heightmap,
        })
    }

    /// Begins a session with these items, of which so many may be set aside.
    pub fn begin(&self, session_id: &str, items: &[v1::Announcement], set_aside: u32) -> Outcome {
        let request = v1::BeginRequest {
            session_id: session_id.to_owned(),
            least_state_number: self.state()?.state_number,
            set_aside: Some(set_aside),
            // Of a packing that was cut off; nobody else controls the cell.
            gives_up_pending: true,
            ..v1::BeginRequest::default()
        };
        self.ask("planner", request, REQUEST_LIMIT)?;
        for items in items.chunks(1000) {
            let request = v1::AnnounceRequest {
                items: items.to_vec(),
                ..v1::AnnounceRequest::default()
            };
            self.ask("planner", request, REQUEST_LIMIT)?;
        }
        Ok(())
    }

    /// Has an item placed, and waits for the end of that.
    pub fn place(&self, request: v1::PlaceRequest) -> Outcome<v1::Outcome> {
        let end = v1::OutcomeRequest {
            placement_id: request.placement_id.clone(),
            ..v1::OutcomeRequest::default()
        };
        let reply = self.ask("bridge", request, REQUEST_LIMIT)?;
        if let Some(outcome) = ended(reply.execution) {
            return Ok(outcome);
        }
        let reply = self.ask("bridge", end, PLACE_LIMIT)?;
        let early = "the bridge answered before the placement had ended";
        ended(reply.execution).context(early).or_run()
    }

    /// Tells the planner how a decision was carried out.
    pub fn report(&self, decision_id: &str, outcome: v1::Outcome) -> Outcome {
        let request = v1::ReportRequest {
            decision_id: decision_id.to_owned(),
            outcome: Some(outcome),
            ..v1::ReportRequest::default()
        };
        self.ask("planner", request, REQUEST_LIMIT)?;
        Ok(())
    }

    /// Asks for the state of the cell.
    pub fn state(&self) -> Outcome<v1::CellState> {
        let reply = self.ask("bridge", v1::CellStateRequest::default(), REQUEST_LIMIT)?;
        reply.state.context("the bridge told no state").or_run()
    }

    /// Asks for the newest heightmap of a state of the cell, or a later one.
    pub fn heightmap(&self, least_state_number: u64) -> Outcome<v1::Heightmap> {
        let request = v1::HeightmapRequest {
            least_state_number,
            ..v1::HeightmapRequest::default()
        };
        let reply = self.ask("perception", request, REQUEST_LIMIT)?;
        let told = reply.heightmap.context("perception told no heightmap");
        told.or_run()
    }

    /// Asks a service of the cell.
    pub fn call<R: Request>(&self, request: R, limit: Duration) -> Result<R::Reply, CallError> {
        let deadline = Instant::now() + limit;
        self.client.call(&self.cell, request, deadline)
    }

    /// Asks a service of the cell that has to serve.
    pub fn ask<R: Request>(&self, service: &str, request: R, limit: Duration) -> Outcome<R::Reply> {
        self.call(request, limit)
            .with_context(|| format!("the {service} of cell {} does not serve", self.cell))
            .or_run()
    }
}

fn ended(execution: Option<v1::Execution>) -> Option<v1::Outcome> {
    let ended = execution.filter(|execution| execution.phase() == ExecutionPhase::Ended);
    ended?.outcome
}
