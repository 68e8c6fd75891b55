//! After a placement: perception says how the item lies, and the session is corrected by that.
//!
//! The cell's actor answers other requests meanwhile: a thread of its own waits for perception and
//! sends the answer to the actor. Plans wait for the inspection, as what is found moves the regions
//! of fragile items.

use std::time::{Duration, Instant};

use ppnpack_packing::heightmap::Scene;
use ppnpack_service::rpc::{CallError, Incoming};
use ppnpack_wire::convert;
use ppnpack_wire::v1::{self, InspectionKind, OutcomeKind, Status};

use super::{ANSWER_SLACK, CellPlanner, Message};
use ppnpack_protocol::message::read_pose;
use ppnpack_protocol::session::End;

/// Maximum wait of one attempt for a heightmap that shows the placement.
const SCENE_LIMIT: Duration = Duration::from_millis(300);

/// Maximum wait for it before the actor looks at its mailbox.
const SCENE_SLICE: Duration = Duration::from_millis(50);

/// Maximum time of perception's answer.
const ANSWER_LIMIT: Duration = Duration::from_secs(1);

/// Pause before another attempt.
const PAUSE: Duration = Duration::from_millis(100);

/// Maximum attempts before an item is left as it was reported.
const MAX_ATTEMPTS: u32 = 15;

/// Maximum wait of a plan for an inspection: as long as one attempt takes. Then it goes on without.
const PLAN_PATIENCE: Duration = SCENE_LIMIT.saturating_add(ANSWER_LIMIT);

/// An item that was decided on, until it is known how it lies.
#[derive(Debug)]
pub(crate) struct ToInspect {
    decision_id: String,
    item_id: String,
    /// The container that it was placed into.
    container: String,
    request: v1::InspectRequest,
    /// The state of the cell after the placement; before it has ended there is nothing to see.
    placed_in: Option<u64>,
    /// Perception's answer, where that is not on disk yet.
    found: Option<v1::Inspection>,
    attempts: u32,
    next: Next,
}

/// The next step of the inspection of an item.
#[derive(Debug, Clone, Copy)]
enum Next {
    /// An attempt begins then.
    Attempt(Instant),
    /// A heightmap that shows it is waited for until then.
    Heightmap(Instant),
    /// Perception answers; the attempt is over then, should the thread that asks it never say so.
    Answer(Instant),
}

impl ToInspect {
    pub(super) fn is_due(&self) -> bool {
        self.placed_in.is_some()
    }

    /// Gives when the actor has to go on with it; `None` until it is placed.
    pub(super) fn goes_on_at(&self) -> Option<Instant> {
        match self.next {
            Next::Attempt(at) => self.is_due().then_some(at),
            Next::Heightmap(_) => Some(Instant::now()),
            Next::Answer(until) => Some(until),
        }
    }
}

/// Why there is no inspection.
enum NotInspected {
    /// It may be had later.
    Yet(String),
    /// It cannot be had.
    AtAll(String),
    /// Perception inspects nothing.
    Anything(String),
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
        let before = convert::scene::write(place.planning.grid(), before);
        if let Some(left) = self.to_inspect.take().filter(ToInspect::is_due) {
            tracing::warn!(cell = %self.cell, item_id = left.item_id, "not inspected before the next decision");
        }
        self.to_inspect = Some(ToInspect {
            decision_id: decision.decision_id.clone(),
            item_id: decision.item_id.clone(),
            container: decision.container.clone(),
            request: v1::InspectRequest {
                header: None,
                object: decision.object.clone(),
                planned: decision.container_from_item,
                before: Some(before),
                least_state_number: 0,
            },
            placed_in: None,
            found: None,
            attempts: 0,
            next: Next::Attempt(Instant::now()),
        });
    }

    /// Notes how a decision ended. An item that was found is looked for only where that is asked for.
    pub(super) fn has_ended(&mut self, decision_id: &str, outcome: &v1::Outcome) {
        let told = read_pose(outcome.container_from_item.as_ref(), outcome.is_found);
        let is_found = told.is_some_and(|told| told.is_found());
        let is_due = outcome.kind() == OutcomeKind::Placed
            && (!is_found || self.settings.inspect == Some(true));
        // After a restart there is none: what the container held before is not kept.
        self.to_inspect = self
            .to_inspect
            .take()
            .filter(|to_inspect| is_due && to_inspect.decision_id == decision_id);
        if let Some(to_inspect) = &mut self.to_inspect {
            to_inspect.placed_in = Some(outcome.state_number);
        }
    }

    /// Says whether an item was placed last into this container and is not inspected yet.
    pub(super) fn is_inspecting_in(&self, container: &str) -> bool {
        let it = self.to_inspect.as_ref().filter(|it| it.is_due());
        it.is_some_and(|it| it.container == container)
    }

    /// Says whether the item that was placed last is not inspected yet.
    pub(super) fn is_inspecting(&self) -> bool {
        self.to_inspect.as_ref().is_some_and(ToInspect::is_due)
    }

    /// Goes on with the inspection of the item that was placed last. Waits for a heightmap for a
    /// moment, and for nothing else.
    pub(super) fn inspect(&mut self) {
        let goes_on = |it: &mut ToInspect| it.goes_on_at().is_some_and(|at| at <= Instant::now());
        let Some(mut it) = self.to_inspect.take_if(goes_on) else {
            return;
        };
        let went = match it.found.clone() {
            Some(found) => self.enter_found(&it, found),
            None => match self.ask_inspection(&mut it) {
                Ok(()) => {
                    self.to_inspect = Some(it);
                    return;
                }
                Err(reason) => Err(reason),
            },
        };
        self.end_attempt(it, went);
    }

    pub(super) fn on_inspected(
        &mut self,
        decision_id: &str,
        answer: Result<v1::InspectReply, CallError>,
    ) {
        // Of a session or a decision that is gone it is of no use.
        let is_asked = |it: &mut ToInspect| {
            matches!(it.next, Next::Answer(_)) && it.decision_id == decision_id
        };
        let Some(mut it) = self.to_inspect.take_if(is_asked) else {
            return;
        };
        let is_asked_for = self.settings.inspect.is_some();
        let went = read_answer(it.placed_in, is_asked_for, answer).and_then(|found| {
            if let Ok(place) = self.place_of(&it.container) {
                place.uninspected_until = None;
            }
            it.found = Some(found.clone());
            self.enter_found(&it, found)
        });
        self.end_attempt(it, went);
    }

    /// Has a plan wait for the inspection, for as long as its time limit allows.
    pub(super) fn keep_plan(&mut self, incoming: Incoming<v1::PlanRequest>) {
        let until = incoming.answer_by().min(Instant::now() + PLAN_PATIENCE);
        if let Err(incoming) = self.plans.keep(incoming, until) {
            incoming.refuse(Status::Busy, "too many wait already");
        }
    }

    /// Answers the plans that have not to wait for the inspection any more.
    pub(super) fn answer_plans(&mut self) {
        let plans = match self.is_inspecting() {
            true => self.plans.take_expired(),
            false => self.plans.take(|_| true),
        };
        for incoming in plans {
            if Instant::now() >= incoming.answer_by() {
                let late = "the time limit passed while the item placed before was inspected";
                incoming.refuse(Status::TimedOut, late);
            } else {
                self.carry_out(incoming, Self::plan_step);
            }
        }
    }

    /// Waits for a heightmap that surely shows the placement, as perception has its cloud then, and
    /// asks perception.
    fn ask_inspection(&mut self, it: &mut ToInspect) -> Result<(), NotInspected> {
        let now = Instant::now();
        let until = match it.next {
            Next::Attempt(_) => now + SCENE_LIMIT,
            Next::Heightmap(until) => until,
            Next::Answer(_) => return Err(NotInspected::Yet("no answer came".to_owned())),
        };
        it.next = Next::Heightmap(until);
        let least = self.session.least_state_number(&it.container);
        let place = self.place_of(&it.container);
        let place = place.map_err(|error| NotInspected::AtAll(error.to_string()))?;
        let slice = until.min(now + SCENE_SLICE);
        match place.scenes.current(least, slice) {
            Ok(seen) => it.request.least_state_number = seen.state_number,
            Err(_) if Instant::now() < until => return Ok(()),
            Err(reason) => return Err(NotInspected::Yet(reason)),
        }
        let address = place.address.clone();
        let (decision_id, request) = (it.decision_id.clone(), it.request.clone());
        let tell = |answer| Message::Inspected(decision_id, Box::new(answer));
        self.ask_aside("inspection", address, request, ANSWER_LIMIT, tell)
            .map_err(|error| NotInspected::Yet(error.to_string()))?;
        it.next = Next::Answer(Instant::now() + ANSWER_LIMIT + ANSWER_SLACK);
        Ok(())
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
                it.next = Next::Attempt(Instant::now() + PAUSE);
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
        let place = self.place_of(&it.container);
        if place.is_ok_and(|place| place.is_not_inspected()) {
            let container = &it.container;
            tracing::info!(cell = %self.cell, container, reason, "placed items are not inspected");
        }
    }
}

/// Reads perception's answer about an item that was placed in this state of the cell. Where the
/// settings do not ask for inspections, a perception that inspects nothing is as good.
fn read_answer(
    placed_in: Option<u64>,
    is_asked_for: bool,
    answer: Result<v1::InspectReply, CallError>,
) -> Result<v1::Inspection, NotInspected> {
    let reply = match answer {
        Ok(reply) => reply,
        Err(error) if !is_asked_for && inspects_nothing(&error) => {
            return Err(NotInspected::Anything(error.to_string()));
        }
        // What perception does not know, it cannot find.
        Err(error) if matches!(error.status(), Some(Status::NotFound | Status::Invalid)) => {
            return Ok(v1::Inspection {
                kind: InspectionKind::Unclear.into(),
                reason: error.to_string(),
                ..v1::Inspection::default()
            });
        }
        Err(error) => return Err(NotInspected::Yet(format!("perception: {error}"))),
    };
    // Another state is another content, such as a new container.
    let placed_in = placed_in.unwrap_or_default();
    if reply.state_number != 0 && placed_in != 0 && reply.state_number != placed_in {
        let changed = "the container changed before it was inspected";
        return Err(NotInspected::AtAll(changed.to_owned()));
    }
    let nothing = || NotInspected::Yet("perception told nothing".to_owned());
    reply.inspection.ok_or_else(nothing)
}

fn inspects_nothing(error: &CallError) -> bool {
    matches!(error, CallError::NoAnswer { .. }) || error.status() == Some(Status::NotFound)
}
