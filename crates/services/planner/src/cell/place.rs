//! A container of a cell: how it is reached, seen and planned.

use std::time::{Duration, Instant};

use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::hidden::SceneMemory;
use ppnpack_service::ServiceError;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Status};

use super::bridge_clock::BridgeClock;
use super::refusal::Refusal;
use super::{Own, Shared};
use crate::planning::Planning;
use crate::scenes::{SceneLimits, Scenes, Seen};
use crate::settings::ContainerPlan;

/// How long the bridge may take to say in which state the container is.
const PATIENCE: Duration = Duration::from_millis(100);

/// A bridge that did not say is left alone for so long.
const LEFT_ALONE: Duration = Duration::from_secs(30);

/// How long a perception that inspects nothing is not asked again. It may be given a catalogue.
const UNINSPECTED: Duration = Duration::from_secs(60);

/// How long the bridge may take to void what was decided.
const VOID_LIMIT: Duration = Duration::from_millis(500);

/// Where a container of a cell stands.
pub(super) struct Place {
    /// As the session has it; empty where it is the cell itself.
    pub(super) name: String,
    /// Under which bridge and perception serve it.
    pub(super) address: Cell,
    pub(super) planning: Planning,
    pub(super) scenes: Scenes,
    pub(super) bridge_clock: BridgeClock,
    /// What was seen last, for what is hidden now.
    memory: SceneMemory,
    client: Client,
    /// The bridge did not say in which state the container is, and is not asked again before.
    left_alone_until: Option<Instant>,
    /// Perception inspects nothing here, and is not asked again before.
    uninspected_until: Option<Instant>,
    /// The state since the scenes were last told of a change, where that is known.
    shown_state: Option<u64>,
}

impl Place {
    pub(super) fn new(
        process: &Process,
        plan: ContainerPlan,
        shared: &Shared,
        own: &Own,
    ) -> Result<Self, ServiceError> {
        let ContainerPlan {
            name,
            address,
            settings,
        } = plan;
        let interruption = &own.interruption;
        let planning = Planning::new(&address, &settings, &shared.helpers, interruption);
        let planning = planning.map_err(ServiceError::start)?;
        let limits = SceneLimits {
            age: Duration::from_secs_f64(settings.heightmap_age_limit_s),
            sensor_latency: Duration::from_secs_f64(settings.sensor_latency_s),
        };
        let mut scenes =
            Scenes::subscribe(process, &address, planning.grid(), limits, interruption)?;
        // What was done last, before this process was there, may not be in a picture that was on its way.
        scenes.changed();
        Ok(Self {
            name,
            planning,
            scenes,
            bridge_clock: BridgeClock::subscribe(process, &address)?,
            memory: SceneMemory::default(),
            client: shared.helpers.client.clone(),
            left_alone_until: None,
            uninspected_until: None,
            shown_state: None,
            address,
        })
    }

    /// A heightmap that shows what was done up to this state; waits for it until the deadline.
    ///
    /// Where its sensor knows no states it is of the state that the bridge has now: for that it has to have come after this state was
    /// heard of for the first time.
    pub(super) fn seen(&mut self, least: u64, deadline: Instant) -> Result<Seen, Refusal> {
        loop {
            let seen = self.scenes.current(least, deadline);
            let mut seen = seen.map_err(Refusal::unavailable)?;
            if seen.state_number != 0 {
                return Ok(seen);
            }
            let Some(v1::CellState { state_number, .. }) = self.bridge_state(deadline) else {
                return Ok(seen);
            };
            if self.shown_state == Some(state_number) {
                seen.state_number = state_number;
                return Ok(seen);
            }
            self.changed(Some(state_number));
        }
    }

    /// Gives what is hidden in a scene of this container the heights of what is known to lie there.
    pub(super) fn complete(&mut self, scene: Scene) -> Scene {
        self.memory.complete(self.planning.grid(), scene)
    }

    /// The content changed just now, to this state where it is known.
    pub(super) fn changed(&mut self, state_number: Option<u64>) {
        self.shown_state = state_number;
        self.scenes.changed();
    }

    /// Whether perception may inspect what is placed here, as far as is known.
    pub(super) fn may_be_inspected(&self) -> bool {
        let until = self.uninspected_until;
        until.is_none_or(|until| until <= Instant::now())
    }

    /// Perception inspects here.
    pub(super) fn is_inspected(&mut self) {
        self.uninspected_until = None;
    }

    /// Perception inspects nothing here. Says whether that is news.
    pub(super) fn is_not_inspected(&mut self) -> bool {
        let until = Instant::now() + UNINSPECTED;
        self.uninspected_until.replace(until).is_none()
    }

    /// The state as the bridge has it now, where there is one.
    pub(super) fn bridge_state(&mut self, deadline: Instant) -> Option<v1::CellState> {
        let now = Instant::now();
        if self.left_alone_until.is_some_and(|until| now < until) {
            return None;
        }
        let state = self.ask_state(deadline);
        if state.is_none() {
            self.left_alone_until = Some(now + LEFT_ALONE);
        }
        state
    }

    /// As [`Self::bridge_state`], of a bridge that has to be there: it is asked also where it did
    /// not answer last.
    pub(super) fn ask_state(&mut self, deadline: Instant) -> Option<v1::CellState> {
        let until = deadline.min(Instant::now() + PATIENCE);
        let request = v1::CellStateRequest::default();
        let reply = self.client.call(&self.address, request, until);
        let state = reply.ok()?.state?;
        self.bridge_clock.heard(&state);
        Some(state)
    }

    /// What the bridge's clock shows now; 0 where no bridge is heard of, not even when it is asked.
    pub(super) fn bridge_now_ns(&mut self, deadline: Instant) -> u64 {
        if !self.bridge_clock.was_heard() {
            self.bridge_state(deadline);
        }
        self.bridge_clock.now_ns()
    }

    /// Has the bridge count the state up, so that all that was decided before is stale, however late its request comes. Gives the new
    /// state; `None` where there is no bridge, and a controller drives the robot itself.
    ///
    /// # Errors
    /// As what the bridge refuses it: [`Status::Busy`] while the robot carries something out; [`Status::Unavailable`] where a
    /// bridge that was there, now or when `is_by_bridge` was decided, does not answer.
    pub(super) fn void_decisions(
        &mut self,
        is_by_bridge: bool,
        deadline: Instant,
    ) -> Result<Option<u64>, Refusal> {
        let until = deadline.min(Instant::now() + VOID_LIMIT);
        let request = v1::ChangedRequest::default();
        match self.client.call(&self.address, request, until) {
            Ok(reply) => Ok(reply.state.map(|state| state.state_number)),
            // One that is away for a moment may have such a request before it, or get it when it is back.
            Err(CallError::NoAnswer { .. }) if !is_by_bridge && !self.bridge_clock.was_heard() => {
                Ok(None)
            }
            Err(error) => Err(Refusal::new(
                error.status().unwrap_or(Status::Unavailable),
                format_args!("what was decided before may still begin: {error}"),
            )),
        }
    }
}
