//! After a placement: perception says how the item lies, and the session is corrected by that.

use std::time::{Duration, Instant};

use ppnpack_packing::heightmap::Scene;
use ppnpack_wire::convert;
use ppnpack_wire::v1::{self, InspectionKind, OutcomeKind, Status};

use super::{CellPlanner, Refusal};
use crate::session::End;

/// How long one attempt waits for a heightmap that shows the placement.
const SCENE_LIMIT: Duration = Duration::from_millis(300);

/// How long perception may take.
const ANSWER_LIMIT: Duration = Duration::from_secs(1);

/// Attempts before an item is left as it was reported.
const MAX_ATTEMPTS: u32 = 15;

/// An item that was decided on, until it is known how it lies.
#[derive(Debug)]
pub(crate) struct ToInspect {
    decision_id: String,
    item_id: String,
    request: v1::InspectRequest,
    /// The state of the cell after the placement; before it has ended there is nothing to see.
    placed_in: Option<u64>,
    /// What perception said, where that is not on disk yet.
    found: Option<v1::Inspection>,
    attempts: u32,
}

impl ToInspect {
    /// Whether the item was placed.
    pub(super) fn is_due(&self) -> bool {
        self.placed_in.is_some()
    }
}

/// Why there is no inspection.
enum NotInspected {
    /// It may be had later.
    Yet(String),
    /// It cannot be had.
    AtAll(String),
}

impl CellPlanner {
    /// Notes what was decided, and what the container held before.
    pub(super) fn will_inspect(&mut self, decision: &v1::Decision, before: &Scene) {
        if !self.settings.inspect {
            return;
        }
        if let Some(left) = self.to_inspect.take().filter(ToInspect::is_due) {
            tracing::warn!(cell = %self.cell, item_id = left.item_id, "not inspected before the next decision");
        }
        self.to_inspect = Some(ToInspect {
            decision_id: decision.decision_id.clone(),
            item_id: decision.item_id.clone(),
            request: v1::InspectRequest {
                header: None,
                object: decision.object.clone(),
                planned: decision.container_from_item,
                before: Some(convert::scene::write(self.planning.grid(), before)),
                least_state_number: 0,
            },
            placed_in: None,
            found: None,
            attempts: 0,
        });
    }

    /// Notes how a decision ended.
    pub(super) fn has_ended(&mut self, decision_id: &str, outcome: &v1::Outcome) {
        let is_placed = outcome.kind() == OutcomeKind::Placed;
        // After a restart there is none: what the container held before is not kept.
        self.to_inspect = self
            .to_inspect
            .take()
            .filter(|to_inspect| is_placed && to_inspect.decision_id == decision_id);
        if let Some(to_inspect) = &mut self.to_inspect {
            to_inspect.placed_in = Some(outcome.state_number);
        }
    }

    /// Has the item that was placed last inspected, where that is wanted and was not done.
    pub(super) fn inspect(&mut self) {
        let Some(mut to_inspect) = self.to_inspect.take_if(|it| it.is_due()) else {
            return;
        };
        to_inspect.attempts += 1;
        let reason = match self.try_inspect(&mut to_inspect) {
            Ok(()) => return,
            Err(NotInspected::Yet(reason)) if to_inspect.attempts < MAX_ATTEMPTS => {
                tracing::debug!(cell = %self.cell, item_id = to_inspect.item_id, reason, "not inspected yet");
                self.to_inspect = Some(to_inspect);
                return;
            }
            Err(NotInspected::Yet(reason) | NotInspected::AtAll(reason)) => reason,
        };
        tracing::warn!(cell = %self.cell, item_id = to_inspect.item_id, reason, "not inspected");
    }

    fn try_inspect(&mut self, to_inspect: &mut ToInspect) -> Result<(), NotInspected> {
        let inspection = match &to_inspect.found {
            Some(found) => found.clone(),
            None => self.ask_inspection(to_inspect)?,
        };
        to_inspect.found = Some(inspection.clone());
        self.enter_inspection(&to_inspect.item_id, inspection)
            .map_err(|refusal| NotInspected::Yet(refusal.message))
    }

    fn ask_inspection(
        &mut self,
        to_inspect: &mut ToInspect,
    ) -> Result<v1::Inspection, NotInspected> {
        // A heightmap that surely shows the placement; perception has its cloud.
        let least = self.session.least_state_number();
        let deadline = Instant::now() + SCENE_LIMIT;
        let seen = self.scenes.current(least, deadline);
        to_inspect.request.least_state_number = seen.map_err(NotInspected::Yet)?.state_number;
        let request = to_inspect.request.clone();
        let deadline = Instant::now() + ANSWER_LIMIT;
        let reply = match self.client.call(&self.cell, request, deadline) {
            Ok(reply) => reply,
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
        let placed_in = to_inspect.placed_in.unwrap_or_default();
        if reply.state_number != 0 && placed_in != 0 && reply.state_number != placed_in {
            let changed = "the container changed before it was inspected";
            return Err(NotInspected::AtAll(changed.to_owned()));
        }
        let nothing = || NotInspected::Yet("perception told nothing".to_owned());
        reply.inspection.ok_or_else(nothing)
    }

    fn enter_inspection(
        &mut self,
        item_id: &str,
        inspection: v1::Inspection,
    ) -> Result<(), Refusal> {
        let kind = inspection.kind();
        let named = kind.as_str_name();
        tracing::info!(
            cell = %self.cell, item_id, inspection = named, slide_m = inspection.slide_m,
            tilt_rad = inspection.tilt_rad, reason = inspection.reason, "inspected"
        );
        let reason = inspection.reason.clone();
        self.change(|session| {
            let was_packed = session.inspected(item_id, inspection)?;
            if was_packed && kind == InspectionKind::Missing && session.is_automatic() {
                // It lies somewhere in the cell, maybe in the arm's way.
                let failure = format!("item {item_id} was placed, but {reason}");
                session.end(End::Failed(failure));
            }
            Ok(())
        })
    }
}
