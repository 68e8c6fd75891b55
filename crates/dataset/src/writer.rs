//! Writing a dataset, sequence by sequence, in any order and from any thread.

use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ppnpack_files::{WriteError, remove_unfinished, write_whole};
use ppnpack_packing::item::Item;

use crate::error::DatasetError;
use crate::files::read_bounded;
use crate::items;
use crate::manifest::{
    FileEntry, ITEMS_FILE, MANIFEST_FILE, Manifest, ShardEntry, shard_file, shard_ranges,
};
use crate::reader::MAX_JSON_BYTES;
use crate::record::SequenceRecord;
use crate::settings::{SETTINGS_FILE, Settings};
use crate::shard::{Layout, Packed, count};

/// Held while a process writes into a folder.
const LOCK_FILE: &str = ".lock";

/// Writes a dataset into a folder.
///
/// A shard is written, whole, when its last sequence is added; so of a killed run the finished shards stay, and
/// opening the folder again finds them. The manifest is written last: a folder that has one is complete.
#[derive(Debug)]
pub struct DatasetWriter {
    folder: PathBuf,
    layout: Layout,
    sequences: u32,
    items: FileEntry,
    progress: Mutex<Progress>,
    _lock: File,
}

#[derive(Debug, Default)]
struct Progress {
    /// Sequences of shards that are not complete.
    waiting: BTreeMap<u32, Packed>,
    /// Complete shards, by index.
    shards: BTreeMap<usize, ShardEntry>,
}

impl DatasetWriter {
    /// Opens a folder to write the first `sequences` sequences made with these settings, or what is missing of them.
    ///
    /// Finished shards are verified; a damaged one is made again, which a warning says.
    ///
    /// # Errors
    /// [`DatasetError`] where the folder cannot be written, is in use, or holds another dataset or a larger one.
    pub fn open(
        folder: &Path,
        settings: Settings,
        items: Vec<Arc<Item>>,
        sequences: u32,
    ) -> Result<Self, DatasetError> {
        settings.validate()?;
        if items.len() != settings.objects as usize || sequences == 0 {
            let what = format!("{sequences} sequences of {} items", items.len());
            return Err(DatasetError::Settings(what));
        }
        let lock = lock(folder)?;
        claim(folder, &settings)?;
        refuse_fewer(folder, sequences)?;
        let content = items::encode(&items, &settings).map_err(DatasetError::Settings)?;
        let path = folder.join(ITEMS_FILE);
        if std::fs::read(&path).ok().as_ref() != Some(&content) {
            write_whole(&path, &content)?;
        }
        let writer = Self {
            folder: folder.to_owned(),
            layout: Layout::new(settings, items),
            sequences,
            items: FileEntry::of(ITEMS_FILE, &content),
            progress: Mutex::default(),
            _lock: lock,
        };
        for (index, range) in writer.ranges() {
            if let Some(entry) = writer.verified(index, &range) {
                writer.progress().shards.insert(index, entry);
            }
        }
        Ok(writer)
    }

    /// The sequences that are still to be played and added, in order.
    pub fn missing(&self) -> Vec<u32> {
        let progress = self.progress();
        self.ranges()
            .filter(|(index, _)| !progress.shards.contains_key(index))
            .flat_map(|(_, range)| range)
            .filter(|sequence| !progress.waiting.contains_key(sequence))
            .collect()
    }

    /// Adds a sequence that was missing.
    ///
    /// # Errors
    /// [`DatasetError`] where the record does not fit the settings, or its shard cannot be written.
    pub fn add(&self, record: &SequenceRecord) -> Result<(), DatasetError> {
        let sequence = record.sequence;
        let wrong = |reason| DatasetError::Record { sequence, reason };
        let place = self.ranges().find(|(_, range)| range.contains(&sequence));
        let (index, range) = place.ok_or_else(|| wrong("it was not asked for".to_owned()))?;
        let packed = self.layout.pack(record).map_err(wrong)?;
        let mut progress = self.progress();
        progress.waiting.insert(sequence, packed);
        let waiting = range
            .clone()
            .map(|sequence| progress.waiting.get(&sequence));
        let Some(complete) = waiting.collect::<Option<Vec<&Packed>>>() else {
            return Ok(());
        };
        let content = self.layout.shard(range.start, &complete);
        let file = FileEntry::of(&shard_file(index), &content);
        let entry = ShardEntry::new(file, &range, complete.iter().map(|packed| packed.counts));
        write_whole(&self.folder.join(&entry.file.file), &content)?;
        progress
            .waiting
            .retain(|sequence, _| !range.contains(sequence));
        progress.shards.insert(index, entry);
        Ok(())
    }

    /// Takes over the finished shards of another folder of the same settings that are missing here. Gives how many.
    ///
    /// # Errors
    /// [`DatasetError`] where that folder is of other settings, a shard of it is damaged, or none can be written.
    pub fn adopt(&self, other: &Path) -> Result<usize, DatasetError> {
        expect_settings(other, &self.layout.settings)?;
        let mut progress = self.progress();
        let mut adopted = 0;
        for (index, range) in self.ranges() {
            let path = other.join(shard_file(index));
            if progress.shards.contains_key(&index) || !path.exists() {
                continue;
            }
            let content = std::fs::read(&path).map_err(|source| DatasetError::Read {
                path: path.clone(),
                source,
            })?;
            let entry = self.entry(&shard_file(index), &content, &range);
            let entry = entry.map_err(|reason| DatasetError::Damaged { path, reason })?;
            write_whole(&self.folder.join(&entry.file.file), &content)?;
            progress.shards.insert(index, entry);
            adopted += 1;
        }
        Ok(adopted)
    }

    /// Writes the manifest, which completes the dataset.
    ///
    /// # Errors
    /// [`DatasetError`] where sequences are missing or the manifest cannot be written.
    pub fn finish(self) -> Result<Manifest, DatasetError> {
        let missing = self.missing();
        if let Some(first) = missing.first() {
            return Err(DatasetError::Unfinished {
                count: missing.len(),
                first: *first,
            });
        }
        let shards = self.progress().shards.values().cloned().collect();
        let settings = self.layout.settings.clone();
        let manifest = Manifest::new(settings, self.sequences, self.items.clone(), shards);
        write_json(&self.folder.join(MANIFEST_FILE), &manifest)?;
        Ok(manifest)
    }

    /// The index and the sequences of each shard.
    fn ranges(&self) -> impl Iterator<Item = (usize, Range<u32>)> {
        shard_ranges(self.sequences, self.layout.settings.sequences_per_shard).enumerate()
    }

    fn progress(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The entry of a shard that is there and intact.
    fn verified(&self, index: usize, range: &Range<u32>) -> Option<ShardEntry> {
        let file = shard_file(index);
        let path = self.folder.join(&file);
        if !path.exists() {
            return None;
        }
        let content = std::fs::read(&path).map_err(|error| error.to_string());
        match content.and_then(|content| self.entry(&file, &content, range)) {
            Ok(entry) => Some(entry),
            Err(reason) => {
                tracing::warn!(path = %path.display(), reason, "a shard is made again");
                None
            }
        }
    }

    /// The entry of a shard's content, if that is intact and of these sequences; else what is wrong.
    fn entry(&self, file: &str, content: &[u8], range: &Range<u32>) -> Result<ShardEntry, String> {
        let path = self.folder.join(file);
        let shard = self.layout.open(content);
        let shard = shard.map_err(|flaw| flaw.at(&path).to_string())?;
        let found = shard.first_sequence..shard.first_sequence + shard.blocks.len() as u32;
        if found != *range {
            return Err(format!(
                "it has the sequences {found:?} instead of {range:?}"
            ));
        }
        let counts = shard.blocks.iter().map(|block| {
            let steps = self.layout.unpack(block, true)?;
            Ok(count(&steps))
        });
        let counts: Vec<(u64, u64)> = counts.collect::<Result<_, String>>()?;
        let file = FileEntry::of(file, content);
        Ok(ShardEntry::new(file, range, counts.into_iter()))
    }
}

/// Makes the folder and takes its lock, which ends with the process.
fn lock(folder: &Path) -> Result<File, DatasetError> {
    let path = folder.join(LOCK_FILE);
    let failed = |cause| WriteError::at(&path)(cause);
    std::fs::create_dir_all(folder).map_err(failed)?;
    let file = File::create(&path).map_err(failed)?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            let folder = folder.to_owned();
            return Err(DatasetError::InUse { folder });
        }
        Err(TryLockError::Error(source)) => return Err(failed(source).into()),
    }
    remove_unfinished(folder).map_err(failed)?;
    Ok(file)
}

/// Makes the folder one of these settings, unless it is one of others.
fn claim(folder: &Path, settings: &Settings) -> Result<(), DatasetError> {
    let path = folder.join(SETTINGS_FILE);
    if !path.exists() {
        return write_json(&path, settings);
    }
    expect_settings(folder, settings)
}

/// Refuses a folder of other settings.
fn expect_settings(folder: &Path, settings: &Settings) -> Result<(), DatasetError> {
    let path = folder.join(SETTINGS_FILE);
    let content = read_bounded(&path, MAX_JSON_BYTES)?;
    let found = serde_json::from_slice(&content).map_err(|error| DatasetError::Damaged {
        path,
        reason: error.to_string(),
    })?;
    let Some(difference) = settings.difference(&found) else {
        return Ok(());
    };
    let folder = folder.to_owned();
    Err(DatasetError::OtherSettings { folder, difference })
}

/// Refuses to make a dataset smaller; takes the manifest of a smaller one away, since the folder is complete no more.
fn refuse_fewer(folder: &Path, sequences: u32) -> Result<(), DatasetError> {
    let path = folder.join(MANIFEST_FILE);
    if !path.exists() {
        return Ok(());
    }
    let content = read_bounded(&path, MAX_JSON_BYTES)?;
    let found =
        serde_json::from_slice::<Manifest>(&content).map_or(0, |manifest| manifest.sequences);
    if found > sequences {
        return Err(DatasetError::MoreSequences {
            folder: folder.to_owned(),
            found,
            asked: sequences,
        });
    }
    Ok(std::fs::remove_file(&path).map_err(WriteError::at(&path))?)
}

fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), DatasetError> {
    let content = serde_json::to_vec_pretty(value)
        .map_err(std::io::Error::from)
        .map_err(WriteError::at(path))?;
    Ok(write_whole(path, &content)?)
}
