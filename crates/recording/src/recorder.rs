//! Recording: the streams of cells into files, until it is told to end.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ppnpack_service::ServiceError;
use ppnpack_service::clock::now_ns;
use ppnpack_service::process::thread;
use ppnpack_service::rpc::Client;
use ppnpack_service::stream::{self, Subscription};
use ppnpack_wire::keys::{Cell, Stream};
use zenoh::Session;
use zenoh::bytes::ZBytes;

use crate::error::{RecordingError, joined};
use crate::file::RecordingFile;
use crate::health::HealthThread;
use crate::queue::{Entry, Queue};
use crate::rotation::{Rotation, delete_oldest, name};
use crate::shapes::{FetcherThread, RecordInlet};
use crate::topic::Topic;

/// How often what came is put on disk: at most this is lost to a kill or a power cut.
const FLUSHED_EVERY: Duration = Duration::from_secs(1);

/// The cells and streams that are recorded, and the folder for them.
#[derive(Debug, Clone)]
pub struct RecordSettings {
    /// The folder of the files; it has to be there.
    pub folder: PathBuf,
    /// The cells and containers; all where none is named.
    pub cells: Vec<Cell>,
    /// The streams.
    pub streams: Vec<Stream>,
    /// Whether the health of the services is asked for and recorded.
    pub has_health: bool,
    /// When another file is begun, and how many are kept.
    pub rotation: Rotation,
    /// Maximum that waits to be written, in bytes; more is dropped and counted.
    pub queue_bytes: usize,
}

/// A recording under way. It ends when it is told to, or with the first error.
pub struct Recorder {
    subscriptions: Vec<Subscription>,
    records: RecordInlet,
    fetcher: FetcherThread,
    health: Option<HealthThread>,
    queue: OpenQueue,
    writer: JoinHandle<Result<Recorded, RecordingError>>,
}

struct OpenQueue(Arc<Queue>);

impl Drop for OpenQueue {
    fn drop(&mut self) {
        self.0.close();
    }
}

/// The outcome of a recording.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Recorded {
    /// The files, the oldest first; some may be deleted by now.
    pub files: Vec<PathBuf>,
    /// How many messages are in them.
    pub messages: u64,
    /// How many messages were dropped, by channel.
    pub dropped: BTreeMap<Topic, u64>,
}

impl Recorder {
    /// Begins to record.
    ///
    /// # Errors
    /// [`RecordingError`] where a file cannot be made, or the session is closed.
    pub fn start(session: &Session, settings: &RecordSettings) -> Result<Self, RecordingError> {
        let queue = Arc::new(Queue::new(settings.queue_bytes));
        let writer = Writer::begin(settings)?;
        let (records, fetcher) = FetcherThread::start(Client::new(session), &queue)?;
        let subscriptions = subscribe(session, settings, &queue, &records)?;
        let health = settings
            .has_health
            .then(|| HealthThread::start(session, &queue));
        let entries = Arc::clone(&queue);
        let writer = thread("recorder", move || {
            let recorded = writer.run(&entries);
            // Nobody takes anything out any more.
            entries.close();
            recorded
        });
        Ok(Self {
            subscriptions,
            records,
            fetcher,
            health: health.transpose()?,
            queue: OpenQueue(queue),
            writer: writer?,
        })
    }

    /// Whether it has ended by itself: [`Self::finish`] says why.
    pub fn has_ended(&self) -> bool {
        self.writer.is_finished()
    }

    /// Ends the recording with what has come so far.
    ///
    /// # Errors
    /// [`RecordingError`] where something could not be written.
    pub fn finish(self) -> Result<Recorded, RecordingError> {
        drop((self.subscriptions, self.records));
        self.health.map_or(Ok(()), HealthThread::finish)?;
        self.fetcher.finish()?;
        drop(self.queue);
        joined(self.writer)?
    }
}

/// Puts what cells publish into a queue; records go where their shapes are fetched.
fn subscribe(
    session: &Session,
    settings: &RecordSettings,
    queue: &Arc<Queue>,
    records: &RecordInlet,
) -> Result<Vec<Subscription>, ServiceError> {
    let mut subscriptions = Vec::new();
    for cell in stream::each_or_all(&settings.cells) {
        for stream in settings.streams.iter().copied() {
            let (queue, records) = (Arc::clone(queue), records.clone());
            let on_payload = move |cell: Cell, payload: ZBytes| {
                let entry = Entry::now(Topic::Stream(cell, stream), payload);
                match stream {
                    Stream::Record => records.push(entry),
                    _ => queue.push(entry),
                }
            };
            let subscription = stream::subscribe_payloads(session, cell, stream, on_payload);
            subscriptions.push(subscription?);
        }
    }
    Ok(subscriptions)
}

struct Writer {
    folder: PathBuf,
    rotation: Rotation,
    file: RecordingFile,
    number: u64,
    recorded: Recorded,
}

impl Writer {
    fn begin(settings: &RecordSettings) -> Result<Self, RecordingError> {
        let (file, number) = begin_file(&settings.folder, 1)?;
        let mut writer = Self {
            folder: settings.folder.clone(),
            rotation: settings.rotation,
            recorded: Recorded {
                files: vec![file.path.clone()],
                ..Recorded::default()
            },
            file,
            number,
        };
        writer.delete_oldest()?;
        // Its header is in the file from the beginning.
        writer.file.flush(&BTreeMap::new())?;
        Ok(writer)
    }

    fn run(mut self, queue: &Queue) -> Result<Recorded, RecordingError> {
        let mut next_flush = Instant::now() + FLUSHED_EVERY;
        while let Ok(entry) = queue.take(next_flush) {
            if let Some(entry) = entry {
                self.write(&entry, queue)?;
            }
            if Instant::now() >= next_flush {
                self.file.flush(&queue.dropped())?;
                next_flush = Instant::now() + FLUSHED_EVERY;
            }
        }
        self.recorded.dropped = queue.dropped();
        self.file.finish(&self.recorded.dropped)?;
        Ok(self.recorded)
    }

    fn write(&mut self, entry: &Entry, queue: &Queue) -> Result<(), RecordingError> {
        let age = self.rotation.age;
        let is_old = age.is_some_and(|age| self.file.begun.elapsed() >= age);
        if is_old || self.file.bytes() >= self.rotation.size_bytes {
            self.go_on_in_another_file(queue)?;
        }
        self.file.write(entry)?;
        self.recorded.messages += 1;
        Ok(())
    }

    fn go_on_in_another_file(&mut self, queue: &Queue) -> Result<(), RecordingError> {
        let (next, number) = begin_file(&self.folder, self.number + 1)?;
        self.number = number;
        self.recorded.files.push(next.path.clone());
        let full = std::mem::replace(&mut self.file, next);
        full.finish(&queue.dropped())?;
        self.delete_oldest()
    }

    fn delete_oldest(&mut self) -> Result<(), RecordingError> {
        let Some(keep) = self.rotation.keep else {
            return Ok(());
        };
        for deleted in delete_oldest(&self.folder, keep.max(1))? {
            tracing::info!(file = %deleted.display(), "an old recording is deleted");
        }
        Ok(())
    }
}

/// Begins a file of this number, or of the next free one: another recorder may write there, too.
fn begin_file(folder: &Path, first: u64) -> Result<(RecordingFile, u64), RecordingError> {
    let mut number = first;
    loop {
        match RecordingFile::begin(name(folder, now_ns(), number)) {
            Err(RecordingError::File { source, .. })
                if source.kind() == ErrorKind::AlreadyExists => {}
            begun => return Ok((begun?, number)),
        }
        number += 1;
    }
}
