//! One file of a recording, as it is written.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::File;
use std::io::{BufWriter, Error, IntoInnerError};
use std::path::{Path, PathBuf};
use std::time::Instant;

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions, Writer};
use zenoh::bytes::ZBytes;

use crate::error::RecordingError;
use crate::queue::Entry;
use crate::topic::Topic;

/// Maximum size of a chunk before it is written, in bytes. Every flush writes one, too.
const CHUNK_BYTES: u64 = 4 << 20;

/// The encoding of all messages and their schemas.
const PROTOBUF: &str = "protobuf";

/// The name of the metadata that says how many messages were dropped so far, by channel.
pub(crate) const DROPPED: &str = "dropped";

/// A file that is written. All that was flushed can be read, whatever becomes of the process.
pub(crate) struct RecordingFile {
    pub(crate) path: PathBuf,
    writer: Writer<NoSeek<BufWriter<File>>>,
    /// The same file, to have what was written on disk.
    disk: File,
    /// The headers of the channels' next messages, but for the time.
    channels: HashMap<Topic, MessageHeader>,
    shapes: HashSet<Vec<u8>>,
    pub(crate) begun: Instant,
    /// The counts of dropped messages that were written last.
    dropped: BTreeMap<Topic, u64>,
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
        let writer = options.create(NoSeek::new(BufWriter::new(file)));
        Ok(Self {
            writer: writer.map_err(|error| failed(&path, error))?,
            path,
            disk,
            channels: HashMap::new(),
            shapes: HashSet::new(),
            begun: Instant::now(),
            dropped: BTreeMap::new(),
        })
    }

    /// How many bytes are in it; what was not flushed is not.
    pub(crate) fn bytes(&self) -> u64 {
        self.disk.metadata().map_or(0, |metadata| metadata.len())
    }

    /// Writes a message, and before it the shapes that it names and that are not in the file yet.
    pub(crate) fn write(&mut self, entry: &Entry) -> Result<(), RecordingError> {
        if let Some(cell) = entry.topic.cell() {
            let topic = Topic::Shape(cell.clone());
            for (id, payload) in &entry.shapes {
                if self.shapes.insert(id.clone()) {
                    self.write_to(&topic, entry.at_ns, payload)?;
                }
            }
        }
        self.write_to(&entry.topic, entry.at_ns, &entry.payload)
    }

    fn write_to(
        &mut self,
        topic: &Topic,
        at_ns: u64,
        payload: &ZBytes,
    ) -> Result<(), RecordingError> {
        let next = match self.channels.get_mut(topic) {
            Some(next) => next,
            None => {
                let channel = self.add_channel(topic)?;
                self.channels.entry(topic.clone()).or_insert(channel)
            }
        };
        let header = MessageHeader {
            log_time: at_ns,
            publish_time: at_ns,
            ..*next
        };
        next.sequence = next.sequence.wrapping_add(1);
        let payload = payload.to_bytes();
        let written = self.writer.write_to_known_channel(&header, &payload);
        written.map_err(|error| failed(&self.path, error))
    }

    /// Adds a channel; gives the header of its first message.
    fn add_channel(&mut self, topic: &Topic) -> Result<MessageHeader, RecordingError> {
        let schema = topic.schema();
        let schema = schema.map_err(|error| RecordingError::Message(error.to_string()))?;
        let (writer, name) = (&mut self.writer, topic.to_string());
        let channel_id = writer
            .add_schema(&schema.name, PROTOBUF, &schema.descriptors)
            .and_then(|schema| writer.add_channel(schema, &name, PROTOBUF, &BTreeMap::new()))
            .map_err(|error| failed(&self.path, error))?;
        Ok(MessageHeader {
            channel_id,
            sequence: 0,
            log_time: 0,
            publish_time: 0,
        })
    }

    /// Puts everything that was written on disk.
    pub(crate) fn flush(&mut self, dropped: &BTreeMap<Topic, u64>) -> Result<(), RecordingError> {
        self.write_dropped(dropped)?;
        let flushed = self.writer.flush();
        flushed.map_err(|error| failed(&self.path, error))?;
        let synced = self.disk.sync_data();
        synced.map_err(|error| failed(&self.path, error.into()))
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
        written.map_err(|error| failed(&self.path, error))
    }

    /// Ends the file whole, and puts it on disk.
    pub(crate) fn finish(
        mut self,
        dropped: &BTreeMap<Topic, u64>,
    ) -> Result<PathBuf, RecordingError> {
        self.write_dropped(dropped)?;
        let finished = self.writer.finish();
        finished.map_err(|error| failed(&self.path, error))?;
        let flushed = self.writer.into_inner().into_inner().into_inner();
        let flushed = flushed.map_err(IntoInnerError::into_error);
        let synced = flushed.and_then(|file| file.sync_all());
        synced.map_err(|error| failed(&self.path, error.into()))?;
        Ok(self.path)
    }
}

fn sync_name(path: &Path) -> std::io::Result<()> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => File::open(folder)?.sync_all(),
        _ => File::open(".")?.sync_all(),
    }
}

fn failed(path: &Path, error: McapError) -> RecordingError {
    RecordingError::File {
        path: path.to_owned(),
        action: "written",
        source: match error {
            McapError::Io(error) => error,
            error => Error::other(error.to_string()),
        },
    }
}
