//! Writing a dataset, sequence by sequence, in any order and from any thread.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ppnpack_packing::kernel::item::Item;
use serde_json::Value;

use crate::arrays::write_changed;
use crate::error::DatasetError;
use crate::items;
use crate::reader::{Dataset, read_settings};
use crate::record::SequenceRecord;
use crate::sequence::{Layout, sequence_path};
use crate::settings::{ITEMS_FILE, SETTINGS_FILE, Settings};

/// A dataset that is being written into a folder.
///
/// Each sequence is a file, which is there whole or not at all; so of a killed run the finished
/// ones stay, and opening the folder again finds them.
#[derive(Debug)]
pub struct DatasetWriter {
    folder: PathBuf,
    layout: Layout,
}

impl DatasetWriter {
    /// Opens a folder to write what these settings say, or what is missing of it.
    ///
    /// # Errors
    /// [`DatasetError`] where the folder cannot be written or holds another dataset.
    pub fn open(
        folder: &Path,
        settings: Settings,
        items: Vec<Arc<Item>>,
    ) -> Result<Self, DatasetError> {
        settings.validate().map_err(DatasetError::Settings)?;
        let yaws = settings.grid.resolution().yaws().count();
        let are_views = items.iter().all(|item| item.views().len() == yaws);
        if items.len() != settings.objects as usize || !are_views {
            let what = format!("{} items of {yaws} yaws", items.len());
            return Err(DatasetError::Settings(what));
        }
        let path = folder.join(SETTINGS_FILE);
        if path.exists() {
            let mut found: Value = read_settings(&path)?;
            // Any number of the same sequences will do.
            if let Some(sequences) = found.get_mut("sequences") {
                *sequences = settings.sequences.into();
            }
            if let Some(difference) = settings.difference(&found) {
                return Err(DatasetError::OtherSettings(folder.to_owned(), difference));
            }
        }
        // Settings are numbers and texts, which JSON holds.
        let content = serde_json::to_vec_pretty(&settings).unwrap_or_default();
        write_changed(&path, &content)?;
        let packed = items::arrays(&items, yaws).packed();
        let packed = packed.map_err(DatasetError::Settings)?;
        write_changed(&folder.join(ITEMS_FILE), &packed)?;
        Ok(Self {
            folder: folder.to_owned(),
            layout: Layout { settings, items },
        })
    }

    /// Gives the sequences that are still to be played and added, in order. A damaged one is among
    /// them, and is warned about.
    pub fn missing(&self) -> Vec<u32> {
        let is_missing = |sequence: &u32| {
            let exists = sequence_path(&self.folder, *sequence).exists();
            let found = exists.then(|| self.layout.read(&self.folder, *sequence, true));
            if let Some(Err(error)) = &found {
                tracing::warn!(%error, "a sequence is made again");
            }
            !matches!(found, Some(Ok(_)))
        };
        let all = 0..self.layout.settings.sequences;
        all.filter(is_missing).collect()
    }

    /// Adds a sequence.
    ///
    /// # Errors
    /// [`DatasetError`] where the record does not fit the settings or cannot be written.
    pub fn add(&self, record: &SequenceRecord) -> Result<(), DatasetError> {
        let sequence = record.sequence;
        let packed = self.layout.arrays(record);
        let packed = packed.and_then(|arrays| arrays.packed());
        let packed = packed.map_err(|reason| DatasetError::Record(sequence, reason))?;
        write_changed(&sequence_path(&self.folder, sequence), &packed)
    }

    /// Opens what was written.
    pub fn finish(self) -> Result<Dataset, DatasetError> {
        Dataset::open(&self.folder)
    }
}
