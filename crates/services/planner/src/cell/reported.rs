//! Which state of the cell a controller may report.

use std::time::Instant;

use ppnpack_wire::v1::{self, OutcomeKind, Status};

use super::CellPlanner;
use super::refusal::Refusal;

impl CellPlanner {
    /// Refuses an outcome of a state that the cell cannot be in: one from before the state that the decision was made on, or one
    /// that the cell did not come to. After it the planner would use pictures of the past, or none that will ever come.
    ///
    /// An item that left the robot counts the state up: after that the cell is in a later one. What is more than one further the bridge
    /// has to know of; where none answers, the report is believed.
    pub(super) fn check_reported_state(
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
