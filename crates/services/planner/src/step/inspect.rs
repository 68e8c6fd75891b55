//! Perception asked how the item that was placed last lies.

use std::time::{Duration, Instant};

use ppnpack_service::rpc::CallError;
use ppnpack_wire::v1::{self, InspectionKind, Status};

use super::Stepper;

/// Maximum wait of one attempt for a heightmap that shows the placement.
const SCENE_LIMIT: Duration = Duration::from_millis(300);

/// Maximum time of perception's answer.
const ANSWER_LIMIT: Duration = Duration::from_secs(1);

/// An item to inspect.
#[derive(Debug, Clone)]
pub(crate) struct Inspect {
    pub(crate) decision_id: String,
    /// The container that it was placed into.
    pub(crate) container: String,
    pub(crate) request: v1::InspectRequest,
    /// The state of the cell after the placement.
    pub(crate) placed_in: u64,
}

/// Why there is no inspection.
pub(crate) enum NotInspected {
    /// It may be had later.
    Yet(String),
    /// It cannot be had.
    AtAll(String),
    /// Perception inspects nothing.
    Anything(String),
}

impl Stepper {
    /// Waits for a heightmap that surely shows the placement, as perception has its cloud then, and
    /// asks perception.
    pub(super) fn inspect(&mut self, it: &Inspect) -> Result<v1::Inspection, NotInspected> {
        let least = self.session.least_state_number(&it.container);
        let container = self.container(&it.container);
        let container = container.map_err(|error| NotInspected::AtAll(error.to_string()))?;
        let until = Instant::now() + SCENE_LIMIT;
        let seen = container.scenes.current(least, until);
        let request = v1::InspectRequest {
            least_state_number: seen.map_err(NotInspected::Yet)?.state_number,
            ..it.request.clone()
        };
        let address = container.address.clone();
        let until = Instant::now() + ANSWER_LIMIT;
        let answer = self.client.call(&address, request, until);
        read_answer(it.placed_in, self.settings.inspect.is_some(), answer)
    }
}

/// Reads perception's answer about an item that was placed in this state of the cell. Where the
/// settings do not ask for inspections, a perception that inspects nothing is as good.
fn read_answer(
    placed_in: u64,
    is_asked_for: bool,
    answer: Result<v1::InspectReply, CallError>,
) -> Result<v1::Inspection, NotInspected> {
    let reply = match answer {
        Ok(reply) => reply,
        Err(error) if !is_asked_for && inspects_nothing(&error) => {
            return Err(NotInspected::Anything(error.to_string()));
        }
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
    if reply.state_number != 0 && placed_in != 0 && reply.state_number != placed_in {
        let changed = "the container changed before it was inspected";
        return Err(NotInspected::AtAll(changed.to_owned()));
    }
    let nothing = || NotInspected::Yet("perception told nothing".to_owned());
    reply.inspection.ok_or_else(nothing)
}

fn inspects_nothing(error: &CallError) -> bool {
    matches!(error, CallError::NoAnswer { .. }) || error.status() == Some(Status::NotFound)
}
