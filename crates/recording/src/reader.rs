//! Reading a recording from its beginning, also one whose recorder was killed.

use std::collections::{HashMap, VecDeque};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};

use crate::error::RecordingError;
use crate::file::DROPPED;

/// Maximum size of a record, in bytes: a larger one is no recorder's.
const MOST_RECORD_BYTES: usize = 512 << 20;

/// A message of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedMessage {
    /// The channel, such as `/cell-1/plan`.
    pub topic: Arc<str>,
    /// The full name of its schema, such as `ppnpack.v1.Decision`.
    pub schema: Arc<str>,
    /// When it came to the recorder, in nanoseconds since 1970.
    pub at_ns: u64,
    /// The encoded message.
    pub payload: Vec<u8>,
}

/// Reads a recording, message after message. Takes memory for one chunk at a time.
pub struct Reader {
    path: PathBuf,
    file: File,
    records: LinearReader,
    /// How many bytes are good.
    offset: u64,
    schemas: HashMap<u16, Arc<str>>,
    /// The names of channels, with the ids of their schemas.
    channels: HashMap<u16, (Arc<str>, u16)>,
    ready: VecDeque<RecordedMessage>,
    dropped: HashMap<String, u64>,
    /// The program that wrote it, once the header was read.
    library: Option<String>,
    is_over: bool,
    is_whole: bool,
}

impl Reader {
    /// Opens a recording.
    ///
    /// # Errors
    /// [`RecordingError`] where it cannot be read, or is no MCAP file.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let file = File::open(path).map_err(|source| RecordingError::File {
            path: path.to_owned(),
            action: "read",
            source,
        })?;
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_skip_end_magic(true)
            .with_record_length_limit(MOST_RECORD_BYTES);
        let mut reader = Self {
            path: path.to_owned(),
            file,
            records: LinearReader::new_with_options(options),
            offset: mcap::MAGIC.len() as u64,
            schemas: HashMap::new(),
            channels: HashMap::new(),
            ready: VecDeque::new(),
            dropped: HashMap::new(),
            library: None,
            is_over: false,
            is_whole: false,
        };
        // Its header tells whether it is one.
        while reader.library.is_none() && !reader.is_over {
            reader.advance()?;
        }
        Ok(reader)
    }

    /// Gives the next message; `None` after the last: [`Self::is_whole`] says how the file ends.
    ///
    /// # Errors
    /// [`RecordingError::Damaged`] where the file is; nothing comes after that.
    pub fn next_message(&mut self) -> Result<Option<RecordedMessage>, RecordingError> {
        loop {
            if let Some(message) = self.ready.pop_front() {
                return Ok(Some(message));
            }
            if self.is_over {
                return Ok(None);
            }
            self.advance()?;
        }
    }

    /// Whether the recorder ended the file, once all was read. Else it was killed or still writes,
    /// and what it had not flushed is missing.
    pub fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Names the program that wrote it.
    pub fn library(&self) -> &str {
        self.library.as_deref().unwrap_or_default()
    }

    /// How many messages were dropped while it was written, by channel, as far as it was read.
    pub fn dropped(&self) -> &HashMap<String, u64> {
        &self.dropped
    }

    fn advance(&mut self) -> Result<(), RecordingError> {
        let stepped = self.step();
        self.is_over |= stepped.is_err();
        stepped
    }

    fn step(&mut self) -> Result<(), RecordingError> {
        let Some(event) = self.records.next_event() else {
            self.is_over = true;
            return Ok(());
        };
        let (opcode, data) = match event {
            Ok(LinearReadEvent::ReadRequest(bytes)) => {
                let read = self.file.read(self.records.insert(bytes));
                let read = read.map_err(|source| RecordingError::File {
                    path: self.path.clone(),
                    action: "read",
                    source,
                })?;
                self.records.notify_read(read);
                return Ok(());
            }
            Ok(LinearReadEvent::Record { opcode, data }) => (opcode, data.to_vec()),
            // A recorder that is killed leaves the beginning of what it was about to write.
            Err(McapError::UnexpectedEof) if self.library.is_some() => {
                self.is_over = true;
                return Ok(());
            }
            Err(McapError::BadMagic | McapError::UnexpectedEof) => {
                return Err(RecordingError::NoRecording {
                    path: self.path.clone(),
                });
            }
            Err(error) => return Err(self.damaged(&error)),
        };
        let taken = self.take(opcode, &data);
        taken.map_err(|error| self.damaged(&error))?;
        // An opcode and a length are before each record.
        self.offset += 9 + data.len() as u64;
        Ok(())
    }

    fn damaged(&self, error: &McapError) -> RecordingError {
        RecordingError::Damaged {
            path: self.path.clone(),
            offset: self.offset,
            reason: error.to_string(),
        }
    }

    /// Takes a record of the file. Those that nobody here asks for are not looked into.
    fn take(&mut self, opcode: u8, data: &[u8]) -> Result<(), McapError> {
        match opcode {
            op::FOOTER => (self.is_over, self.is_whole) = (true, true),
            op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA => {
                let message = self.take_record(parse_record(opcode, data)?)?;
                self.ready.extend(message);
            }
            op::CHUNK => self.take_chunk(data)?,
            _ => {}
        }
        Ok(())
    }

    /// Takes the records of a chunk, once its checksum is right: a damaged one may say any length
    /// of a record in it.
    fn take_chunk(&mut self, chunk: &[u8]) -> Result<(), McapError> {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MOST_RECORD_BYTES);
        let mut records = LinearReader::new_with_options(options);
        // As a file of its own, of this one record.
        let mut head = vec![op::CHUNK];
        head.extend((chunk.len() as u64).to_le_bytes());
        let mut file = head.as_slice().chain(chunk);
        let mut messages = Vec::new();
        while let Some(event) = records.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(bytes) => {
                    let read = file.read(records.insert(bytes))?;
                    records.notify_read(read);
                }
                LinearReadEvent::Record { opcode, data } => {
                    messages.extend(self.take_record(parse_record(opcode, data)?)?);
                }
            }
        }
        self.ready.extend(messages);
        Ok(())
    }

    fn take_record(&mut self, record: Record<'_>) -> Result<Option<RecordedMessage>, McapError> {
        match record {
            Record::Header(header) => self.library = Some(header.library),
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name.into());
            }
            Record::Channel(channel) => {
                let known = (channel.topic.into(), channel.schema_id);
                self.channels.insert(channel.id, known);
            }
            Record::Message { header, data } => {
                let unknown = || McapError::UnknownChannel(header.sequence, header.channel_id);
                let channel = self.channels.get(&header.channel_id);
                let (topic, schema) = channel.ok_or_else(unknown)?;
                return Ok(Some(RecordedMessage {
                    topic: Arc::clone(topic),
                    schema: self.schemas.get(schema).cloned().unwrap_or_default(),
                    at_ns: header.log_time,
                    payload: data.into_owned(),
                }));
            }
            Record::Metadata(metadata) if metadata.name == DROPPED => {
                let counts = metadata.metadata.into_iter();
                let counts = counts.filter_map(|(topic, count)| Some((topic, count.parse().ok()?)));
                self.dropped.extend(counts);
            }
            _ => {}
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use ppnpack_wire::keys::{Cell, Stream};

    use super::*;
    use crate::file::RecordingFile;
    use crate::queue::Entry;
    use crate::topic::Topic;

    fn recording(folder: &Path) -> PathBuf {
        let mut file = RecordingFile::begin(folder.join("whole.mcap")).unwrap();
        let cell = Cell::new("cell-1").unwrap();
        for number in 0..40_u8 {
            let streams = [Stream::Plan, Stream::State];
            let topic = Topic::Stream(cell.clone(), streams[usize::from(number % 2)]);
            let entry = Entry::now(topic, vec![number; 50]);
            file.write(&entry).unwrap();
            if number % 10 == 9 {
                file.flush(&BTreeMap::new()).unwrap();
            }
        }
        file.finish(&BTreeMap::new()).unwrap()
    }

    /// All messages up to the end or a fault, and whether the file is whole.
    fn read(path: &Path) -> (Vec<RecordedMessage>, Result<bool, RecordingError>) {
        let mut messages = Vec::new();
        let mut reader = match Reader::open(path) {
            Ok(reader) => reader,
            Err(error) => return (messages, Err(error)),
        };
        loop {
            match reader.next_message() {
                Ok(Some(message)) => messages.push(message),
                Ok(None) => return (messages, Ok(reader.is_whole())),
                Err(error) => return (messages, Err(error)),
            }
        }
    }

    #[test]
    fn a_file_that_was_cut_anywhere_gives_what_is_before_that() {
        let folder = tempfile::tempdir().unwrap();
        let whole = recording(folder.path());
        let (all, end) = read(&whole);
        assert_eq!((all.len(), end.unwrap()), (40, true));
        let bytes = std::fs::read(&whole).unwrap();
        let cut = folder.path().join("cut.mcap");
        let mut most = 0;
        for length in (0..bytes.len() - 40).step_by(7) {
            std::fs::write(&cut, &bytes[..length]).unwrap();
            let (messages, end) = read(&cut);
            if let Err(error) = end {
                let is_none = matches!(error, RecordingError::NoRecording { .. });
                assert!(is_none, "{length}: {error}");
            }
            assert!(
                messages.len() >= most && messages.len() % 10 == 0,
                "{length}"
            );
            assert_eq!(messages, all[..messages.len()], "{length}");
            most = messages.len();
        }
        assert_eq!(most, 40);
    }

    #[test]
    fn a_damaged_file_gives_no_message_that_was_not_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let whole = recording(folder.path());
        let (all, _) = read(&whole);
        let bytes = std::fs::read(&whole).unwrap();
        let damaged = folder.path().join("damaged.mcap");
        let mut told = 0;
        for at in (0..bytes.len()).step_by(3) {
            let mut other = bytes.clone();
            let end = (at + 4).min(other.len());
            for byte in &mut other[at..end] {
                *byte ^= 0xA5;
            }
            std::fs::write(&damaged, &other).unwrap();
            let (messages, end) = read(&damaged);
            // Messages of unknown channels are left out, and names outside of chunks have no
            // checksum.
            let known =
                |message: &RecordedMessage| all.iter().any(|of| of.payload == message.payload);
            assert!(messages.iter().all(known), "{at}");
            told += usize::from(end.is_err());
        }
        assert!(told > 100, "{told}");
    }
}
