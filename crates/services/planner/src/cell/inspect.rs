//! After a placement: perception says how the item lies, and the session is corrected by that.

use std::time::{Duration, Instant};

use ppnpack_packing::heightmap::Scene;
use ppnpack_wire::convert;
use ppnpack_wire::v1::{self, InspectionKind, OutcomeKind, Status};

use super::{CellPlanner, Refusal};
use crate::session::End;

/// How long one attempt may take, with the wait for a heightmap.
const LIMIT: Duration = Duration::from_millis(300);

/// Attempts before an item is left as it was reported.
const MAX_ATTEMPTS: u32 = 15;

/// An item that was decided on, until it is known how it lies.
#[derive(Debug)]
pub(crate) struct ToInspect {
    decision_id: String,
    item_id: String,
    request: v1::InspectRequest,
    /// Whether the item was placed: before, there is nothing to see.
    is_placed: bool,
    attempts: u32,
}

impl CellPlanner {
    /// Notes what was decided, and what the container held before.
    pub(super) fn will_inspect(&mut self, decision: &v1::Decision, before: &Scene) {
        if !self.settings.inspect {
            return;
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
            is_placed: false,
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
            to_inspect.is_placed = true;
        }
    }

    /// Has the item that was placed last inspected, where that is wanted and was not done.
    pub(super) fn inspect(&mut self) {
        let Some(mut to_inspect) = self.to_inspect.take_if(|it| it.is_placed) else {
            return;
        };
        match self.try_inspect(&mut to_inspect.request) {
            Ok(inspection) => {
                if let Err(refusal) = self.enter_inspection(&to_inspect.item_id, inspection) {
                    tracing::warn!(cell = %self.cell, reason = refusal.message, "an inspection is not entered");
                }
            }
            Err(reason) => {
                to_inspect.attempts += 1;
                let item_id = &to_inspect.item_id;
                if to_inspect.attempts < MAX_ATTEMPTS {
                    tracing::debug!(cell = %self.cell, item_id, reason, "not inspected yet");
                    self.to_inspect = Some(to_inspect);
                } else {
                    tracing::warn!(cell = %self.cell, item_id, reason, "not inspected");
                }
            }
        }
    }

    fn try_inspect(&mut self, request: &mut v1::InspectRequest) -> Result<v1::Inspection, String> {
        let deadline = Instant::now() + LIMIT;
        // A heightmap that surely shows the placement; perception has its cloud.
        let seen = self
            .scenes
            .current(self.session.least_state_number(), deadline)?;
        request.least_state_number = seen.state_number;
        match self.client.call(&self.cell, request.clone(), deadline) {
            Ok(reply) => reply
                .inspection
                .ok_or_else(|| "perception told nothing".to_owned()),
            // What perception does not know, it cannot find.
            Err(error) if error.status() == Some(Status::NotFound) => Ok(v1::Inspection {
                kind: InspectionKind::Unclear.into(),
                reason: error.to_string(),
                ..v1::Inspection::default()
            }),
            Err(error) => Err(format!("perception: {error}")),
        }
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
        self.change(|session| session.inspected(item_id, inspection))?;
        if kind == InspectionKind::Missing && self.session.is_automatic() {
            // It lies somewhere in the cell, maybe in the arm's way.
            let failure = format!("item {item_id} was placed, but {reason}");
            self.change(|session| {
                session.end(End::Failed(failure));
                Ok(())
            })?;
        }
        Ok(())
    }
}
