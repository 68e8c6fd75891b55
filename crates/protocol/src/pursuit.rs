//! The pursuit of a decision to its outcome, by the bridge's answers. A controller that carries
//! decisions out does the same as the planner.
//!
//! A decision is settled only by certain knowledge of the bridge: as the outcome that it wrote
//! down, as not placed where the placement can never begin, or as unknown.

use ppnpack_wire::v1::{self, ExecutionPhase, OutcomeKind, Status};

/// The next step of a pursuit.
#[derive(Debug, Clone, PartialEq)]
pub enum Next {
    /// The bridge carries it out: its end is waited for.
    Wait,
    /// It has ended in this way.
    Settle(v1::Outcome),
    /// The bridge has no outcome of it, and never will: it is settled as this, at the state that
    /// the cell has now.
    SettleAs(OutcomeKind),
    /// The placement is sent again.
    PlaceAgain,
    /// The same is asked again after a while.
    AskAgain,
    /// Asking again cannot help: somebody has to look.
    GiveUp,
}

/// The bridge's answer: the state of the placement, or the status of a refusal; `None` where no
/// answer came.
pub type Answer<'a> = Result<Option<&'a v1::Execution>, Option<Status>>;

/// Gives the next step after the placement was sent.
pub fn after_place(answer: Answer<'_>) -> Next {
    match answer {
        Ok(execution) => of_execution(execution),
        // The cell may change until it goes on: then it is seen and planned anew.
        Err(Some(Status::Held | Status::Stale)) => Next::SettleAs(OutcomeKind::NotPlaced),
        Err(Some(Status::Forgotten)) => Next::SettleAs(OutcomeKind::Unknown),
        Err(Some(Status::Invalid | Status::NotFound | Status::Conflict)) => Next::GiveUp,
        Err(_) => Next::AskAgain,
    }
}

/// Gives the next step after the outcome was asked for.
pub fn after_outcome(answer: Answer<'_>) -> Next {
    match answer {
        Ok(execution) => of_execution(execution),
        // A bridge that lost the placement says so when it is sent again.
        Err(Some(Status::NotFound)) => Next::PlaceAgain,
        // The robot still moves; whichever of the two clocks said so first.
        Err(Some(Status::TimedOut)) => Next::Wait,
        Err(_) => Next::AskAgain,
    }
}

fn of_execution(execution: Option<&v1::Execution>) -> Next {
    let ended = execution.filter(|execution| execution.phase() == ExecutionPhase::Ended);
    match ended.and_then(|execution| execution.outcome.clone()) {
        Some(outcome) => Next::Settle(outcome),
        None => Next::Wait,
    }
}

/// Gives the kind as which a decision is settled with a bridge in this state. One that does not
/// know all placements since the decision, or does not say so, as older ones do not, may have
/// carried it out and forgotten. No bridge that counts its states begins anything on state 0.
pub fn as_known(kind: OutcomeKind, decision: &v1::Decision, state: &v1::CellState) -> OutcomeKind {
    if decision.state_number == 0 && state.state_number != 0 {
        return OutcomeKind::NotPlaced;
    }
    let is_known = (1..=decision.state_number).contains(&state.first_state_number);
    match kind {
        OutcomeKind::NotPlaced if !is_known => OutcomeKind::Unknown,
        kind => kind,
    }
}

/// Makes the outcome of a decision of which the bridge has none; `state_number` is the cell's now.
pub fn settled_as(
    decision: &v1::Decision,
    kind: OutcomeKind,
    failure: &str,
    state_number: u64,
) -> v1::Outcome {
    v1::Outcome {
        placement_id: decision.decision_id.clone(),
        item_id: decision.item_id.clone(),
        kind: kind.into(),
        failure: failure.to_owned(),
        state_number,
        ..v1::Outcome::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_refused_was_not_placed_where_the_bridge_knows_all_since_or_the_decision_is_of_no_state()
     {
        use OutcomeKind::{NotPlaced, Unknown};
        let decision = |state_number| v1::Decision {
            state_number,
            ..v1::Decision::default()
        };
        let state = |first_state_number| v1::CellState {
            state_number: 90,
            first_state_number,
            ..v1::CellState::default()
        };
        for (kind, decided_on, known_since, expected) in [
            (NotPlaced, 70, 70, NotPlaced),
            (NotPlaced, 70, 71, Unknown),
            // An older bridge does not say.
            (NotPlaced, 70, 0, Unknown),
            (Unknown, 70, 70, Unknown),
            // No bridge that counts its states begins anything on state 0.
            (NotPlaced, 0, 70, NotPlaced),
            (NotPlaced, 0, 0, NotPlaced),
            (Unknown, 0, 70, NotPlaced),
        ] {
            let settled = as_known(kind, &decision(decided_on), &state(known_since));
            assert_eq!(settled, expected, "{kind:?} {decided_on} {known_since}");
        }
        let countless = v1::CellState::default();
        assert_eq!(as_known(NotPlaced, &decision(0), &countless), Unknown);
    }
}
