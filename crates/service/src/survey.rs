//! How all services are, asked of all at the same time.

use std::time::{Duration, Instant};

use ppnpack_wire::v1;
use zenoh::Session;

use crate::alive::{self, Found};
use crate::error::ServiceError;
use crate::rpc::{CallError, Client};

/// The check of an instance that is there and does not answer.
pub const ANSWER: &str = "answer";

/// The health of every instance that is there. One that does not answer in time is not ready, by the check [`ANSWER`]. Takes `patience` at
/// most, half of it to find them.
///
/// # Errors
/// [`ServiceError::Zenoh`] where the session is closed.
pub fn health(session: &Session, patience: Duration) -> Result<Vec<v1::HealthReply>, ServiceError> {
    let begun = Instant::now();
    let found = alive::find(session, begun + patience / 2)?;
    let answers = Client::new(session).health_of_all(&found, begun + patience);
    let replies = found.iter().zip(answers);
    let replies =
        replies.map(|(found, answer)| answer.unwrap_or_else(|error| unanswered(found, &error)));
    Ok(replies.collect())
}

fn unanswered(found: &Found, error: &CallError) -> v1::HealthReply {
    v1::HealthReply {
        header: Some(v1::ReplyHeader {
            versions: Some(v1::Versions {
                instance: found.instance.to_string(),
                ..v1::Versions::default()
            }),
            ..v1::ReplyHeader::default()
        }),
        service: found.service.to_string(),
        is_ready: false,
        checks: vec![v1::HealthCheck {
            name: ANSWER.to_owned(),
            is_passing: false,
            message: error.to_string(),
        }],
        uptime_ns: 0,
        cells: found.cells.iter().map(ToString::to_string).collect(),
    }
}
