//! Requests made of others.

use std::marker::PhantomData;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use ppnpack_wire::header::RequestHeader;
use ppnpack_wire::keys::{Cell, Instance, Key, Method, Service};
use ppnpack_wire::rpc::{Reply as _, Request};
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{MAX_MESSAGE_BYTES, WireError, encoding_of};
use tracing::Span;
use zenoh::bytes::ZBytes;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{ConsolidationMode, Reply};
use zenoh::{Session, Wait};

use super::error::{CallError, Refusal};
use super::trace;
use crate::metrics::{self, Metric};
use crate::payload;

/// Minimum and maximum pause before a request that nobody answered is sent again.
const FIRST_PAUSE: Duration = Duration::from_millis(5);
const LONGEST_PAUSE: Duration = Duration::from_millis(100);

/// Minimum wait for an answer before a request is sent again; each time twice as long. A request
/// may be lost without anybody being told, as when who was to answer is killed meanwhile.
const FIRST_PATIENCE: Duration = Duration::from_secs(2);

/// Time that Zenoh keeps a request beyond its caller's patience: the caller is to give up first.
const ZENOH_MARGIN: Duration = Duration::from_millis(100);

/// Maximum number of replies, and ends of them, that are kept for the caller.
const KEPT_EVENTS: usize = 16;

/// The number of requests of this operating-system process.
static REQUESTS: AtomicU64 = AtomicU64::new(0);

/// Asks others. Requests get a fresh id unless they have one; their time limit is what is left to
/// the deadline.
#[derive(Debug, Clone)]
pub struct Client {
    session: Session,
    caller: Option<Instance>,
    session_id: Option<String>,
}

impl Client {
    /// Makes a client on a session.
    pub fn new(session: &Session) -> Self {
        Self {
            session: session.clone(),
            caller: None,
            session_id: None,
        }
    }

    /// Asks as this planner: what still waits when it has gone is dropped.
    #[must_use]
    pub fn of_planner(mut self, planner: &Instance) -> Self {
        self.caller = Some(planner.clone());
        self
    }

    /// Asks planners as the controller of this packing session: they refuse it once another session
    /// is under way.
    #[must_use]
    pub fn of_session(mut self, session_id: &str) -> Self {
        self.session_id = Some(session_id.to_owned());
        self
    }

    /// Asks any instance, and again where nobody answers, until the deadline.
    ///
    /// # Errors
    /// [`CallError`]
    pub fn call<R: Request>(
        &self,
        cell: &Cell,
        request: R,
        deadline: Instant,
    ) -> Result<R::Reply, CallError> {
        self.insist(Target::of::<R>(cell, None)?, request, deadline)
    }

    /// Asks this instance, and again where it does not answer, until the deadline.
    ///
    /// # Errors
    /// [`CallError`]
    pub fn call_instance<R: Request>(
        &self,
        cell: &Cell,
        instance: &Instance,
        request: R,
        deadline: Instant,
    ) -> Result<R::Reply, CallError> {
        self.insist(Target::of::<R>(cell, Some(instance))?, request, deadline)
    }

    /// Asks an instance for its health, and again where it does not answer, until the deadline.
    ///
    /// # Errors
    /// [`CallError`]
    pub fn health(
        &self,
        service: Service,
        instance: &Instance,
        deadline: Instant,
    ) -> Result<v1::HealthReply, CallError> {
        let target = Target::new(None, service, Method::Health, Some(instance));
        self.insist(target, v1::HealthRequest::default(), deadline)
    }

    /// Asks these instances for their health, each once and all at the same time. The answers are
    /// in their order.
    pub(crate) fn health_of_all<'a>(
        &self,
        instances: impl Iterator<Item = (Service, &'a Instance)>,
        deadline: Instant,
    ) -> Vec<Result<v1::HealthReply, CallError>> {
        let begin = |(service, instance)| {
            let target = Target::new(None, service, Method::Health, Some(instance));
            self.begin(target, &mut v1::HealthRequest::default(), deadline)
        };
        let calls: Vec<_> = instances.map(begin).collect();
        let answers = calls.into_iter().map(|call| call?.wait());
        answers.collect()
    }

    fn insist<R: Request>(
        &self,
        target: Target,
        mut request: R,
        deadline: Instant,
    ) -> Result<R::Reply, CallError> {
        let (mut pause, mut patience) = (FIRST_PAUSE, FIRST_PATIENCE);
        let mut call = self.begin(target, &mut request, deadline)?;
        loop {
            match call.first_answer(deadline.min(Instant::now() + patience)) {
                Err(CallError::NoAnswer { .. }) if Instant::now() + pause < deadline => {
                    std::thread::sleep(pause);
                    pause = LONGEST_PAUSE.min(pause * 2);
                }
                Err(CallError::TimedOut) if Instant::now() < deadline => patience *= 2,
                result => return call.ended(result),
            }
            self.send(&mut request, &mut call)?;
        }
    }

    fn begin<R: Request>(
        &self,
        target: Target,
        request: &mut R,
        deadline: Instant,
    ) -> Result<PendingCall<R>, CallError> {
        let (sender, events) = sync_channel(KEPT_EVENTS);
        let mut call = PendingCall {
            sender,
            events,
            under_way: 0,
            request_id: String::new(),
            began: Instant::now(),
            deadline,
            span: trace::calling(target.service, target.method),
            target,
            request: PhantomData,
        };
        self.send(request, &mut call)?;
        Ok(call)
    }

    /// Sends the request of a call, maybe once more, under the same id.
    fn send<R: Request>(
        &self,
        request: &mut R,
        call: &mut PendingCall<R>,
    ) -> Result<(), CallError> {
        let time_limit = call.deadline.saturating_duration_since(Instant::now());
        if time_limit.is_zero() {
            return Err(CallError::TimedOut);
        }
        call.request_id = self.set_header(&call.target, request, time_limit);
        let labels = call.target.labels();
        let events = Events(call.sender.clone());
        self.session
            .get(call.target.key.as_str())
            .payload(request.encode_to_vec())
            .encoding(encoding_of::<R>())
            .attachment(trace::attachment(&call.span))
            // A reply is there when it comes, not when all have come.
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .priority(Priority::InteractiveHigh)
            .express(true)
            .timeout(time_limit + ZENOH_MARGIN)
            .callback(move |reply| {
                // Fails where the caller has left.
                if events.0.try_send(Event::Reply(reply)).is_err() {
                    metrics::counter(Metric::StrayRepliesTotal, &labels).increment(1);
                }
            })
            .wait()
            .map_err(|error| CallError::Zenoh(error.to_string()))?;
        call.under_way += 1;
        Ok(())
    }

    fn set_header<R: Request>(
        &self,
        target: &Target,
        request: &mut R,
        time_limit: Duration,
    ) -> String {
        let given = request.header().map(|header| header.request_id.clone());
        let request_id = given.filter(|id| !id.is_empty()).unwrap_or_else(|| {
            let number = REQUESTS.fetch_add(1, Ordering::Relaxed);
            format!("{}-{number:x}", self.session.zid())
        });
        let header = RequestHeader {
            request_id: request_id.clone(),
            time_limit,
            caller: self.caller.clone(),
            session_id: self.session_id.clone(),
            cell: target.cell.clone(),
        };
        request.set_header(header.to_message());
        request_id
    }
}

struct Target {
    cell: Option<Cell>,
    service: Service,
    method: Method,
    key: String,
}

impl Target {
    fn new(
        cell: Option<&Cell>,
        service: Service,
        method: Method,
        instance: Option<&Instance>,
    ) -> Self {
        let cell = cell.cloned();
        let key = Key::Request(cell.clone(), service, method, instance.cloned()).to_string();
        Self {
            cell,
            service,
            method,
            key,
        }
    }

    fn of<R: Request>(cell: &Cell, instance: Option<&Instance>) -> Result<Self, CallError> {
        let no_service =
            || CallError::Zenoh("a request to every service: use Client::health".to_owned());
        let service = R::SERVICE.ok_or_else(no_service)?;
        Ok(Self::new(Some(cell), service, R::METHOD, instance))
    }

    fn labels(&self) -> [(&'static str, &'static str); 2] {
        metrics::method_labels(self.service, self.method)
    }
}

enum Event {
    Reply(Reply),
    /// No more replies can come.
    Over,
}

/// Passes on the events of a request that was sent, its end by being dropped.
struct Events(SyncSender<Event>);

impl Drop for Events {
    fn drop(&mut self) {
        self.0.try_send(Event::Over).ok();
    }
}

/// A request that was sent, maybe more than once.
struct PendingCall<R: Request> {
    target: Target,
    sender: SyncSender<Event>,
    events: Receiver<Event>,
    /// The number of times it was sent that may still be answered.
    under_way: usize,
    request_id: String,
    began: Instant,
    deadline: Instant,
    /// Ends with the call.
    span: Span,
    request: PhantomData<fn() -> R>,
}

impl<R: Request> PendingCall<R> {
    /// Waits for the answer, until the deadline of the request; nothing is sent again.
    fn wait(mut self) -> Result<R::Reply, CallError> {
        let result = self.first_answer(self.deadline);
        self.ended(result)
    }

    fn ended(&self, result: Result<R::Reply, CallError>) -> Result<R::Reply, CallError> {
        let labels @ [service, method] = self.target.labels();
        let outcome = result.as_ref().err().map_or("ok", CallError::outcome);
        metrics::counter(Metric::CallsTotal, &[service, method, ("outcome", outcome)]).increment(1);
        metrics::histogram(Metric::CallSeconds, &labels).record(self.began.elapsed());
        result
    }

    fn first_answer(&mut self, until: Instant) -> Result<R::Reply, CallError> {
        loop {
            let Target {
                service, method, ..
            } = self.target;
            if self.under_way == 0 {
                return Err(CallError::NoAnswer { service, method });
            }
            let left = until.saturating_duration_since(Instant::now());
            let reply = match self.events.recv_timeout(left) {
                Ok(Event::Reply(reply)) => reply,
                Ok(Event::Over) => {
                    self.under_way -= 1;
                    continue;
                }
                // It is never disconnected, as the sender is kept.
                Err(_) => return Err(CallError::TimedOut),
            };
            match reply.into_result() {
                Ok(sample) => {
                    if let Some(result) = self.read(sample.payload()) {
                        return result;
                    }
                }
                Err(error) => {
                    tracing::debug!(error = ?error.payload(), "an error instead of a reply");
                }
            }
            metrics::counter(Metric::StrayRepliesTotal, &self.target.labels()).increment(1);
        }
    }

    /// Reads a reply; `None` where it belongs to another request.
    fn read(&self, payload: &ZBytes) -> Option<Result<R::Reply, CallError>> {
        let reply: R::Reply = match payload::read(payload, MAX_MESSAGE_BYTES) {
            Ok(reply) => reply,
            Err(error) => return Some(Err(error.into())),
        };
        let missing = |field| Err(WireError::Missing { field }.into());
        let Some(header) = reply.header() else {
            return Some(missing("header"));
        };
        let status = header.status();
        // Who cannot read a request does not know its id.
        let is_unread = status == Status::Invalid && header.request_id.is_empty();
        if header.request_id != self.request_id && !is_unread {
            return None;
        }
        Some(match status {
            Status::Ok => Ok(reply),
            Status::Unspecified => missing("header.status"),
            status => Err(CallError::Refused {
                status,
                message: header.message.clone(),
                reply: Refusal(payload.to_bytes().into_owned()),
            }),
        })
    }
}
