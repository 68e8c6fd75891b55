//! The manifest: what a finished dataset consists of.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::settings::Settings;

/// The file of a dataset's manifest, written last.
pub const MANIFEST_FILE: &str = "manifest.json";

/// The file of a dataset's items.
pub(crate) const ITEMS_FILE: &str = "items.bin";

/// What a finished dataset consists of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The dataset's digest, in hexadecimal: over the settings and the digests of all files.
    pub hash: String,
    /// What it was made with.
    pub settings: Settings,
    /// How many sequences it has.
    pub sequences: u32,
    /// How many steps.
    pub steps: u64,
    /// How many candidates, over all steps.
    pub candidates: u64,
    /// The heightmap pairs of the objects.
    pub items: FileEntry,
    /// The steps, by sequence.
    pub shards: Vec<ShardEntry>,
}

/// A file and its digest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Its name within the folder.
    pub file: String,
    /// Its size, in bytes.
    pub bytes: u64,
    /// The BLAKE3 digest of its content, in hexadecimal.
    pub blake3: String,
}

/// A file of consecutive sequences.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShardEntry {
    /// The file.
    #[serde(flatten)]
    pub file: FileEntry,
    /// Number of its first sequence.
    pub first_sequence: u32,
    /// How many sequences it has.
    pub sequences: u32,
    /// How many steps.
    pub steps: u64,
    /// How many candidates, over all steps.
    pub candidates: u64,
}

impl FileEntry {
    pub(crate) fn of(file: &str, content: &[u8]) -> Self {
        Self {
            file: file.to_owned(),
            bytes: content.len() as u64,
            blake3: blake3::hash(content).to_hex().to_string(),
        }
    }

    /// Whether this is the content that was written.
    pub(crate) fn matches(&self, content: &[u8]) -> bool {
        *self == Self::of(&self.file, content)
    }
}

impl ShardEntry {
    /// The entry of a shard with these sequences, of which `counts` gives the steps and candidates.
    pub(crate) fn new(
        file: FileEntry,
        range: &Range<u32>,
        counts: impl Iterator<Item = (u64, u64)>,
    ) -> Self {
        let (steps, candidates) = counts.fold((0, 0), |(steps, candidates), more| {
            (steps + more.0, candidates + more.1)
        });
        Self {
            file,
            first_sequence: range.start,
            sequences: range.end - range.start,
            steps,
            candidates,
        }
    }

    /// Whether it is that of the shard with an index, whose sequences are `range`.
    fn is_of(&self, index: usize, range: &Range<u32>) -> bool {
        self.file.file == shard_file(index)
            && self.first_sequence == range.start
            && self.sequences == range.end - range.start
    }
}

impl Manifest {
    pub(crate) fn new(
        settings: Settings,
        sequences: u32,
        items: FileEntry,
        shards: Vec<ShardEntry>,
    ) -> Self {
        Self {
            hash: digest(&settings, &items, &shards),
            steps: total(&shards, |shard| shard.steps),
            candidates: total(&shards, |shard| shard.candidates),
            settings,
            sequences,
            items,
            shards,
        }
    }

    /// Checks that the parts belong together; gives what does not.
    pub(crate) fn validate(&self) -> Result<(), String> {
        let check = |holds: bool, what: &str| if holds { Ok(()) } else { Err(what.to_owned()) };
        let settings = self.settings.validate();
        settings.map_err(|error| error.to_string())?;
        let has_items = self.items.file == ITEMS_FILE;
        check(has_items, "its items are in another file")?;
        // Compared as numbers first: there is no list as long as a manifest may claim.
        let per_shard = self.settings.sequences_per_shard;
        let is_complete = self.shards.len() == self.sequences.div_ceil(per_shard) as usize
            && shard_ranges(self.sequences, per_shard)
                .zip(&self.shards)
                .enumerate()
                .all(|(index, (range, shard))| shard.is_of(index, &range));
        check(is_complete, "its shards are not those of its sequences")?;
        let expected = Self::new(
            self.settings.clone(),
            self.sequences,
            self.items.clone(),
            self.shards.clone(),
        );
        let has_hash = self.hash == expected.hash;
        check(has_hash, "its hash is not that of its parts")?;
        check(*self == expected, "its totals are not those of its shards")
    }
}

/// A sum over all shards, which a damaged manifest may make very large.
fn total(shards: &[ShardEntry], count: fn(&ShardEntry) -> u64) -> u64 {
    shards.iter().map(count).fold(0, u64::saturating_add)
}

fn digest(settings: &Settings, items: &FileEntry, shards: &[ShardEntry]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(settings.hash().as_bytes());
    hasher.update(items.blake3.as_bytes());
    for shard in shards {
        hasher.update(shard.file.blake3.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// The name of a shard's file.
pub(crate) fn shard_file(index: usize) -> String {
    format!("shard-{index:05}.bin")
}

/// The sequences of each shard.
pub(crate) fn shard_ranges(sequences: u32, per_shard: u32) -> impl Iterator<Item = Range<u32>> {
    let per_shard = per_shard.max(1);
    (0..sequences)
        .step_by(per_shard as usize)
        .map(move |first| first..first.saturating_add(per_shard).min(sequences))
}
