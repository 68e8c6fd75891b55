//! What a bridge or a controller may say of how a decision ended.

use std::time::Instant;

use ppnpack_wire::convert::pose;
use ppnpack_wire::v1::{self, OutcomeKind, Status};

use super::CellPlanner;
use super::refusal::Refusal;

/// How far beside a container what lies in it may reach, in metres.
const BESIDE_M: f64 = 0.1;

impl CellPlanner {
    /// Refuses an outcome that cannot be the pending decision's: of another placement or item, with numbers that are none, of
    /// an item far from its place, or of a state that the cell cannot be in.
    pub(super) fn check_reported(
        &mut self,
        decision_id: &str,
        outcome: &v1::Outcome,
        deadline: Instant,
    ) -> Result<(), Refusal> {
        let pending = self.session.pending();
        let Some(decision) = pending.filter(|pending| pending.decision_id == decision_id) else {
            return Ok(());
        };
        let decision = decision.clone();
        check_names(&decision, outcome)?;
        check_lengths(outcome)?;
        let place = self.place_of(&decision.container)?;
        let size = place.planning.grid().container();
        let farthest_m = size.x_m.hypot(size.y_m).hypot(size.z_m) + BESIDE_M;
        check_place(&decision, outcome, farthest_m)?;
        self.check_reported_state(decision_id, outcome, deadline)
    }

    /// Refuses an outcome of a state that the cell cannot be in: one from before the state that the decision was made on, or one
    /// that the cell did not come to. After it the planner would use pictures of the past, or none that will ever come.
    ///
    /// An item that left the robot counts the state up: after that the cell is in a later one. What is more than one further the bridge
    /// has to know of; where none answers, the report is believed.
    fn check_reported_state(
        &mut self,
        decision_id: &str,
        outcome: &v1::Outcome,
        deadline: Instant,
    ) -> Result<(), Refusal> {
        let reported = outcome.state_number;
        let pending = self.session.pending();
        let Some(decision) = pending.filter(|pending| pending.decision_id == decision_id) else {
            return Ok(());
        };
        let decided_on = decision.state_number;
        let has_changed = matches!(outcome.kind(), OutcomeKind::Placed | OutcomeKind::Lost);
        if decided_on == 0 || (reported == 0 && !has_changed) {
            return Ok(());
        }
        let least = decided_on.saturating_add(u64::from(has_changed));
        if reported < least {
            return Err(Refusal::new(
                Status::Conflict,
                format_args!(
                    "outcome.state_number is {reported}: the decision was made on state {decided_on}, and the cell is in state {least} \
                     after it, or a later one: report that"
                ),
            ));
        }
        if reported <= decided_on.saturating_add(1) {
            return Ok(());
        }
        let container = decision.container.clone();
        match self.place_of(&container)?.bridge_state(deadline) {
            Some(state) if reported > state.state_number => Err(Refusal::new(
                Status::Conflict,
                format_args!(
                    "outcome.state_number: the cell is in state {}, and was never in {reported}",
                    state.state_number
                ),
            )),
            _ => Ok(()),
        }
    }
}

fn check_names(decision: &v1::Decision, outcome: &v1::Outcome) -> Result<(), Refusal> {
    for (field, reported, own) in [
        ("placement_id", &outcome.placement_id, &decision.decision_id),
        ("item_id", &outcome.item_id, &decision.item_id),
    ] {
        if !reported.is_empty() && reported != own {
            return Err(Refusal::new(
                Status::Conflict,
                format_args!("outcome.{field} is {reported:?}: the decision's is {own:?}"),
            ));
        }
    }
    Ok(())
}

fn check_lengths(outcome: &v1::Outcome) -> Result<(), Refusal> {
    for (field, value) in [("slide_m", outcome.slide_m), ("tilt_rad", outcome.tilt_rad)] {
        if !value.is_finite() {
            return Err(Refusal::invalid(format_args!("outcome.{field} is {value}")));
        }
    }
    Ok(())
}

/// Refuses a pose that is none, and one of a placed item that is farther from its place than this, in metres.
fn check_place(
    decision: &v1::Decision,
    outcome: &v1::Outcome,
    farthest_m: f64,
) -> Result<(), Refusal> {
    const FIELD: &str = "outcome.container_from_item";
    if outcome.container_from_item.is_none() {
        return Ok(());
    }
    let found = pose::read_required(FIELD, outcome.container_from_item.as_ref())?;
    let planned = pose::read_required("container_from_item", decision.container_from_item.as_ref());
    let (OutcomeKind::Placed, Ok(planned)) = (outcome.kind(), planned) else {
        return Ok(());
    };
    let away_m = (found.translation.vector - planned.translation.vector).norm();
    if away_m <= farthest_m {
        return Ok(());
    }
    Err(Refusal::invalid(format_args!(
        "{FIELD} is {away_m:.3} m from where the item was to be placed, so it does not lie in the container: \
         report it as lost, or see to the frame of the pose"
    )))
}
