//! A container of a cell: how it is reached, seen and planned.

use std::time::{Duration, Instant};

use ppnpack_packing::content::Content;
use ppnpack_packing::expected::Expected;
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::hidden::SceneMemory;
use ppnpack_service::ServiceError;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::CallError;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1::{self, Status};

use super::bridge::Bridge;
use super::refusal::Refusal;
use super::{Own, Shared};
use crate::interruption::Interruption;
use crate::planning::Planning;
use crate::scenes::{SceneLimits, Scenes, Seen};
use crate::settings::ContainerPlan;

/// Maximum wait for the bridge to say that it is behind, when the time of a plan is over.
const MOMENT: Duration = Duration::from_millis(10);

/// Time until a perception that inspects nothing is asked again: it may be given a catalogue.
const UNINSPECTED: Duration = Duration::from_secs(60);

/// Remedy, for people, of a picture that contradicts what is believed.
const REMEDY: &str = "Say by `changed` which items were taken out, or none where all may stay";

/// Maximum wait for the bridge to void what was decided.
const VOID_LIMIT: Duration = Duration::from_millis(500);

/// A place for a container of a cell.
pub(super) struct Place {
    /// Its name in sessions; empty where it is the cell itself.
    pub(super) name: String,
    /// The name under which bridge and perception serve it.
    pub(super) address: Cell,
    pub(super) planning: Planning,
    pub(super) scenes: Scenes,
    pub(super) bridge: Bridge,
    /// Heights that were seen last, for what is hidden now.
    memory: SceneMemory,
    /// Heights that pictures should show by what is believed to lie here.
    expected: Expected,
    /// Whether the bridge ever told of something that lies here.
    pub(super) has_told_bodies: bool,
    interruption: Interruption,
    /// Why no picture comes that the session needs: its bridge is in an earlier state.
    pub(super) behind: Option<String>,
    /// Time before which a perception that inspects nothing here is not asked again.
    pub(super) uninspected_until: Option<Instant>,
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
        let (helpers, interruption) = (&shared.helpers, &own.interruption);
        let planning = Planning::new(&address, &settings, helpers, interruption);
        let planning = planning.map_err(ServiceError::start)?;
        let limits = SceneLimits {
            age: Duration::from_secs_f64(settings.heightmap_age_limit_s),
            sensor_latency: Duration::from_secs_f64(settings.sensor_latency_s),
        };
        let mut scenes =
            Scenes::subscribe(process, &address, planning.grid(), limits, interruption)?;
        // A picture that is on its way may not show what was done before this process began.
        scenes.changed();
        Ok(Self {
            name,
            planning,
            scenes,
            bridge: Bridge::subscribe(process, &address, &helpers.client, interruption)?,
            memory: SceneMemory::default(),
            expected: Expected::default(),
            has_told_bodies: false,
            interruption: interruption.clone(),
            behind: None,
            uninspected_until: None,
            shown_state: None,
            address,
        })
    }

    /// Waits for a heightmap that shows all up to this state, of one that the cell has come to.
    ///
    /// Where its sensor knows no states it is of the state that the bridge has now: for that it has
    /// to have come after this state was heard of first. A bridge that was heard of, or is needed,
    /// is waited for, too.
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
                self.bridge.state(needs_bridge, bridge_until)?
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

    /// Refuses what a heightmap shows of a state that the cell has not come to: nobody knows when
    /// it was made.
    fn must_have_come_to(
        &mut self,
        shown: u64,
        least: u64,
        deadline: Instant,
    ) -> Result<(), Refusal> {
        if shown <= least.max(self.bridge.told_state) {
            return Ok(());
        }
        match self.bridge.state(false, deadline)? {
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
        if let Some(state) = self.bridge.state_if_there(Instant::now() + MOMENT) {
            // It is noted.
            self.must_not_be_behind(state.state_number, least).ok();
        }
    }

    /// Refuses, and notes, that the bridge is in an earlier state than one that the cell was in: it
    /// lost what it knew.
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

    /// Notes that the content changed just now, to this state where it is known.
    pub(super) fn changed(&mut self, state_number: Option<u64>) {
        if state_number.is_none() {
            self.expected.forget();
        }
        self.shown_state = state_number;
        self.scenes.changed();
    }

    /// Says whether perception may inspect what is placed here, as far as is known.
    pub(super) fn may_be_inspected(&self) -> bool {
        let until = self.uninspected_until;
        until.is_none_or(|until| until <= Instant::now())
    }

    /// Notes that perception inspects nothing here; says whether that is news.
    pub(super) fn is_not_inspected(&mut self) -> bool {
        let until = Instant::now() + UNINSPECTED;
        self.uninspected_until.replace(until).is_none()
    }

    /// Has the bridge count the state up, so that all that was decided before is stale, however
    /// late its request comes. Gives the new state; `None` where there is no bridge, and a
    /// controller drives the robot itself.
    ///
    /// # Errors
    /// The status with which the bridge refuses: [`Status::Busy`] while the robot carries something
    /// out; [`Status::Unavailable`] where a bridge that was there, now or when `is_by_bridge` was
    /// decided, does not answer.
    pub(super) fn void_decisions(
        &mut self,
        is_by_bridge: bool,
        deadline: Instant,
    ) -> Result<Option<u64>, Refusal> {
        // Whoever has that done has looked.
        self.expected.forget();
        let until = deadline.min(Instant::now() + VOID_LIMIT);
        let request = v1::ChangedRequest::default();
        match self.bridge.call(request, until) {
            Ok(reply) => Ok(reply
                .state
                .map(|state| self.bridge.heard(state).state_number)),
            // One that is away for a moment may get such a request when it is back.
            Err(CallError::NoAnswer { .. }) if !is_by_bridge && !self.bridge.was_heard() => {
                Ok(None)
            }
            Err(error) => Err(Refusal::new(
                error.status().unwrap_or(Status::Unavailable),
                format_args!("what was decided before may still begin: {error}"),
            )),
        }
    }
}
