//! One placement: the cell goes on until one has begun, and is held again.
//!
//! The protocol has no request for this. A hold brings what is under way to its end and lets nothing else begin, so one that is sent while
//! the first placement is made leaves it at that one. A robot that takes less time for a placement than is between two looks may have
//! begun another one by then.

use std::thread::sleep;
use std::time::{Duration, Instant};

use ppnpack_service::sync::lock;
use ppnpack_wire::v1;

use super::{ControlError, Controls, PATIENCE, Target};

/// How long it may take until a placement begins.
const BEGINNING: Duration = Duration::from_secs(30);

/// Between two looks whether one has.
const LOOK: Duration = Duration::from_millis(5);

/// Why the cell is held afterwards.
const ONE_STEP: &str = "one step was asked for at the operator's page";

impl Controls {
    pub(super) fn step(&self, target: &Target) -> Result<String, ControlError> {
        if !lock(&self.stepping).insert(target.cell.clone()) {
            return Err(ControlError::Busy("another step is under way"));
        }
        let stepped = self.step_alone(target);
        lock(&self.stepping).remove(&target.cell);
        stepped
    }

    fn step_alone(&self, target: &Target) -> Result<String, ControlError> {
        let before = self.states(target)?;
        if before.iter().any(|state| state.hold.is_none()) {
            return Err(refused(
                "the cell is not held: a step begins with a cell that stands still",
            ));
        }
        if before.iter().any(is_placing) {
            return Err(refused("a placement is still being made: wait for its end"));
        }
        let resumed = self.resume(target);
        let begun = resumed.and_then(|_| self.await_placement(target, &before));
        // Also where it was not resumed, as far as is known: it may have been.
        self.hold(target, ONE_STEP, false).map_err(goes_on)?;
        begun
    }

    fn states(&self, target: &Target) -> Result<Vec<v1::CellState>, ControlError> {
        let states = target.containers.iter().map(|container| {
            let reply = self.ask(container, v1::CellStateRequest::default(), PATIENCE)?;
            Ok(reply.state.unwrap_or_default())
        });
        states.collect()
    }

    /// Looks until a placement has begun; one that began and ended between two looks has left a later state than the one before.
    fn await_placement(
        &self,
        target: &Target,
        before: &[v1::CellState],
    ) -> Result<String, ControlError> {
        let deadline = Instant::now() + BEGINNING;
        while Instant::now() < deadline {
            // Who does not answer now may the next time.
            let states = self.states(target).unwrap_or_default();
            if states.iter().any(is_placing) {
                return Ok("One placement has begun; the cell is held after it.".to_owned());
            }
            let mut pairs = states.iter().zip(before);
            if pairs.any(|(now, before)| now.state_number != before.state_number) {
                return Ok("The container has changed; the cell is held.".to_owned());
            }
            if states.iter().any(|state| state.hold.is_some()) {
                return Err(refused(
                    "it was held by somebody else before a placement began",
                ));
            }
            sleep(LOOK);
        }
        Err(ControlError::Refused(format!(
            "no placement began within {} s; the cell is held again",
            BEGINNING.as_secs()
        )))
    }
}

fn is_placing(state: &v1::CellState) -> bool {
    !state.executing_placement_id.is_empty()
}

fn refused(why: &str) -> ControlError {
    ControlError::Refused(why.to_owned())
}

/// The cell could not be held again.
fn goes_on(error: ControlError) -> ControlError {
    match error {
        ControlError::Refused(why) | ControlError::Unanswered(why) => ControlError::Unanswered(
            format!("THE CELL GOES ON: it could not be held again after the step: {why}"),
        ),
        other => other,
    }
}
