//! Shards: files of consecutive sequences.
//!
//! All numbers are little-endian.
//!
//! ```text
//! 8 bytes    "PPNSHARD"
//! u32        version of the format
//! 32 bytes   digest of the settings
//! 32 bytes   BLAKE3 digest of everything after it
//! u32 u32    first sequence, number of sequences
//! per sequence:
//!   u64      size of its records before compression, in bytes
//!   u64 u64  size of its records and of its values, compressed, in bytes
//! per sequence:
//!   records  zstd of the steps, each in postcard
//!   values   zstd of one u16 per candidate, yaw, x, y (see `Values`): all lower bytes, then all upper ones;
//!            empty where the dataset has no values
//! ```

use std::sync::Arc;

use ppnpack_packing::item::Item;
use ppnpack_packing::proposals::possible_count;

use crate::error::DatasetError;
use crate::files::decompress;
use crate::record::{SequenceRecord, StepRecord};
use crate::settings::{FORMAT_VERSION, Settings};
use crate::validate;
use crate::values::Values;

const MAGIC: &[u8; 8] = b"PPNSHARD";

/// The most bytes that the records, and the values, of one sequence may have before compression.
const MAX_RECORD_BYTES: u64 = 1 << 30;
const MAX_VALUE_BYTES: u64 = 1 << 32;

/// Records are few and read often; values are many and dominate the time to write.
const RECORD_LEVEL: i32 = 12;
const VALUE_LEVEL: i32 = 6;

/// What the shards of a dataset have in common.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub(crate) settings: Settings,
    pub(crate) items: Vec<Arc<Item>>,
    hash: blake3::Hash,
}

/// Why a shard cannot be used.
#[derive(Debug)]
pub(crate) enum Flaw {
    Version(u64),
    Damaged(String),
}

impl Flaw {
    pub(crate) fn at(self, path: &std::path::Path) -> DatasetError {
        let path = path.to_owned();
        match self {
            Self::Version(found) => DatasetError::Version {
                path,
                found,
                readable: FORMAT_VERSION,
            },
            Self::Damaged(reason) => DatasetError::Damaged { path, reason },
        }
    }
}

impl From<String> for Flaw {
    fn from(reason: String) -> Self {
        Self::Damaged(reason)
    }
}

/// A sequence ready for its shard.
#[derive(Debug, Clone)]
pub(crate) struct Packed {
    record_bytes: u64,
    records: Vec<u8>,
    values: Vec<u8>,
    /// Of steps and of candidates.
    pub(crate) counts: (u64, u64),
}

/// A shard that was looked into.
#[derive(Debug)]
pub(crate) struct Shard<'a> {
    pub(crate) first_sequence: u32,
    pub(crate) blocks: Vec<Block<'a>>,
}

/// A sequence within a shard.
#[derive(Debug)]
pub(crate) struct Block<'a> {
    pub(crate) sequence: u32,
    record_bytes: u64,
    records: &'a [u8],
    values: &'a [u8],
}

impl Layout {
    pub(crate) fn new(settings: Settings, items: Vec<Arc<Item>>) -> Self {
        let hash = settings.hash();
        Self {
            settings,
            items,
            hash,
        }
    }

    /// The item of a validated candidate.
    fn item(&self, object: u32) -> Result<&Item, String> {
        let item = self.items.get(object as usize);
        item.map(|item| &**item)
            .ok_or_else(|| format!("there is no object {object}"))
    }

    /// The most bytes that the records of one sequence can have.
    fn most_record_bytes(&self) -> u64 {
        let grid = &self.settings.grid;
        let cells = (grid.nx() * grid.ny()) as u64;
        // postcard: at most 3 bytes for an i16 or u16, 5 for a u32 or a length here, 8 for an f64.
        let yaw = 8 + 5 + 6 * cells;
        let yaws = yaw.saturating_mul(grid.resolution().yaws().count() as u64);
        let candidate = yaws.saturating_add(10);
        let candidates = candidate.saturating_mul(u64::from(self.settings.expert.buffer));
        let step = candidates.saturating_add(20 + 3 * cells);
        let steps = step.saturating_mul(u64::from(self.settings.length));
        steps.min(MAX_RECORD_BYTES)
    }

    /// Bytes of the values of these steps before compression.
    fn value_bytes(&self, steps: &[StepRecord]) -> Result<u64, String> {
        let mut bytes = 0_u64;
        for candidate in steps.iter().flat_map(|step| &step.candidates) {
            bytes += 2 * possible_count(&self.settings.grid, self.item(candidate.object)?);
        }
        if bytes > MAX_VALUE_BYTES {
            return Err(format!("its values have more than {MAX_VALUE_BYTES} bytes"));
        }
        Ok(bytes)
    }

    /// Makes a sequence ready for its shard; gives what is wrong with it.
    pub(crate) fn pack(&self, record: &SequenceRecord) -> Result<Packed, String> {
        for (index, step) in record.steps.iter().enumerate() {
            validate::step(&self.settings, &self.items, record.sequence, index, step)?;
        }
        let mut records = Vec::new();
        for step in &record.steps {
            records = postcard::to_extend(step, records).map_err(|error| error.to_string())?;
        }
        let most = self.most_record_bytes();
        if records.len() as u64 > most {
            return Err(format!("its records have more than {most} bytes"));
        }
        let compress = |content: &[u8], level| {
            zstd::encode_all(content, level).map_err(|error| error.to_string())
        };
        let values = if self.settings.has_values {
            compress(&self.value_planes(&record.steps)?, VALUE_LEVEL)?
        } else {
            Vec::new()
        };
        Ok(Packed {
            record_bytes: records.len() as u64,
            records: compress(&records, RECORD_LEVEL)?,
            values,
            counts: count(&record.steps),
        })
    }

    /// The lower bytes of all values, then the upper ones: the upper ones hardly vary.
    fn value_planes(&self, steps: &[StepRecord]) -> Result<Vec<u8>, String> {
        let bytes = self.value_bytes(steps)?;
        let values = || {
            let candidates = steps.iter().flat_map(|step| &step.candidates);
            candidates.filter_map(|candidate| candidate.values.as_ref())
        };
        let entries = || values().flat_map(Values::steps);
        let mut planes: Vec<u8> = Vec::with_capacity(bytes as usize);
        planes.extend(entries().map(|entry| entry.to_le_bytes()[0]));
        planes.extend(entries().map(|entry| entry.to_le_bytes()[1]));
        if planes.len() as u64 == bytes {
            Ok(planes)
        } else {
            Err("its values are not those of its candidates' placements".to_owned())
        }
    }

    /// The content of a shard.
    pub(crate) fn shard(&self, first_sequence: u32, sequences: &[&Packed]) -> Vec<u8> {
        let mut body = Vec::new();
        body.extend(first_sequence.to_le_bytes());
        body.extend((sequences.len() as u32).to_le_bytes());
        for packed in sequences {
            let sizes = [
                packed.record_bytes,
                packed.records.len() as u64,
                packed.values.len() as u64,
            ];
            body.extend(sizes.into_iter().flat_map(u64::to_le_bytes));
        }
        for packed in sequences {
            body.extend_from_slice(&packed.records);
            body.extend_from_slice(&packed.values);
        }
        let mut content = MAGIC.to_vec();
        content.extend(FORMAT_VERSION.to_le_bytes());
        content.extend_from_slice(self.hash.as_bytes());
        content.extend_from_slice(blake3::hash(&body).as_bytes());
        content.extend(body);
        content
    }

    /// Looks into a shard.
    pub(crate) fn open<'a>(&self, content: &'a [u8]) -> Result<Shard<'a>, Flaw> {
        let mut rest = Rest(content);
        let damaged = |what: &str| Err(Flaw::Damaged(what.to_owned()));
        if rest.bytes(8)? != MAGIC {
            return damaged("it is no shard of a dataset");
        }
        let version = rest.u32()?;
        if version != FORMAT_VERSION {
            return Err(Flaw::Version(u64::from(version)));
        }
        if rest.bytes(32)? != self.hash.as_bytes() {
            return damaged("it was made with other settings");
        }
        let checksum = rest.bytes(32)?;
        if blake3::hash(rest.0).as_bytes() != checksum {
            return damaged("its checksum does not match");
        }
        let (first_sequence, count) = (rest.u32()?, rest.u32()?);
        let is_possible = count <= self.settings.sequences_per_shard;
        if !is_possible || first_sequence.checked_add(count).is_none() {
            return damaged(&format!("it cannot have {count} sequences"));
        }
        let sizes = (0..count)
            .map(|_| Ok([rest.u64()?, rest.u64()?, rest.u64()?]))
            .collect::<Result<Vec<_>, String>>()?;
        let blocks = (first_sequence..).zip(sizes).map(|(sequence, sizes)| {
            let [record_bytes, records, values] = sizes;
            Ok(Block {
                sequence,
                record_bytes,
                records: rest.bytes(records)?,
                values: rest.bytes(values)?,
            })
        });
        let blocks = blocks.collect::<Result<Vec<_>, String>>()?;
        if !rest.0.is_empty() {
            return damaged("something follows its last sequence");
        }
        Ok(Shard {
            first_sequence,
            blocks,
        })
    }

    /// The steps of a sequence, checked; gives what is wrong. Values are read where they are wanted and there are any.
    pub(crate) fn unpack(
        &self,
        block: &Block<'_>,
        with_values: bool,
    ) -> Result<Vec<StepRecord>, String> {
        if block.record_bytes > self.most_record_bytes() {
            return Err("its records are larger than they can be".to_owned());
        }
        let records = decompress(block.records, block.record_bytes)?;
        let (mut rest, mut steps) = (&records[..], Vec::new());
        while !rest.is_empty() {
            let taken = postcard::take_from_bytes::<StepRecord>(rest);
            let (step, after) =
                taken.map_err(|error| format!("a record cannot be decoded: {error}"))?;
            let (settings, items) = (&self.settings, &self.items);
            validate::step(settings, items, block.sequence, steps.len(), &step)?;
            steps.push(step);
            rest = after;
        }
        if with_values && self.settings.has_values {
            self.unpack_values(block.values, &mut steps)?;
        }
        Ok(steps)
    }

    fn unpack_values(&self, packed: &[u8], steps: &mut [StepRecord]) -> Result<(), String> {
        let planes = decompress(packed, self.value_bytes(steps)?)?;
        let (lower, upper) = planes.split_at(planes.len() / 2);
        let mut entries = lower
            .iter()
            .zip(upper)
            .map(|(lower, upper)| u16::from_le_bytes([*lower, *upper]));
        for candidate in steps.iter_mut().flat_map(|step| &mut step.candidates) {
            let item = self.item(candidate.object)?;
            let best = candidate.best_value();
            let values = Values::from_steps(&self.settings.grid, item, best, &mut entries);
            candidate.values = Some(values);
        }
        Ok(())
    }
}

/// How many steps, and how many candidates over all of them.
pub(crate) fn count(steps: &[StepRecord]) -> (u64, u64) {
    let candidates: usize = steps.iter().map(|step| step.candidates.len()).sum();
    (steps.len() as u64, candidates as u64)
}

/// What is left of a file.
struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    fn bytes(&mut self, count: u64) -> Result<&'a [u8], String> {
        let split = usize::try_from(count)
            .ok()
            .and_then(|count| self.0.split_at_checked(count));
        let (taken, rest) = split.ok_or("it ends too early")?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let taken = self.bytes(N as u64)?;
        taken.try_into().map_err(|_| "it ends too early".to_owned())
    }

    fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn u64(&mut self) -> Result<u64, String> {
        Ok(u64::from_le_bytes(self.array()?))
    }
}
