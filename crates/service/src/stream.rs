//! Data of cells: published and read.
//!
//! A publisher never waits for readers: under congestion a message is dropped. A reader takes
//! messages as they come ([`subscribe`]), or the newest only ([`Latest`]). Declaring either fails
//! with [`ServiceError::Zenoh`] where the session is closed.

use std::marker::PhantomData;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Instant;

use ::metrics::Counter;
use ppnpack_wire::keys::{Cell, Key, Stream, every_cell};
use ppnpack_wire::{WireError, encoding_of};
use prost::{Message, Name};
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Subscriber;
use zenoh::qos::CongestionControl;
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use crate::clock::Boottime;
use crate::error::ServiceError;
use crate::metrics::{self, Metric};
use crate::payload::{self, Malformed};
use crate::process::Process;
use crate::sync::lock;

/// Publishes a stream of a cell.
pub struct Publisher<M> {
    publisher: zenoh::pubsub::Publisher<'static>,
    max_bytes: usize,
    published: Counter,
    message: PhantomData<fn(M)>,
}

impl<M: Message + Name> Publisher<M> {
    /// Declares a publisher of this stream.
    pub fn new(process: &Process, cell: &Cell, stream: Stream) -> Result<Self, ServiceError> {
        let key = Key::Stream(cell.clone(), stream).to_string();
        let publisher = process
            .session()
            .declare_publisher(key.clone())
            .encoding(encoding_of::<M>())
            .congestion_control(CongestionControl::Drop)
            .express(true)
            .wait()
            .map_err(|error| ServiceError::zenoh(format!("declaring {key}"), &error))?;
        Ok(Self {
            publisher,
            max_bytes: process.max_message_bytes(),
            published: metrics::counter(Metric::PublishedTotal, &[("stream", stream.as_str())]),
            message: PhantomData,
        })
    }

    /// Says whether somebody subscribes to the stream, as far as this session has heard.
    pub fn has_readers(&self) -> bool {
        let status = self.publisher.matching_status().wait();
        status.is_ok_and(|status| status.matching())
    }

    /// Publishes a message.
    ///
    /// # Errors
    /// [`ServiceError::Zenoh`] where the session is closed, or nobody would take so large a
    /// message.
    pub fn put(&self, message: &M) -> Result<(), ServiceError> {
        let (bytes, most) = (message.encoded_len(), self.max_bytes);
        if bytes > most {
            return Err(ServiceError::Zenoh {
                action: "publishing".to_owned(),
                reason: format!(
                    "{bytes} bytes are more than zenoh.max_message_bytes, {most}: raise it for \
                     this process, the router and all who read it"
                ),
            });
        }
        let put = self.publisher.put(message.encode_to_vec()).wait();
        put.map_err(|error| ServiceError::zenoh("publishing", &error))?;
        self.published.increment(1);
        Ok(())
    }
}

/// A message of a stream with its time of arrival, however much later it is looked at.
#[derive(Debug)]
pub struct Arrived<T> {
    /// The time at which it came to this process.
    pub at: Boottime,
    /// The message, as it came or as far as it was read.
    pub message: T,
}

impl<T> Arrived<T> {
    /// Makes a message that comes now.
    pub fn now(message: T) -> Self {
        let at = Boottime::now();
        Self { at, message }
    }

    /// Reads the message further.
    pub fn map<U>(self, read: impl FnOnce(T) -> U) -> Arrived<U> {
        let (at, message) = (self.at, read(self.message));
        Arrived { at, message }
    }
}

impl<T, E> Arrived<Result<T, E>> {
    /// Gives the message, or the error of reading it.
    ///
    /// # Errors
    /// That of the message.
    pub fn transpose(self) -> Result<Arrived<T>, E> {
        let (at, message) = (self.at, self.message?);
        Ok(Arrived { at, message })
    }
}

/// The newest message of a stream of a cell. Older ones are dropped unread; the reader decodes.
pub struct Latest<M> {
    slot: Arc<Slot>,
    limit_bytes: usize,
    malformed: Malformed,
    _subscriber: Subscriber<()>,
    message: PhantomData<fn() -> M>,
}

#[derive(Default)]
struct Slot {
    newest: Mutex<Option<Arrived<ZBytes>>>,
    arrived: Condvar,
}

impl<M: Message + Name + Default> Latest<M> {
    /// Subscribes a stream, of messages of at most `limit_bytes`.
    pub fn subscribe(
        process: &Process,
        cell: &Cell,
        stream: Stream,
        limit_bytes: usize,
    ) -> Result<Self, ServiceError> {
        let slot = Arc::new(Slot::default());
        let labels @ [of_stream, _] = [("stream", stream.as_str()), ("cell", cell.as_str())];
        let received = metrics::counter(Metric::ReceivedTotal, &labels);
        let overwritten = metrics::counter(Metric::OverwrittenTotal, &[of_stream]);
        let callback = {
            let slot = slot.clone();
            move |sample: Sample| {
                received.increment(1);
                let newest = Arrived::now(sample.payload().clone());
                let older = lock(&slot.newest).replace(newest);
                slot.arrived.notify_one();
                if older.is_some() {
                    overwritten.increment(1);
                }
            }
        };
        let key = Key::Stream(cell.clone(), stream).to_string();
        Ok(Self {
            _subscriber: declare(process.session(), &key, callback)?,
            slot,
            limit_bytes,
            malformed: Malformed::new(stream.to_string()),
            message: PhantomData,
        })
    }

    /// Takes the newest message, if it was not taken yet.
    pub fn take(&self) -> Option<Arrived<Result<M, WireError>>> {
        self.wait(Instant::now())
    }

    /// Waits for a message that was not taken yet; `None` where none comes before the deadline.
    pub fn wait(&self, deadline: Instant) -> Option<Arrived<Result<M, WireError>>> {
        let left = deadline.saturating_duration_since(Instant::now());
        let newest = lock(&self.slot.newest);
        let arrived = &self.slot.arrived;
        let waited = arrived.wait_timeout_while(newest, left, |newest| newest.is_none());
        let newest = waited.unwrap_or_else(PoisonError::into_inner).0.take();
        let read = |payload: ZBytes| {
            let read = payload::read(&payload, self.limit_bytes);
            read.inspect_err(|error| self.malformed.count(error))
        };
        newest.map(|newest| newest.map(read))
    }
}

/// Gives each of these cells, or `None`, which is all, where none is named.
pub fn each_or_all(cells: &[Cell]) -> impl Iterator<Item = Option<&Cell>> {
    let all = cells.is_empty().then_some(None);
    cells.iter().map(Some).chain(all)
}

/// A subscription, until it is dropped.
pub type Subscription = Subscriber<()>;

/// Calls `on_message` with every message of a stream of a cell, or of all. It runs on Zenoh's
/// thread: it must only hand the message over, to something with a bound. Malformed messages are
/// counted, and logged at most once a second.
pub fn subscribe<M: Message + Name + Default + 'static>(
    session: &Session,
    cell: Option<&Cell>,
    stream: Stream,
    limit_bytes: usize,
    on_message: impl Fn(Cell, M) + Send + Sync + 'static,
) -> Result<Subscription, ServiceError> {
    let on_unread = move |cell: Cell, unread: Unread<'_, M>| {
        if let Some(message) = unread.read() {
            on_message(cell, message);
        }
    };
    subscribe_unread(session, cell, stream, limit_bytes, on_unread)
}

/// A message of a stream as it came: no memory was taken for it yet.
pub struct Unread<'a, M> {
    payload: &'a ZBytes,
    limit_bytes: usize,
    malformed: &'a Malformed,
    message: PhantomData<fn() -> M>,
}

impl<M: Message + Name + Default> Unread<'_, M> {
    /// Gives its size as it is encoded.
    pub fn bytes(&self) -> usize {
        self.payload.len()
    }

    /// Reads the message; `None` where it is too large or malformed, which is counted.
    pub fn read(self) -> Option<M> {
        let read = payload::read(self.payload, self.limit_bytes);
        read.inspect_err(|error| self.malformed.count(error)).ok()
    }
}

/// Subscribes as [`subscribe`] does, for callers that look at a message's size before they read it.
pub fn subscribe_unread<M: Message + Name + Default + 'static>(
    session: &Session,
    cell: Option<&Cell>,
    stream: Stream,
    limit_bytes: usize,
    on_message: impl Fn(Cell, Unread<'_, M>) + Send + Sync + 'static,
) -> Result<Subscription, ServiceError> {
    let malformed = Malformed::new(stream.to_string());
    subscribe_payloads(session, cell, stream, move |cell, payload| {
        let unread = Unread {
            payload: &payload,
            limit_bytes,
            malformed: &malformed,
            message: PhantomData,
        };
        on_message(cell, unread);
    })
}

/// Subscribes as [`subscribe`] does, for callers that pass messages on as they are encoded: nobody
/// has looked at them.
pub fn subscribe_payloads(
    session: &Session,
    cell: Option<&Cell>,
    stream: Stream,
    on_payload: impl Fn(Cell, ZBytes) + Send + Sync + 'static,
) -> Result<Subscription, ServiceError> {
    let received = metrics::counter(Metric::ReceivedTotal, &[("stream", stream.as_str())]);
    let malformed = Malformed::new(stream.to_string());
    let callback = move |sample: Sample| {
        received.increment(1);
        match Key::parse(sample.key_expr().as_str()) {
            Ok(Key::Stream(cell, _)) => on_payload(cell, sample.payload().clone()),
            Ok(_) => {}
            Err(error) => malformed.count(&error),
        }
    };
    let key = match cell {
        Some(cell) => Key::Stream(cell.clone(), stream).to_string(),
        None => every_cell(stream),
    };
    declare(session, &key, callback)
}

fn declare(
    session: &Session,
    key: &str,
    callback: impl Fn(Sample) + Send + Sync + 'static,
) -> Result<Subscriber<()>, ServiceError> {
    session
        .declare_subscriber(key.to_owned())
        .callback(callback)
        .wait()
        .map_err(|error| ServiceError::zenoh(format!("subscribing {key}"), &error))
}
