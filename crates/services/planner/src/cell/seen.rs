//! What the container looks like, and which state of the cell that is.

use std::time::{Duration, Instant};

use ppnpack_wire::v1;

use super::CellPlanner;
use super::counts;
use super::refusal::Refusal;
use crate::scenes::Seen;

/// How long the bridge may take to say in which state the cell is.
const PATIENCE: Duration = Duration::from_millis(100);

/// A bridge that did not say is left alone for so long.
const LEFT_ALONE: Duration = Duration::from_secs(30);

impl CellPlanner {
    /// A heightmap that shows what was done so far; waits for it until the deadline.
    ///
    /// Where its sensor knows no states it is of the state that the bridge has now: for that it has to have come after this state was
    /// heard of for the first time.
    pub(super) fn seen(&mut self, deadline: Instant) -> Result<Seen, Refusal> {
        let least = self.session.least_state_number();
        loop {
            let seen = self.scenes.current(least, deadline);
            let seen = seen.inspect_err(|_| counts::stale_scenes(&self.cell, 1));
            let mut seen = seen.map_err(Refusal::unavailable)?;
            if seen.state_number != 0 {
                return Ok(seen);
            }
            let Some(v1::CellState { state_number, .. }) = self.bridge_state(deadline) else {
                return Ok(seen);
            };
            if self.shown_state == Some(state_number) {
                seen.state_number = state_number;
                return Ok(seen);
            }
            self.container_changed(Some(state_number));
        }
    }

    /// The container's content changed just now, to this state where it is known.
    pub(super) fn container_changed(&mut self, state_number: Option<u64>) {
        self.shown_state = state_number;
        self.scenes.changed();
    }

    /// The state of the cell as the bridge has it now, where there is one.
    pub(super) fn bridge_state(&mut self, deadline: Instant) -> Option<v1::CellState> {
        let now = Instant::now();
        let left_alone = self.bridge_left_alone_until;
        if left_alone.is_some_and(|until| now < until) {
            return None;
        }
        let until = deadline.min(now + PATIENCE);
        let request = v1::CellStateRequest::default();
        let reply = self.shared.helpers.client.call(&self.cell, request, until);
        let state = reply.ok().and_then(|reply| reply.state);
        match &state {
            Some(state) => self.bridge_clock.heard(state),
            None => self.bridge_left_alone_until = Some(now + LEFT_ALONE),
        }
        state
    }
}
