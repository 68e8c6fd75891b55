//! Checks of what a bridge or a controller says of how a decision ended.

use std::time::Instant;

use ppnpack_wire::convert::pose;
use ppnpack_wire::v1::{self, OutcomeKind, Status};

use super::CellPlanner;
use crate::bridge::Bridge;
use crate::refusal::Refusal;

/// Maximum distance beside a container that what lies in it may reach, in metres.
const BESIDE_M: f64 = 0.1;

impl CellPlanner {
    /// Refuses an outcome that cannot be the pending decision's: of another placement or item, with
    /// numbers that are none, of an item far from its place, or of an impossible state.
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
        let size = place.grid.container();
        let farthest_m = size.x_m.hypot(size.y_m).hypot(size.z_m) + BESIDE_M;
        check_place(&decision, outcome, farthest_m)?;
        check_state(&decision, outcome, &mut place.bridge, deadline)
    }
}

/// Refuses an outcome of a state that the cell cannot be in: one from before the state that the
/// decision was made on, or one that the cell did not come to. After it the planner would use
/// pictures of the past, or none that will ever come.
///
/// An item that left the robot counts the state up: after that the cell is in a later one. A state
/// more than one further has to be known to the bridge; where none answers, the report is believed.
fn check_state(
    decision: &v1::Decision,
    outcome: &v1::Outcome,
    bridge: &mut Bridge,
    deadline: Instant,
) -> Result<(), Refusal> {
    let (reported, decided_on) = (outcome.state_number, decision.state_number);
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
    match bridge.useful_state(deadline) {
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

/// Refuses a pose that is none, or farther from a placed item's place than this, in metres.
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
