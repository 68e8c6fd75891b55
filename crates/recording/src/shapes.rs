//! The items and solids that records name, fetched from the planner that published them.

use std::collections::{BTreeSet, HashMap};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ppnpack_service::process::thread;
use ppnpack_service::rpc::Client;
use ppnpack_service::shapes;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{MAX_MESSAGE_BYTES, decode, v1};
use prost::Message;
use zenoh::bytes::ZBytes;

use crate::error::{RecordingError, joined};
use crate::queue::{Entry, NamedShape, Queue, Sample};

/// Records that wait for their shapes at most; more are dropped.
const MOST_WAITING: usize = 64;

/// How long a planner may take to answer: it plans a step before.
const PATIENCE: Duration = Duration::from_secs(10);

/// How long the planners may take altogether once the recording ends.
const LAST_PATIENCE: Duration = Duration::from_secs(2);

/// How much is kept before all is forgotten and fetched anew, in bytes.
const MOST_KEPT_BYTES: usize = 256 << 20;

/// Where records are put. Cheap to clone.
#[derive(Clone)]
pub(crate) struct RecordInlet {
    waiting: SyncSender<Sample>,
    queue: Arc<Queue>,
}

/// The thread that fetches shapes. It ends when the inlet and its clones are gone.
pub(crate) struct FetcherThread {
    thread: JoinHandle<()>,
    ends_at: Arc<OnceLock<Instant>>,
}

impl FetcherThread {
    /// Waits for its end; nothing is asked for any more after a while.
    pub(crate) fn finish(self) -> Result<(), RecordingError> {
        self.ends_at.get_or_init(|| Instant::now() + LAST_PATIENCE);
        joined(self.thread)
    }
}

impl RecordInlet {
    /// Adds a record, or drops it where too many wait.
    pub(crate) fn push(&self, sample: Sample) {
        let topic = sample.topic.clone();
        if self.waiting.try_send(sample).is_err() {
            self.queue.count_dropped(&topic);
        }
    }
}

/// Starts the thread that fetches shapes, and puts each record with them into the queue.
pub(crate) fn start(
    client: Client,
    queue: &Arc<Queue>,
) -> Result<(RecordInlet, FetcherThread), RecordingError> {
    let (waiting, records) = sync_channel(MOST_WAITING);
    let inlet = RecordInlet {
        waiting,
        queue: Arc::clone(queue),
    };
    let ends_at = Arc::new(OnceLock::new());
    let fetcher = Fetcher {
        client,
        ends_at: Arc::clone(&ends_at),
        kept: HashMap::new(),
        kept_bytes: 0,
    };
    let queue = Arc::clone(queue);
    let thread = thread("shapes", move || fetcher.run(&records, &queue))?;
    Ok((inlet, FetcherThread { thread, ends_at }))
}

struct Fetcher {
    client: Client,
    /// Where the recording ends: nothing is waited for after that.
    ends_at: Arc<OnceLock<Instant>>,
    /// Encoded shapes by their ids.
    kept: HashMap<Vec<u8>, ZBytes>,
    kept_bytes: usize,
}

impl Fetcher {
    fn run(mut self, records: &Receiver<Sample>, queue: &Queue) {
        while let Ok(sample) = records.recv() {
            let shapes = self.shapes_of(&sample);
            queue.push(Entry { sample, shapes });
        }
    }

    /// The shapes that a record names, as far as they can be had.
    fn shapes_of(&mut self, sample: &Sample) -> Vec<NamedShape> {
        let record = decode(&sample.payload.to_bytes(), MAX_MESSAGE_BYTES);
        let record: v1::PlanningRecord = match record {
            Ok(record) => record,
            Err(error) => {
                tracing::warn!(topic = %sample.topic, %error, "a record cannot be read");
                return Vec::new();
            }
        };
        if self.kept_bytes > MOST_KEPT_BYTES {
            self.kept.clear();
            self.kept_bytes = 0;
        }
        let ids = shapes::named(&record);
        let cell = sample.topic.cell();
        if let Some(Err(error)) = cell.map(|cell| self.fetch(cell, &ids)) {
            tracing::warn!(topic = %sample.topic, error, "a step is recorded without all of its shapes");
        }
        let known = ids.into_iter().filter_map(|id| {
            let payload = self.kept.get(&id)?.clone();
            Some(NamedShape { id, payload })
        });
        known.collect()
    }

    /// Fetches those of the shapes that are not kept yet.
    fn fetch(&mut self, cell: &Cell, ids: &BTreeSet<Vec<u8>>) -> Result<(), String> {
        let patience = Instant::now() + PATIENCE;
        let deadline = self
            .ends_at
            .get()
            .map_or(patience, |end| patience.min(*end));
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
