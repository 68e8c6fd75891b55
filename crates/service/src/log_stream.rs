//! What a process logs, on the wire: for viewers and recorders, while one of them reads it.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use ppnpack_wire::debug::{self, Log, LogLevel};
use ppnpack_wire::encoding_of;
use ppnpack_wire::keys::{Instance, Key, every_log};
use prost::Message;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::Context;
use tracing_subscriber::registry::LookupSpan;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use crate::clock::now_ns;
use crate::error::ServiceError;
use crate::process::thread;
use crate::stream::{self, Subscription};
use crate::sync::lock;

/// Lines that wait to be published at most; more are left out.
const MOST_WAITING: usize = 256;

/// The longest line, in characters.
const MOST_CHARACTERS: usize = 4096;

/// Where the lines of this process go. It is one for the whole process, as what takes the events is.
static OUTLET: Mutex<Option<Outlet>> = Mutex::new(None);

struct Outlet {
    process: Instance,
    is_read: Arc<AtomicBool>,
    waiting: SyncSender<Log>,
}

impl Outlet {
    /// Whose lines they are and where they go, while somebody reads them.
    fn while_read(&self) -> Option<(Instance, SyncSender<Log>)> {
        let is_read = self.is_read.load(Ordering::Relaxed);
        is_read.then(|| (self.process.clone(), self.waiting.clone()))
    }
}

/// Publishes what the process logs, until it is dropped.
pub struct LogStream {
    thread: Option<JoinHandle<()>>,
}

/// Publishes what this operating-system process logs under this name, where [`layer`] takes the events.
///
/// # Errors
/// [`ServiceError`] where the session is closed, or the process publishes its log already.
pub fn publish(session: &Session, process: &Instance) -> Result<LogStream, ServiceError> {
    let key = Key::Log(process.clone()).to_string();
    let failed = |error: zenoh::Error| ServiceError::zenoh(format!("declaring {key}"), &error);
    let publisher = session
        .declare_publisher(key.clone())
        .encoding(encoding_of::<Log>())
        .congestion_control(CongestionControl::Drop)
        .wait()
        .map_err(failed)?;
    let is_read = Arc::new(AtomicBool::default());
    let told = Arc::clone(&is_read);
    publisher
        .matching_listener()
        .callback(move |status| told.store(status.matching(), Ordering::Relaxed))
        .background()
        .wait()
        .map_err(failed)?;
    let (waiting, lines) = sync_channel(MOST_WAITING);
    let mut published = lock(&OUTLET);
    if published.is_some() {
        return Err(ServiceError::start("the log is published already"));
    }
    let thread = thread("log", move || put(&publisher, &lines))?;
    *published = Some(Outlet {
        process: process.clone(),
        is_read,
        waiting,
    });
    Ok(LogStream {
        thread: Some(thread),
    })
}

/// Publishes lines until none can come any more.
fn put(publisher: &Publisher<'_>, lines: &Receiver<Log>) {
    for line in lines {
        // Said nowhere: it would be a line of the log.
        if publisher.put(line.encode_to_vec()).wait().is_err() {
            return;
        }
    }
}

/// Calls `on_line` with every line, encoded, that a process publishes. It runs on Zenoh's thread: it must only hand the line over, to
/// something with a bound.
///
/// # Errors
/// [`ServiceError::Zenoh`] where the session is closed.
pub fn subscribe(
    session: &Session,
    on_line: impl Fn(ZBytes) + Send + Sync + 'static,
) -> Result<Subscription, ServiceError> {
    let on_sample = move |sample: Sample| on_line(sample.payload().clone());
    stream::declare(session, &every_log(), on_sample)
}

impl Drop for LogStream {
    fn drop(&mut self) {
        *lock(&OUTLET) = None;
        if let Some(thread) = self.thread.take() {
            // A panic was logged when it happened.
            thread.join().ok();
        }
    }
}

/// Takes the events of this project from level `INFO` on, and those of others from `WARN` on, whatever is written to standard error. Those
/// of Zenoh are left out: publishing makes some.
pub fn layer<S>() -> Box<dyn Layer<S> + Send + Sync>
where
    S: Subscriber + for<'span> LookupSpan<'span>,
{
    let filter = Targets::new()
        .with_default(LevelFilter::WARN)
        .with_target("ppnpack", LevelFilter::INFO)
        .with_target("zenoh", LevelFilter::OFF);
    LogLayer.with_filter(filter).boxed()
}

struct LogLayer;

impl<S: Subscriber> Layer<S> for LogLayer {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        // Not locked while the line is made: what an event shows of itself may log, too, and other threads would wait.
        let outlet = lock(&OUTLET).as_ref().and_then(Outlet::while_read);
        if let Some((process, waiting)) = outlet {
            // Where there is no room, the line is still on standard error.
            waiting.try_send(line(&process, event)).ok();
        }
    }
}

/// An event as a line.
fn line(process: &Instance, event: &Event<'_>) -> Log {
    let at_ns = i64::try_from(now_ns()).unwrap_or(i64::MAX);
    let metadata = event.metadata();
    let level = match *metadata.level() {
        Level::ERROR => LogLevel::Error,
        Level::WARN => LogLevel::Warning,
        Level::INFO => LogLevel::Info,
        _ => LogLevel::Debug,
    };
    let mut text = Text::default();
    event.record(&mut text);
    let file = metadata.file().unwrap_or(metadata.target());
    let line = metadata.line().unwrap_or_default();
    debug::log(at_ns, level, text.joined(), process.as_str(), (file, line))
}

/// What an event says: its message, and its fields behind that.
#[derive(Default)]
struct Text {
    message: String,
    fields: Vec<String>,
}

impl Text {
    fn joined(self) -> String {
        let parts = std::iter::once(self.message).chain(self.fields);
        let parts: Vec<String> = parts.filter(|part| !part.is_empty()).collect();
        parts.join(" ").chars().take(MOST_CHARACTERS).collect()
    }

    fn add(&mut self, field: &Field, value: String) {
        match field.name() {
            "message" => self.message = value,
            name => self.fields.push(format!("{name}={value}")),
        }
    }
}

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        self.add(field, format!("{value:?}"));
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        self.add(field, value.to_owned());
    }
}
