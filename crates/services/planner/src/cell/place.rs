//! A container of a cell: how it is reached, seen and planned.

use std::time::{Duration, Instant};

use ppnpack_packing::content::Content;
use ppnpack_packing::expected::Expected;
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
use crate::interruption::{INTERRUPTED, Interruption};
use crate::planning::Planning;
use crate::scenes::{SceneLimits, Scenes, Seen};
use crate::settings::ContainerPlan;

/// How long the bridge may take to say in which state the container is, where a plan can do without.
const PATIENCE: Duration = Duration::from_millis(100);

/// A bridge that did not say is left alone for so long, where a plan can do without.
const LEFT_ALONE: Duration = Duration::from_secs(30);

/// How long one request for its state waits where a plan needs it: an interruption is heeded between two.
const INSISTENCE: Duration = Duration::from_secs(1);

/// How long to wait before a bridge is asked for its state again that refused to say.
const PAUSE: Duration = Duration::from_millis(50);

/// How long the bridge may take to say that it is behind the session, when the time of a plan is over.
const MOMENT: Duration = Duration::from_millis(10);

/// How long a perception that inspects nothing is not asked again. It may be given a catalogue.
const UNINSPECTED: Duration = Duration::from_secs(60);

/// What people do about a picture that contradicts what is believed.
const REMEDY: &str = "Say by `changed` which items were taken out, or none where all may stay";

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
    /// What pictures should show by what is believed to lie here.
    expected: Expected,
    /// Whether the bridge ever told of something that lies here.
    pub(super) has_told_bodies: bool,
    client: Client,
    interruption: Interruption,
    /// The bridge did not say in which state the container is, and is not asked again before.
    left_alone_until: Option<Instant>,
    /// The state that the bridge said last; 0 where it said none.
    told_state: u64,
    /// Why no picture comes that the session needs: its bridge is in an earlier state.
    behind: Option<String>,
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
            expected: Expected::default(),
            has_told_bodies: false,
            client: shared.helpers.client.clone(),
            interruption: interruption.clone(),
            left_alone_until: None,
            told_state: 0,
            behind: None,
            uninspected_until: None,
            shown_state: None,
            address,
        })
    }

    /// A heightmap that shows what was done up to this state, which is waited for until then, and that the cell has come to.
    ///
    /// Where its sensor knows no states it is of the state that the bridge has now: for that it has to have come after this state was
    /// heard of for the first time. A bridge that was heard of, or is needed, is waited for, too.
    pub(super) fn seen(
        &mut self,
        least: u64,
        needs_bridge: bool,
        until: Instant,
        bridge_until: Instant,
    ) -> Result<Seen, Refusal> {
        loop {
            let mut seen = match self.scenes.current(least, until) {
                Ok(seen) => seen,
                Err(why) => {
                    self.look_whether_behind(least);
                    return Err(Refusal::unavailable(why));
                }
            };
            if seen.state_number != 0 {
                self.must_have_come_to(seen.state_number, least, bridge_until)?;
                return Ok(seen);
            }
            let Some(v1::CellState { state_number, .. }) =
                self.state(needs_bridge, bridge_until)?
            else {
                return Ok(seen);
            };
            self.must_not_be_behind(state_number, least)?;
            if self.shown_state == Some(state_number) {
                seen.state_number = state_number;
                return Ok(seen);
            }
            self.changed(Some(state_number));
        }
    }

    /// Refuses what a heightmap shows of a state that the cell has not come to: nobody knows when it was made.
    fn must_have_come_to(
        &mut self,
        shown: u64,
        least: u64,
        deadline: Instant,
    ) -> Result<(), Refusal> {
        if shown <= least.max(self.told_state) {
            return Ok(());
        }
        match self.state(false, deadline)? {
            // Older bridges do not say.
            Some(v1::CellState { state_number, .. }) if (1..shown).contains(&state_number) => {
                Err(Refusal::unavailable(format_args!(
                    "the newest heightmap shows state {shown} of cell {}, which has come to {state_number}",
                    self.address
                )))
            }
            _ => Ok(()),
        }
    }

    /// Notes where the bridge is in an earlier state than one that the cell was in.
    fn look_whether_behind(&mut self, least: u64) {
        if least == 0 || self.interruption.is_asked_for() {
            return;
        }
        let until = Instant::now() + MOMENT;
        let state = match self.bridge_clock.was_heard() {
            true => self.ask_state(until),
            false => self.bridge_state(until),
        };
        if let Some(state) = state {
            // It is noted.
            self.must_not_be_behind(state.state_number, least).ok();
        }
    }

    /// Refuses, and notes, that the bridge is in an earlier state than one that the cell was in: it lost what it knew.
    fn must_not_be_behind(&mut self, told: u64, least: u64) -> Result<(), Refusal> {
        if !(1..least).contains(&told) {
            return Ok(());
        }
        let why = format!(
            "the bridge of cell {} is in state {told}, and the session knows of state {least}: its journal is lost or an older one, or \
             its clock was set back; look what lies in the container, then switch the automatic mode on, or begin a new session",
            self.address
        );
        self.behind = Some(why.clone());
        Err(Refusal::unavailable(why))
    }

    /// Whether the bridge was found to be behind the session.
    pub(super) fn is_behind(&self) -> bool {
        self.behind.is_some()
    }

    /// Why the bridge counts as behind the session, where it does; forgets it.
    pub(super) fn take_behind(&mut self) -> Option<String> {
        self.behind.take()
    }

    /// Gives what is hidden in a scene of this container the heights of what is known to lie there.
    pub(super) fn complete(&mut self, scene: Scene) -> Scene {
        self.memory.complete(self.planning.grid(), scene)
    }

    /// Has a picture count as doubtful where it contradicts what is believed to lie here; says
    /// whether it does. `least` is the state after what the session did last: at a later one
    /// somebody had a hand in the container.
    pub(super) fn contradicts(&mut self, least: u64, seen: &Seen, content: &Content) -> bool {
        if seen.state_number > least {
            self.expected.forget();
        }
        let grid = self.planning.grid();
        let contradiction = self.expected.contradiction(grid, &seen.scene, content);
        if let Some(contradiction) = &contradiction {
            self.scenes.deny(seen, format!("{contradiction} {REMEDY}"));
        }
        contradiction.is_some()
    }

    /// The content changed just now, to this state where it is known.
    pub(super) fn changed(&mut self, state_number: Option<u64>) {
        if state_number.is_none() {
            self.expected.forget();
        }
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

    /// The state as the bridge has it now. One that was heard of, or is needed, is waited for until the deadline; `None` where there is
    /// none, and a controller drives the robot itself.
    ///
    /// # Errors
    /// [`Status::Unavailable`] where it does not say.
    pub(super) fn state(
        &mut self,
        is_needed: bool,
        deadline: Instant,
    ) -> Result<Option<v1::CellState>, Refusal> {
        if !is_needed && !self.bridge_clock.was_heard() {
            return Ok(self.bridge_state(deadline));
        }
        loop {
            let now = Instant::now();
            if let Some(state) = self.ask_state(deadline.min(now + INSISTENCE)) {
                return Ok(Some(state));
            }
            if self.interruption.is_asked_for() {
                return Err(Refusal::unavailable(INTERRUPTED));
            }
            if Instant::now() + PATIENCE >= deadline {
                return Err(Refusal::unavailable(format_args!(
                    "the bridge of cell {} does not say in which state it is",
                    self.address
                )));
            }
            std::thread::sleep(PAUSE);
        }
    }

    /// The state as the bridge has it now, where it says so soon.
    pub(super) fn bridge_state(&mut self, deadline: Instant) -> Option<v1::CellState> {
        let now = Instant::now();
        if self.left_alone_until.is_some_and(|until| now < until) {
            return None;
        }
        let state = self.ask_state(deadline.min(now + PATIENCE));
        if state.is_none() {
            self.left_alone_until = Some(now + LEFT_ALONE);
        }
        state
    }

    /// As [`Self::bridge_state`], of a bridge that has to be there: it is asked also where it did
    /// not answer last.
    pub(super) fn ask_state(&mut self, until: Instant) -> Option<v1::CellState> {
        let request = v1::CellStateRequest::default();
        let reply = self.client.call(&self.address, request, until);
        let state = reply.ok().and_then(|reply| reply.state);
        state.map(|state| self.heard(state))
    }

    fn heard(&mut self, state: v1::CellState) -> v1::CellState {
        self.bridge_clock.heard(&state);
        self.told_state = state.state_number;
        self.left_alone_until = None;
        state
    }

    /// What the bridge's clock shows now; 0 where no bridge is heard of, not even when it is asked.
    pub(super) fn bridge_now_ns(&mut self, deadline: Instant) -> u64 {
        if !self.bridge_clock.was_heard() {
            self.bridge_state(deadline);
        }
        self.bridge_clock.now_ns()
    }

    /// What the bridge says that lies in the container, where there is a bridge that says so soon.
    pub(super) fn bodies(&mut self, deadline: Instant) -> Vec<v1::Body> {
        let state = match self.bridge_clock.was_heard() {
            true => self.ask_state(deadline.min(Instant::now() + INSISTENCE)),
            false => self.bridge_state(deadline),
        };
        state.map(|state| state.bodies).unwrap_or_default()
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
        // Whoever has that done has looked.
        self.expected.forget();
        let until = deadline.min(Instant::now() + VOID_LIMIT);
        let request = v1::ChangedRequest::default();
        match self.client.call(&self.address, request, until) {
            Ok(reply) => Ok(reply.state.map(|state| self.heard(state).state_number)),
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
