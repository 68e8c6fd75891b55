//! Resuming: for any number of placements, or for one.

use std::collections::BTreeSet;

use ppnpack_wire::v1;

use super::{ControlError, Controls, PATIENCE, Target};

impl Controls {
    /// Ends these holds, for one placement; the bridge holds the cell as that begins.
    pub(super) fn step(&self, target: &Target, ids: &[String]) -> Result<String, ControlError> {
        for state in self.states(target)? {
            if state.hold.is_none() {
                return Err(refused(
                    "the cell is not held: a step begins with a cell that stands still",
                ));
            }
            if !state.executing_placement_id.is_empty() {
                return Err(refused("a placement is still being made: wait for its end"));
            }
        }
        let done = "The cell goes on for one placement, and is held as that begins.";
        self.end_holds(target, ids, 1, done)
    }

    /// Ends these holds, for so many placements, or any number for 0. Says `done` in the end.
    pub(super) fn end_holds(
        &self,
        target: &Target,
        ids: &[String],
        most_placements: u32,
        done: &str,
    ) -> Result<String, ControlError> {
        // Containers that share a robot have the same holds: those end with the first.
        let mut named = BTreeSet::new();
        let mut left = BTreeSet::new();
        for (container, state) in target.containers.iter().zip(self.states(target)?) {
            let own = state.holds.into_iter().map(|hold| hold.id);
            let own: BTreeSet<String> = own.filter(|id| ids.contains(id)).collect();
            if !own.is_empty() && own.is_subset(&named) {
                continue;
            }
            named.extend(own);
            let request = v1::ResumeRequest {
                hold_ids: ids.to_vec(),
                most_placements,
                ..v1::ResumeRequest::default()
            };
            let reply = self.ask(container, request, PATIENCE)?;
            let hold = reply.state.and_then(|state| state.hold);
            left.extend(hold.map(|hold| hold.reason));
        }
        let left: Vec<String> = left.into_iter().collect();
        match left.is_empty() {
            true => Ok(done.to_owned()),
            false => Err(refused(format!(
                "the cell is still held: {}; look, then resume",
                left.join("; ")
            ))),
        }
    }

    fn states(&self, target: &Target) -> Result<Vec<v1::CellState>, ControlError> {
        let states = target.containers.iter().map(|container| {
            let reply = self.ask(container, v1::CellStateRequest::default(), PATIENCE)?;
            Ok(reply.state.unwrap_or_default())
        });
        states.collect()
    }
}

fn refused(why: impl Into<String>) -> ControlError {
    ControlError::Refused(why.into())
}
