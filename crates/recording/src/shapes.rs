//! The items and solids that records name, fetched from the planner that published them.

use std::collections::{BTreeSet, HashMap};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ppnpack_service::process::thread;
use ppnpack_service::rpc::Client;
use ppnpack_service::{ServiceError, shapes};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{MAX_MESSAGE_BYTES, decode, v1};
use prost::Message;
use zenoh::bytes::ZBytes;

use crate::error::{RecordingError, joined};
use crate::queue::{Entry, NamedShape, Queue};

/// Maximum of records that wait for their shapes; more are dropped.
const MOST_WAITING: usize = 64;

/// How long a planner may take to answer: it plans a step before.
const PATIENCE: Duration = Duration::from_secs(10);

/// How long the planners may take altogether once the recording ends.
const LAST_PATIENCE: Duration = Duration::from_secs(2);

/// Maximum that is kept before all is forgotten and fetched anew, in bytes.
const MOST_KEPT_BYTES: usize = 256 << 20;

/// The way in for records. Cheap to clone.
#[derive(Clone)]
pub(crate) struct RecordInlet {
    waiting: SyncSender<Entry>,
    queue: Arc<Queue>,
}

impl RecordInlet {
    /// Adds a record, or drops it where too many wait.
    pub(crate) fn push(&self, record: Entry) {
        match self.waiting.try_send(record) {
            Ok(()) => {}
            Err(TrySendError::Full(record) | TrySendError::Disconnected(record)) => {
                self.queue.count_dropped(record.topic);
            }
        }
    }
}

/// The thread that fetches shapes. It ends when the inlet and its clones are gone.
pub(crate) struct FetcherThread {
    thread: JoinHandle<()>,
    ends_at: Arc<OnceLock<Instant>>,
}

impl FetcherThread {
    /// Starts to fetch shapes, and puts each record with them into the queue.
    pub(crate) fn start(
        client: Client,
        queue: &Arc<Queue>,
    ) -> Result<(RecordInlet, Self), ServiceError> {
        let (waiting, records) = sync_channel(MOST_WAITING);
        let ends_at = Arc::new(OnceLock::new());
        let fetcher = Fetcher {
            client,
            ends_at: Arc::clone(&ends_at),
            kept: HashMap::new(),
            kept_bytes: 0,
        };
        let inlet = RecordInlet {
            waiting,
            queue: Arc::clone(queue),
        };
        let queue = Arc::clone(queue);
        let thread = thread("shapes", move || fetcher.run(&records, &queue))?;
        Ok((inlet, Self { thread, ends_at }))
    }

    /// Waits for its end; nothing is asked for any more after a while.
    pub(crate) fn finish(self) -> Result<(), RecordingError> {
        self.ends_at.get_or_init(|| Instant::now() + LAST_PATIENCE);
        joined(self.thread)
    }
}

struct Fetcher {
    client: Client,
    /// The time after which nothing is waited for, once the recording ends.
    ends_at: Arc<OnceLock<Instant>>,
    kept: HashMap<Vec<u8>, ZBytes>,
    kept_bytes: usize,
}

impl Fetcher {
    fn run(mut self, records: &Receiver<Entry>, queue: &Queue) {
        while let Ok(mut entry) = records.recv() {
            entry.shapes = self.shapes_of(&entry);
            queue.push(entry);
        }
    }

    /// Gives the shapes that a record names, as far as they can be had.
    fn shapes_of(&mut self, entry: &Entry) -> Vec<NamedShape> {
        let record = decode(&entry.payload.to_bytes(), MAX_MESSAGE_BYTES);
        let record: v1::PlanningRecord = match record {
            Ok(record) => record,
            Err(error) => {
                tracing::warn!(topic = %entry.topic, %error, "a record cannot be read");
                return Vec::new();
            }
        };
        if self.kept_bytes > MOST_KEPT_BYTES {
            self.kept.clear();
            self.kept_bytes = 0;
        }
        let ids = shapes::named(&record);
        let cell = entry.topic.cell();
        if let Some(Err(error)) = cell.map(|cell| self.fetch(cell, &ids)) {
            tracing::warn!(topic = %entry.topic, error, "a step is recorded without all of its shapes");
        }
        let known = ids.into_iter().filter_map(|id| {
            let payload = self.kept.get(&id)?.clone();
            Some((id, payload))
        });
        known.collect()
    }

    /// Fetches those of the shapes that are not kept yet.
    fn fetch(&mut self, cell: &Cell, ids: &BTreeSet<Vec<u8>>) -> Result<(), String> {
        let patience = Instant::now() + PATIENCE;
        let ends_at = self.ends_at.get();
        let deadline = ends_at.map_or(patience, |end| patience.min(*end));
        let missing = ids.iter().filter(|id| !self.kept.contains_key(*id));
        let missing: Vec<Vec<u8>> = missing.cloned().collect();
        let (kept, kept_bytes) = (&mut self.kept, &mut self.kept_bytes);
        let lacking = shapes::fetch(&self.client, cell, missing, deadline, |shape| {
            let payload = ZBytes::from(shape.encode_to_vec());
            *kept_bytes += payload.len();
            kept.insert(shape.id, payload);
        });
        match lacking.map_err(|error| error.to_string())? {
            0 => Ok(()),
            lacking => Err(format!("{lacking} of them are not known any more")),
        }
    }
}
