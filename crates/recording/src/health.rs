//! The health of the services, asked for every few seconds.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use ppnpack_service::clock::now_ns;
use ppnpack_service::process::thread;
use ppnpack_service::{Shutdown, survey};
use prost::Message;
use zenoh::Session;

use crate::error::{RecordingError, joined};
use crate::queue::{Entry, Queue, Sample};
use crate::topic::Topic;

/// How often services are asked.
const ASKED_EVERY: Duration = Duration::from_secs(5);

/// How long all of them may take to answer.
const PATIENCE: Duration = Duration::from_secs(1);

/// The thread that asks.
pub(crate) struct HealthThread {
    thread: JoinHandle<()>,
    end: Shutdown,
}

impl HealthThread {
    /// Has nothing asked any more.
    pub(crate) fn finish(self) -> Result<(), RecordingError> {
        self.end.request();
        joined(self.thread)
    }
}

/// Starts to ask, and puts the answers into the queue.
pub(crate) fn start(session: &Session, queue: &Arc<Queue>) -> Result<HealthThread, RecordingError> {
    let end = Shutdown::default();
    let (session, queue, asked) = (session.clone(), Arc::clone(queue), end.clone());
    let thread = thread("health", move || {
        ask(&session, &queue);
        while !asked.wait_timeout(ASKED_EVERY) {
            ask(&session, &queue);
        }
    })?;
    Ok(HealthThread { thread, end })
}

fn ask(session: &Session, queue: &Queue) {
    let replies = match survey::health(session, PATIENCE) {
        Ok(replies) => replies,
        Err(error) => {
            tracing::warn!(%error, "the health of the services is not recorded");
            return;
        }
    };
    for reply in replies {
        queue.push(Entry::new(Sample {
            topic: Topic::Health,
            at_ns: now_ns(),
            payload: reply.encode_to_vec().into(),
        }));
    }
}
