//! The health of the services, asked for every few seconds.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use ppnpack_service::process::thread;
use ppnpack_service::{ServiceError, Shutdown, survey};
use prost::Message;
use zenoh::Session;

use crate::error::{RecordingError, joined};
use crate::queue::{Entry, Queue};
use crate::topic::Topic;

const ASKED_EVERY: Duration = Duration::from_secs(5);

/// How long all of them may take to answer.
const PATIENCE: Duration = Duration::from_secs(1);

pub(crate) struct HealthThread {
    thread: JoinHandle<()>,
    end: Shutdown,
}

impl HealthThread {
    /// Starts to ask, and puts the answers into the queue.
    pub(crate) fn start(session: &Session, queue: &Arc<Queue>) -> Result<Self, ServiceError> {
        let end = Shutdown::default();
        let (session, queue, asked) = (session.clone(), Arc::clone(queue), end.clone());
        let thread = thread("health", move || {
            ask(&session, &queue);
            while !asked.wait_timeout(ASKED_EVERY) {
                ask(&session, &queue);
            }
        })?;
        Ok(Self { thread, end })
    }

    pub(crate) fn finish(self) -> Result<(), RecordingError> {
        self.end.request();
        joined(self.thread)
    }
}

fn ask(session: &Session, queue: &Queue) {
    let replies = survey::health(session, PATIENCE).unwrap_or_else(|error| {
        tracing::warn!(%error, "the health of the services is not recorded");
        Vec::new()
    });
    for reply in replies {
        queue.push(Entry::now(Topic::Health, reply.encode_to_vec()));
    }
}
