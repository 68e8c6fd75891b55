//! A request that waits for its answer.

use std::cell::Cell as ThreadCell;
use std::marker::PhantomData;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ::metrics::{Counter, Histogram};
use ppnpack_wire::encoding_of;
use ppnpack_wire::header::{self, RequestHeader};
use ppnpack_wire::keys::{Cell, Method, Service};
use ppnpack_wire::rpc::{Reply, Request};
use ppnpack_wire::v1::{self, Status};
use prost::Message;
use tracing::Span;
use zenoh::Wait;
use zenoh::bytes::Encoding;
use zenoh::query::Query;

use super::trace;
use crate::alive::Alive;
use crate::clock::Boottime;
use crate::metrics::{self, Metric};
use crate::payload::Malformed;
use crate::process::Core;

/// Maximum time before its time limit, at most a tenth of it, at which a waiting request is
/// answered, so that the answer comes in time.
const ANSWER_BEFORE: Duration = Duration::from_millis(20);

const MAX_STAGES: usize = 32;

thread_local! {
    /// The answer to a request that is dropped without one.
    static WHEN_DROPPED: ThreadCell<(Status, &'static str)> =
        const { ThreadCell::new((Status::Failed, "the service gave the request up")) };
}

/// A request that waits for its answer. Dropped without one it is answered with `STATUS_FAILED`.
pub struct Incoming<R: Request> {
    pub(super) message: R,
    pub(super) header: RequestHeader,
    pub(super) cell: Cell,
    pub(super) pending: Pending<R>,
}

/// A report on the work, which goes with an answer.
#[derive(Debug, Clone, Default)]
pub struct Done {
    /// The times of the stages. The wait in the mailbox comes before them by itself, as `queue`.
    pub stages: Vec<v1::StageTiming>,
    /// The network that took part.
    pub model: Option<String>,
}

impl Done {
    /// Reports work in one stage.
    pub fn in_one(stage: &str, took: Duration) -> Self {
        Self {
            stages: vec![header::stage(stage, took)],
            model: None,
        }
    }
}

impl<R: Request> Incoming<R> {
    /// The request.
    pub fn message(&self) -> &R {
        &self.message
    }

    /// Takes the request out, and says that work on it begins.
    pub fn take(&mut self) -> R {
        self.start();
        std::mem::take(&mut self.message)
    }

    /// Says that work on it begins: the time before counts as waiting. The first time counts.
    pub fn start(&mut self) {
        self.pending.started.get_or_insert_with(Instant::now);
    }

    /// Its header.
    pub fn header(&self) -> &RequestHeader {
        &self.header
    }

    /// The cell that it is for.
    pub fn cell(&self) -> &Cell {
        &self.cell
    }

    /// Gives the time at which it came.
    pub fn came(&self) -> Boottime {
        self.pending.came
    }

    /// Gives the time at which its caller stops waiting.
    pub fn deadline(&self) -> Instant {
        self.pending.received + self.header.time_limit
    }

    /// Gives the time by which it has to be answered, so that its caller still waits.
    pub fn answer_by(&self) -> Instant {
        self.deadline() - ANSWER_BEFORE.min(self.header.time_limit / 10)
    }

    /// Says whether its caller has stopped waiting.
    pub fn has_expired(&self) -> bool {
        Instant::now() >= self.deadline()
    }

    /// Gives the request, if its answer is still waited for: in time, and its planner has not gone
    /// since. Else it is refused.
    pub fn still_wanted(self, planners: &Alive) -> Option<Self> {
        if self.has_expired() {
            self.refuse(Status::TimedOut, "the time limit passed in the queue");
            return None;
        }
        let has_left = |caller| planners.has_left_since(caller, self.pending.received);
        if self.header.caller.as_ref().is_some_and(has_left) {
            self.refuse(Status::Unavailable, "the planner that asked has gone");
            return None;
        }
        Some(self)
    }

    /// The span of the work on it. Enter it where the work is done: calls from there belong to the
    /// same trace.
    pub fn span(&self) -> &Span {
        &self.pending.span
    }

    /// Answers it.
    pub fn reply(self, reply: R::Reply, done: Done) {
        self.pending.reply(reply, done);
    }

    /// Refuses it.
    pub fn refuse(self, status: Status, message: impl Into<String>) {
        self.pending.refuse(status, &message.into());
    }

    /// Leaves it without an answer, as its caller has sent it again under the same id: one answer
    /// suffices.
    pub fn leave(mut self) {
        self.pending.query = None;
    }

    /// Refuses it with a reply that says more.
    pub fn refuse_with(mut self, reply: R::Reply, status: Status, message: impl Into<String>) {
        self.pending
            .answer(reply, status, &message.into(), Done::default());
    }
}

/// Drops the holder of a request that has no answer, which is refused by that.
pub(crate) fn drop_with<T>(holder: T, status: Status, message: &'static str) {
    let before = WHEN_DROPPED.replace((status, message));
    drop(holder);
    WHEN_DROPPED.set(before);
}

/// The common part of all requests of a method.
pub(super) struct Answering {
    core: Arc<Core>,
    service: Service,
    method: Method,
    reply_encoding: Encoding,
    queued: Histogram,
    worked: Histogram,
    /// The counters of answers, by status.
    answered: Vec<Counter>,
    pub(super) malformed: Malformed,
}

impl Answering {
    pub(super) fn new<R: Request>(core: Arc<Core>, service: Service) -> Self {
        let method = R::METHOD;
        let labels @ [of_service, of_method] = metrics::method_labels(service, method);
        let statuses = (0..).map_while(|number| Status::try_from(number).ok());
        let answered = statuses.map(|status| {
            let status = ("status", status.as_str_name());
            metrics::counter(Metric::RequestsTotal, &[of_service, of_method, status])
        });
        Self {
            core,
            service,
            method,
            reply_encoding: encoding_of::<R::Reply>().into(),
            queued: metrics::histogram(Metric::RequestQueueSeconds, &labels),
            worked: metrics::histogram(Metric::RequestWorkSeconds, &labels),
            answered: answered.collect(),
            malformed: Malformed::new(format!("{service}/{method}")),
        }
    }
}

/// The answer that a request still needs.
pub(super) struct Pending<R: Request> {
    answering: Arc<Answering>,
    /// `None` once answered.
    query: Option<Query>,
    pub(super) request_id: String,
    received: Instant,
    came: Boottime,
    started: Option<Instant>,
    span: Span,
    request: PhantomData<fn(R)>,
}

impl<R: Request> Pending<R> {
    pub(super) fn new(answering: Arc<Answering>, query: Query, received: Instant) -> Self {
        Self {
            answering,
            query: Some(query),
            request_id: String::new(),
            received,
            came: Boottime::now(),
            started: None,
            span: Span::none(),
            request: PhantomData,
        }
    }

    /// Begins the span of the work, as a part of the caller's trace.
    pub(super) fn begin_span(&mut self) {
        let (service, method) = (self.answering.service, self.answering.method);
        let attachment = self.query.as_ref().and_then(Query::attachment);
        self.span = trace::serving(service, method, &self.request_id, attachment);
    }

    pub(super) fn reply(mut self, reply: R::Reply, done: Done) {
        self.answer(reply, Status::Ok, "", done);
    }

    pub(super) fn refuse(mut self, status: Status, message: &str) {
        self.answer(R::Reply::default(), status, message, Done::default());
    }

    fn answer(&mut self, mut reply: R::Reply, status: Status, message: &str, done: Done) {
        let Some(query) = self.query.take() else {
            return;
        };
        let answering = &self.answering;
        let started = self.started.unwrap_or(self.received);
        let queued = started.saturating_duration_since(self.received);
        let mut stages = vec![header::stage("queue", queued)];
        stages.extend(done.stages);
        stages.truncate(MAX_STAGES);
        reply.set_header(v1::ReplyHeader {
            request_id: std::mem::take(&mut self.request_id),
            status: status.into(),
            message: header::text(message),
            stages,
            versions: Some(answering.core.versions(done.model.as_deref())),
        });
        // Replies have all qualities of their query but this one.
        let sent = query
            .reply(query.key_expr().clone(), reply.encode_to_vec())
            .encoding(answering.reply_encoding.clone())
            .express(true)
            .wait();
        drop(query);
        if let Err(error) = sent {
            tracing::debug!(%error, "an answer cannot be sent");
        }
        answering.queued.record(queued);
        answering.worked.record(started.elapsed());
        let status = usize::try_from(i32::from(status)).ok();
        if let Some(counter) = status.and_then(|status| answering.answered.get(status)) {
            counter.increment(1);
        }
    }
}

impl<R: Request> Drop for Pending<R> {
    fn drop(&mut self) {
        if self.query.is_some() {
            let (status, message) = WHEN_DROPPED.get();
            self.answer(R::Reply::default(), status, message, Done::default());
        }
    }
}
