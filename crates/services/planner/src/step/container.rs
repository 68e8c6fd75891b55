//! A container as steps are planned on it: its pictures, what should lie there, its planning.

use std::time::{Duration, Instant};

use ppnpack_packing::scene::Scene;
use ppnpack_packing::scene::content::Content;
use ppnpack_packing::scene::expected::Expected;
use ppnpack_packing::scene::hidden::SceneMemory;
use ppnpack_service::ServiceError;
use ppnpack_service::clock::Boottime;
use ppnpack_service::process::Process;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::bridge::Bridge;
use crate::cell::Shared;
use crate::planning::Planning;
use crate::refusal::Refusal;
use crate::scenes::{SceneLimits, Scenes, Seen};
use crate::settings::ContainerPlan;

/// Maximum wait for the bridge to say that it is behind, when the time of a plan is over.
const MOMENT: Duration = Duration::from_millis(10);

/// Remedy, for people, of a picture that contradicts what is believed.
const REMEDY: &str = "Say by `changed` which items were taken out, or none where all may stay";

/// Changes of a container since the last step.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Change {
    /// Time of the last change of its content.
    pub(crate) at: Option<Boottime>,
    /// The state since then, where that is known.
    pub(crate) state_number: Option<u64>,
    /// Whether somebody may have had a hand in it.
    pub(crate) is_by_hand: bool,
}

/// A container of a cell.
pub(super) struct Container {
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
    /// Why no picture comes that the session needs: its bridge is in an earlier state.
    pub(super) behind: Option<String>,
    /// The state since the scenes were last told of a change, where that is known.
    shown_state: Option<u64>,
}

impl Container {
    pub(super) fn new(
        process: &Process,
        plan: ContainerPlan,
        shared: &Shared,
    ) -> Result<Self, ServiceError> {
        let ContainerPlan {
            name,
            address,
            settings,
        } = plan;
        let planning = Planning::new(&address, &settings, &shared.helpers);
        let planning = planning.map_err(ServiceError::start)?;
        let limits = SceneLimits {
            age: Duration::from_secs_f64(settings.heightmap_age_limit_s),
            sensor_latency: Duration::from_secs_f64(settings.sensor_latency_s),
        };
        let mut scenes = Scenes::subscribe(process, &address, planning.grid(), limits)?;
        // A picture that is on its way may not show what was done before this process began.
        scenes.changed(Boottime::now());
        Ok(Self {
            name,
            planning,
            scenes,
            bridge: Bridge::subscribe(process, &address, &shared.helpers.client)?,
            memory: SceneMemory::default(),
            expected: Expected::default(),
            has_told_bodies: false,
            behind: None,
            shown_state: None,
            address,
        })
    }

    /// Takes over what happened since the last step.
    pub(super) fn take_over(&mut self, change: Change) {
        if change.is_by_hand {
            self.expected.forget();
        }
        if let Some(at) = change.at {
            self.shown_state = change.state_number;
            self.scenes.changed(at);
        }
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
            self.shown_state = Some(state_number);
            self.scenes.changed(Boottime::now());
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
        if least == 0 {
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

    /// Holds a picture against what is believed to lie here. Gives the content, with something
    /// unknown in it where the picture shows more; `None` where the picture contradicts it, which
    /// then counts as doubtful. `least` is the state after what the session did last: at a later
    /// one somebody had a hand in the container.
    pub(super) fn compared(
        &mut self,
        least: u64,
        seen: &Seen,
        content: Content,
    ) -> Option<Content> {
        if seen.state_number > least {
            self.expected.forget();
        }
        let grid = self.planning.grid();
        let compared = self.expected.compare(grid, &seen.scene, content);
        let doubt = |contradiction| {
            let reason = format!("{contradiction} {REMEDY}");
            self.scenes.deny(seen, reason);
        };
        compared.map_err(doubt).ok()
    }
}
