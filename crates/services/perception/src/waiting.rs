//! Requests that wait until something has come, and what comes to the threads that answer them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
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
    /// There are new clouds.
    Clouds,
}

impl<R: Request> Mail<R> {
    pub(crate) fn request(incoming: Incoming<R>) -> Self {
        Self::Request(Box::new(incoming))
    }
}

/// Tells a thread that there are new clouds: once until it has looked, so that bells leave room for requests.
pub(crate) struct Bell<R: Request> {
    mailbox: SyncSender<Mail<R>>,
    is_rung: Arc<AtomicBool>,
}

impl<R: Request> Bell<R> {
    /// A bell of a thread that answers it by [`Waiting::has_heard`].
    pub(crate) fn new(mailbox: SyncSender<Mail<R>>, waiting: &Waiting<R>) -> Self {
        let is_rung = Arc::clone(&waiting.is_rung);
        Self { mailbox, is_rung }
    }

    pub(crate) fn ring(&self) {
        let was_rung = self.is_rung.swap(true, Ordering::AcqRel);
        if !was_rung && self.mailbox.try_send(Mail::Clouds).is_err() {
            // After whatever fills the mailbox, the clouds are looked at all the same.
            self.is_rung.store(false, Ordering::Release);
        }
    }
}

impl<R: Request> Clone for Bell<R> {
    fn clone(&self) -> Self {
        Self {
            mailbox: self.mailbox.clone(),
            is_rung: Arc::clone(&self.is_rung),
        }
    }
}

/// Requests that wait.
pub(crate) struct Waiting<R: Request> {
    requests: Vec<Incoming<R>>,
    /// How many may wait.
    most: usize,
    is_rung: Arc<AtomicBool>,
}

impl<R: Request> Waiting<R> {
    pub(crate) fn new(most: usize) -> Self {
        Self {
            requests: Vec::new(),
            most,
            is_rung: Arc::default(),
        }
    }

    /// Before clouds are looked at: those that come from now on ring again.
    pub(crate) fn has_heard(&self) {
        self.is_rung.store(false, Ordering::Release);
    }

    /// Lets a request wait; it is refused where too many do.
    pub(crate) fn keep(&mut self, incoming: Incoming<R>) {
        if self.requests.len() < self.most {
            self.requests.push(incoming);
        } else {
            incoming.refuse(Status::Busy, "too many wait already");
        }
    }

    /// Takes out those whose time has come and whose caller still waits.
    pub(crate) fn take(&mut self, is_served: impl Fn(&Incoming<R>) -> bool) -> Vec<Incoming<R>> {
        let has_time = |incoming: &Incoming<R>| Instant::now() < last_moment(incoming);
        self.requests
            .extract_if(.., |incoming| has_time(incoming) && is_served(incoming))
            .collect()
    }

    /// Takes out those whose time limit is about to pass.
    pub(crate) fn take_expired(&mut self) -> Vec<Incoming<R>> {
        let now = Instant::now();
        self.requests
            .extract_if(.., |incoming| last_moment(incoming) <= now)
            .collect()
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
