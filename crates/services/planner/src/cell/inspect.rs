//! After a placement: perception says how the item lies, and the session is corrected by that.
//!
//! Plans wait for the inspection, as what is found moves the regions of fragile items.

use std::time::{Duration, Instant};

use ppnpack_packing::scene::Scene;
use ppnpack_protocol::message::read_pose;
use ppnpack_protocol::session::End;
use ppnpack_wire::convert;
use ppnpack_wire::v1::{self, InspectionKind, OutcomeKind};

use super::CellPlanner;
use crate::step::{Inspect, NotInspected, Work};

/// Pause before another attempt.
const PAUSE: Duration = Duration::from_millis(100);

/// Maximum attempts before an item is left as it was reported.
const MAX_ATTEMPTS: u32 = 15;

/// An item that was decided on, until it is known how it lies.
#[derive(Debug)]
pub(crate) struct ToInspect {
    item_id: String,
    inspect: Inspect,
    /// Whether it is placed; before, there is nothing to see.
    is_due: bool,
    /// Perception's answer, where that is not on disk yet.
    found: Option<v1::Inspection>,
    attempts: u32,
    /// The time of the next attempt.
    next: Instant,
}

impl CellPlanner {
    /// Notes what was decided, and what the container held before.
    pub(super) fn will_inspect(&mut self, decision: &v1::Decision, before: &Scene) {
        let inspect = self.settings.inspect;
        let Ok(place) = self.place_of(&decision.container) else {
            return;
        };
        if !inspect.unwrap_or_else(|| place.may_be_inspected()) {
            return;
        }
        let before = convert::scene::write(&place.grid, before);
        if let Some(left) = self.to_inspect.take().filter(|it| it.is_due) {
            tracing::warn!(cell = %self.cell, item_id = left.item_id, "not inspected before the next decision");
        }
        self.to_inspect = Some(ToInspect {
            item_id: decision.item_id.clone(),
            inspect: Inspect {
                decision_id: decision.decision_id.clone(),
                container: decision.container.clone(),
                request: v1::InspectRequest {
                    object: decision.object.clone(),
                    planned: decision.container_from_item,
                    before: Some(before),
                    ..v1::InspectRequest::default()
                },
                placed_in: 0,
            },
            is_due: false,
            found: None,
            attempts: 0,
            next: Instant::now(),
        });
    }

    /// Notes how a decision ended. An item that was found is looked for only where that is asked for.
    pub(super) fn has_ended(&mut self, decision_id: &str, outcome: &v1::Outcome) {
        let told = read_pose(outcome.container_from_item.as_ref(), outcome.is_found);
        let is_found = told.is_some_and(|told| told.is_found());
        let is_due = outcome.kind() == OutcomeKind::Placed
            && (!is_found || self.settings.inspect == Some(true));
        // After a restart there is none: what the container held before is not kept.
        let to_inspect = self.to_inspect.take();
        let ended = to_inspect.filter(|it| is_due && it.inspect.decision_id == decision_id);
        self.to_inspect = ended.map(|mut it| {
            it.is_due = true;
            it.inspect.placed_in = outcome.state_number;
            it
        });
    }

    /// Gives the item that was placed last, as long as it is not inspected.
    fn due_inspection(&self) -> Option<&ToInspect> {
        self.to_inspect.as_ref().filter(|it| it.is_due)
    }

    /// Says whether an item was placed last into this container and is not inspected yet.
    pub(super) fn is_inspecting_in(&self, container: &str) -> bool {
        let it = self.due_inspection();
        it.is_some_and(|it| it.inspect.container == container)
    }

    /// Says whether the item that was placed last is not inspected yet.
    pub(super) fn is_inspecting(&self) -> bool {
        self.due_inspection().is_some()
    }

    /// Says whether plans wait for an inspection: for its first attempt alone.
    pub(super) fn is_first_inspecting(&self) -> bool {
        self.due_inspection().is_some_and(|it| it.attempts == 0)
    }

    /// Gives the time of the next attempt to inspect an item.
    pub(super) fn next_inspection(&self) -> Option<Instant> {
        self.due_inspection().map(|it| it.next)
    }

    /// Goes on with the inspection of the item that was placed last, where no step is under way.
    pub(super) fn go_on_inspecting(&mut self) {
        let is_free = self.step_under_way.is_none();
        let is_due = |it: &mut ToInspect| is_free && it.is_due && it.next <= Instant::now();
        let Some(it) = self.to_inspect.take_if(is_due) else {
            return;
        };
        if let Some(found) = it.found.clone() {
            let went = self.enter_found(&it, found);
            return self.end_attempt(it, went);
        }
        let inspect = it.inspect.clone();
        self.to_inspect = Some(it);
        self.begin_step(Work::Inspect(inspect));
    }

    pub(super) fn on_inspected(
        &mut self,
        decision_id: &str,
        inspected: Result<v1::Inspection, NotInspected>,
    ) {
        // Of a session or a decision that is gone it is of no use.
        let is_asked = |it: &mut ToInspect| it.inspect.decision_id == decision_id;
        let Some(mut it) = self.to_inspect.take_if(is_asked) else {
            return;
        };
        let went = inspected.and_then(|found| {
            if let Ok(place) = self.place_of(&it.inspect.container) {
                place.uninspected_until = None;
            }
            it.found = Some(found.clone());
            self.enter_found(&it, found)
        });
        self.end_attempt(it, went);
    }

    fn enter_found(&mut self, it: &ToInspect, found: v1::Inspection) -> Result<(), NotInspected> {
        let (item_id, kind) = (it.item_id.as_str(), found.kind());
        let named = kind.as_str_name();
        tracing::info!(
            cell = %self.cell, item_id, inspection = named, slide_m = found.slide_m,
            tilt_rad = found.tilt_rad, reason = found.reason, "inspected"
        );
        let entered = self.session.change(|session| {
            let failure = format!("item {item_id} was placed, but {}", found.reason);
            let was_packed = session.inspected(item_id, found)?;
            if was_packed && kind == InspectionKind::Missing && session.is_automatic() {
                // It lies somewhere in the cell, maybe in the arm's way.
                session.end(End::Failed(failure));
            }
            Ok(())
        });
        entered.map_err(|refusal| NotInspected::Yet(refusal.message))
    }

    /// Plans another attempt where this one led to nothing and there may be more.
    fn end_attempt(&mut self, mut it: ToInspect, went: Result<(), NotInspected>) {
        it.attempts += 1;
        let reason = match went {
            Ok(()) => return,
            Err(NotInspected::Yet(reason)) if it.attempts < MAX_ATTEMPTS => {
                tracing::debug!(cell = %self.cell, item_id = it.item_id, reason, "not inspected yet");
                it.next = Instant::now() + PAUSE;
                self.to_inspect = Some(it);
                return;
            }
            Err(NotInspected::Anything(reason)) => return self.inspects_nothing(&it, &reason),
            Err(NotInspected::Yet(reason) | NotInspected::AtAll(reason)) => reason,
        };
        tracing::warn!(cell = %self.cell, item_id = it.item_id, reason, "not inspected");
    }

    /// Leaves the items of a container as they are reported, and says so once.
    fn inspects_nothing(&mut self, it: &ToInspect, reason: &str) {
        let place = self.place_of(&it.inspect.container);
        if place.is_ok_and(|place| place.is_not_inspected()) {
            let container = &it.inspect.container;
            tracing::info!(cell = %self.cell, container, reason, "placed items are not inspected");
        }
    }
}
