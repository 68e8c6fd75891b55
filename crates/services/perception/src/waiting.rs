//! Requests that wait until something has come, and what comes to the threads that answer them.

use std::time::{Duration, Instant};

use ppnpack_service::rpc::Incoming;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::Status;

/// Who waits is answered so long before the time limit passes, or a tenth of it, that the answer still comes in time.
const ANSWER_BEFORE: Duration = Duration::from_millis(20);

/// Nobody waits.
const LONG: Duration = Duration::from_secs(3600);

/// What comes to a thread whose requests wait for clouds.
pub(crate) enum Mail<R: Request> {
    /// Somebody asks.
    Request(Box<Incoming<R>>),
    /// There is a new cloud.
    Cloud,
}

impl<R: Request> Mail<R> {
    pub(crate) fn request(incoming: Incoming<R>) -> Self {
        Self::Request(Box::new(incoming))
    }
}

/// Requests that wait.
pub(crate) struct Waiting<R: Request> {
    requests: Vec<Incoming<R>>,
    /// How many may wait.
    most: usize,
}

impl<R: Request> Waiting<R> {
    pub(crate) fn new(most: usize) -> Self {
        Self {
            requests: Vec::new(),
            most,
        }
    }

    /// Lets a request wait; it is refused where too many do.
    pub(crate) fn keep(&mut self, incoming: Incoming<R>) {
        if self.requests.len() < self.most {
            self.requests.push(incoming);
        } else {
            incoming.refuse(Status::Busy, "too many wait already");
        }
    }

    /// Takes out those whose time has come.
    pub(crate) fn take(&mut self, is_served: impl Fn(&Incoming<R>) -> bool) -> Vec<Incoming<R>> {
        self.requests
            .extract_if(.., |incoming| is_served(incoming))
            .collect()
    }

    /// Takes out those whose time limit is about to pass.
    pub(crate) fn take_expired(&mut self) -> Vec<Incoming<R>> {
        let now = Instant::now();
        self.take(|incoming| last_moment(incoming) <= now)
    }

    /// How long until the next one has to be answered.
    pub(crate) fn pause(&self) -> Duration {
        let first = self.requests.iter().map(last_moment).min();
        first.map_or(LONG, |first| {
            first.saturating_duration_since(Instant::now())
        })
    }
}

/// When a request that waits has to be answered.
fn last_moment<R: Request>(incoming: &Incoming<R>) -> Instant {
    incoming.deadline() - ANSWER_BEFORE.min(incoming.header().time_limit / 10)
}
