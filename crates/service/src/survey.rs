//! The health of all services, asked of all at the same time.

use std::time::{Duration, Instant};

use ppnpack_wire::v1;
use zenoh::Session;

use crate::alive::{self, Found};
use crate::error::ServiceError;
use crate::rpc::{CallError, Client};

/// Name of the check of an instance that is there and does not answer.
const ANSWER: &str = "answer";

/// Gives every instance that is there with its health. One that does not answer in time is not
/// ready, and [silent](is_silent). Takes `patience` at most, half of it to find them.
pub fn instances(
    session: &Session,
    patience: Duration,
) -> Result<Vec<(Found, v1::HealthReply)>, ServiceError> {
    let begun = Instant::now();
    let found = alive::find(session, begun + patience / 2)?;
    let asked = found.iter().map(|found| (found.service, &found.instance));
    let answers = Client::new(session).health_of_all(asked, begun + patience);
    let pairs = found.into_iter().zip(answers).map(|(found, answer)| {
        let health = answer.unwrap_or_else(|error| unanswered(&found, &error));
        (found, health)
    });
    Ok(pairs.collect())
}

/// Gives the health of every [instance](instances) that is there.
pub fn health(session: &Session, patience: Duration) -> Result<Vec<v1::HealthReply>, ServiceError> {
    let instances = instances(session, patience)?;
    Ok(instances.into_iter().map(|(_, health)| health).collect())
}

/// Says whether the health is of an instance that did not answer.
pub fn is_silent(health: &v1::HealthReply) -> bool {
    health.checks.iter().any(|check| check.name == ANSWER)
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
