//! One file of a recording, as it is written.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};
use zenoh::bytes::ZBytes;

use crate::error::RecordingError;
use crate::queue::Entry;
use crate::topic::Topic;

/// How much a chunk holds before it is written, in bytes. Every flush writes one, too.
const CHUNK_BYTES: u64 = 4 << 20;

/// What the messages of all channels are encoded in, and their schemas.
pub(crate) const PROTOBUF: &str = "protobuf";

/// The name of the metadata that says how many messages were dropped so far, by channel.
pub(crate) const DROPPED: &str = "dropped";

/// A file that is written. What was flushed can be read, whatever becomes of the process.
pub(crate) struct RecordingFile {
    path: PathBuf,
    writer: Writer<Counted>,
    /// The same file, to have what was written on disk.
    disk: File,
    bytes: Arc<AtomicU64>,
    channels: HashMap<Topic, Channel>,
    /// The schemas that are in it, by the names of the messages.
    schemas: HashMap<String, u16>,
    /// The ids of shapes that are in it.
    shapes: HashSet<Vec<u8>>,
    begun: Instant,
    /// As it was last written.
    dropped: BTreeMap<Topic, u64>,
}

struct Channel {
    id: u16,
    sequence: u32,
}

/// A file, and how much was written to it.
struct Counted {
    file: BufWriter<File>,
    bytes: Arc<AtomicU64>,
}

impl RecordingFile {
    /// Begins a file, which must not be there yet.
    pub(crate) fn begin(path: PathBuf) -> Result<Self, RecordingError> {
        let failed_to_make = |source| RecordingError::File {
            path: path.clone(),
            action: "made",
            source,
        };
        let file = File::create_new(&path).map_err(failed_to_make)?;
        let disk = file.try_clone().map_err(failed_to_make)?;
        sync_name(&path).map_err(failed_to_make)?;
        let options = WriteOptions::new()
            .profile("ppnpack")
            .library(concat!("ppnpack ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            // The recorder has a thread; it shall not take all cores from the planner.
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            // A chunk is in the file when it is complete, and never changed again.
            .disable_seeking(true);
        let bytes = Arc::new(AtomicU64::new(0));
        let counted = Counted {
            file: BufWriter::new(file),
            bytes: Arc::clone(&bytes),
        };
        let writer = options.create(counted);
        Ok(Self {
            writer: writer.map_err(|error| failed(&path, &error))?,
            path,
            disk,
            bytes,
            channels: HashMap::new(),
            schemas: HashMap::new(),
            shapes: HashSet::new(),
            begun: Instant::now(),
            dropped: BTreeMap::new(),
        })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// When it was begun.
    pub(crate) fn begun(&self) -> Instant {
        self.begun
    }

    /// How much was flushed.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Writes a message, and before it the shapes that it names and that are not in the file yet.
    pub(crate) fn write(&mut self, entry: &Entry) -> Result<(), RecordingError> {
        let Entry { sample, shapes } = entry;
        if let Some(cell) = sample.topic.cell() {
            let topic = Topic::Shape(cell.clone());
            for shape in shapes {
                if self.shapes.insert(shape.id.clone()) {
                    self.write_to(&topic, sample.at_ns, &shape.payload)?;
                }
            }
        }
        self.write_to(&sample.topic, sample.at_ns, &sample.payload)
    }

    fn write_to(
        &mut self,
        topic: &Topic,
        at_ns: u64,
        payload: &ZBytes,
    ) -> Result<(), RecordingError> {
        let header = self.header(topic, at_ns)?;
        let written = self
            .writer
            .write_to_known_channel(&header, &payload.to_bytes());
        written.map_err(|error| failed(&self.path, &error))
    }

    /// The header of a channel's next message.
    fn header(&mut self, topic: &Topic, at_ns: u64) -> Result<MessageHeader, RecordingError> {
        if !self.channels.contains_key(topic) {
            let id = self.add_channel(topic)?;
            self.channels
                .insert(topic.clone(), Channel { id, sequence: 0 });
        }
        let mut header = MessageHeader {
            channel_id: 0,
            sequence: 0,
            log_time: at_ns,
            publish_time: at_ns,
        };
        if let Some(channel) = self.channels.get_mut(topic) {
            (header.channel_id, header.sequence) = (channel.id, channel.sequence);
            channel.sequence = channel.sequence.wrapping_add(1);
        }
        Ok(header)
    }

    fn add_channel(&mut self, topic: &Topic) -> Result<u16, RecordingError> {
        let path = self.path.clone();
        let schema = topic.schema();
        let schema = schema.map_err(|error| RecordingError::Message(error.to_string()))?;
        let schema_id = match self.schemas.get(&schema.name) {
            Some(id) => *id,
            None => {
                let added = self
                    .writer
                    .add_schema(&schema.name, PROTOBUF, &schema.descriptors);
                let id = added.map_err(|error| failed(&path, &error))?;
                self.schemas.insert(schema.name, id);
                id
            }
        };
        let name = topic.to_string();
        let added = self
            .writer
            .add_channel(schema_id, &name, PROTOBUF, &BTreeMap::new());
        added.map_err(|error| failed(&path, &error))
    }

    /// Has everything that was written on disk.
    pub(crate) fn flush(&mut self, dropped: &BTreeMap<Topic, u64>) -> Result<(), RecordingError> {
        self.write_dropped(dropped)?;
        let flushed = self.writer.flush();
        flushed.map_err(|error| failed(&self.path, &error))?;
        let synced = self.disk.sync_data();
        synced.map_err(|source| failed_to_write(&self.path, source))
    }

    fn write_dropped(&mut self, dropped: &BTreeMap<Topic, u64>) -> Result<(), RecordingError> {
        if *dropped == self.dropped {
            return Ok(());
        }
        self.dropped = dropped.clone();
        let counts = dropped.iter();
        let counts = counts.map(|(topic, count)| (topic.to_string(), count.to_string()));
        let metadata = Metadata {
            name: DROPPED.to_owned(),
            metadata: counts.collect(),
        };
        let written = self.writer.write_metadata(&metadata);
        written.map_err(|error| failed(&self.path, &error))
    }

    /// Ends the file whole, and has it on disk.
    pub(crate) fn finish(
        mut self,
        dropped: &BTreeMap<Topic, u64>,
    ) -> Result<PathBuf, RecordingError> {
        self.write_dropped(dropped)?;
        let finished = self.writer.finish();
        finished.map_err(|error| failed(&self.path, &error))?;
        let flushed = self.writer.into_inner().file.into_inner();
        let flushed = flushed.map_err(std::io::IntoInnerError::into_error);
        let synced = flushed.and_then(|file| file.sync_all());
        synced.map_err(|source| failed_to_write(&self.path, source))?;
        Ok(self.path)
    }
}

/// Has the name of a file on disk.
fn sync_name(path: &Path) -> std::io::Result<()> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => File::open(folder)?.sync_all(),
        _ => File::open(".")?.sync_all(),
    }
}

fn failed_to_write(path: &Path, source: std::io::Error) -> RecordingError {
    RecordingError::File {
        path: path.to_owned(),
        action: "written",
        source,
    }
}

fn failed(path: &Path, error: &mcap::McapError) -> RecordingError {
    let reason = match error {
        mcap::McapError::Io(error) => error.to_string(),
        error => error.to_string(),
    };
    let path = path.to_owned();
    RecordingError::Write { path, reason }
}

impl Write for Counted {
    fn write(&mut self, buffer: &[u8]) -> std::io::Result<usize> {
        let written = self.file.write(buffer)?;
        self.bytes.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Counted {
    fn seek(&mut self, position: std::io::SeekFrom) -> std::io::Result<u64> {
        self.file.seek(position)
    }

    /// Nothing is written but at the end.
    fn stream_position(&mut self) -> std::io::Result<u64> {
        Ok(self.bytes.load(Ordering::Relaxed))
    }
}
