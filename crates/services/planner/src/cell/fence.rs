//! Decisions of the past: none of them begins any more, however late its request comes to the bridge.

use std::time::{Duration, Instant};

use ppnpack_service::rpc::CallError;
use ppnpack_wire::v1::{self, Status};

use super::CellPlanner;
use super::refusal::Refusal;

/// How long the bridge may take.
const LIMIT: Duration = Duration::from_millis(500);

impl CellPlanner {
    /// Has the bridge count the state of the cell up, so that all that was decided before is stale. Gives the new state; `None`
    /// where there is no bridge, and a controller drives the robot itself.
    ///
    /// # Errors
    /// As what the bridge refuses it: [`Status::Busy`] while the robot carries something out.
    pub(super) fn void_decisions(&mut self, deadline: Instant) -> Result<Option<u64>, Refusal> {
        let client = &self.shared.helpers.client;
        let until = deadline.min(Instant::now() + LIMIT);
        match client.call(&self.cell, v1::ChangedRequest::default(), until) {
            Ok(reply) => Ok(reply.state.map(|state| state.state_number)),
            Err(CallError::NoAnswer { .. }) => Ok(None),
            Err(error) => Err(Refusal::new(
                error.status().unwrap_or(Status::Unavailable),
                format_args!("what was decided before may still begin: {error}"),
            )),
        }
    }
}
