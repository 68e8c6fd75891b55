//! Reading a dataset.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ppnpack_packing::kernel::item::Item;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::arrays::{MAX_BYTES, read};
use crate::error::DatasetError;
use crate::items;
use crate::record::StepRecord;
use crate::sequence::{Layout, sequence_path};
use crate::settings::{FORMAT_VERSION, ITEMS_FILE, SETTINGS_FILE, Settings};

/// Maximum size of a file of settings, in bytes.
const MAX_SETTINGS_BYTES: u64 = 1 << 20;

/// A part of a dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Split {
    /// Nine of ten sequences, to learn from.
    Train,
    /// Every tenth sequence, to measure on.
    Test,
}

impl Split {
    /// Gives the split of a sequence: test where its number ends in 9.
    ///
    /// Steps of one sequence resemble each other, so all of them belong to one split.
    pub fn of(sequence: u32) -> Self {
        match sequence % 10 {
            9 => Self::Test,
            _ => Self::Train,
        }
    }
}

/// A finished dataset.
#[derive(Debug)]
pub struct Dataset {
    folder: PathBuf,
    layout: Layout,
    hash: String,
}

impl Dataset {
    /// Opens the folder of a finished dataset: reads and checks its settings and items.
    ///
    /// # Errors
    /// [`DatasetError`] where there is none, or it is damaged, unfinished or of another version.
    pub fn open(folder: &Path) -> Result<Self, DatasetError> {
        let path = folder.join(SETTINGS_FILE);
        // The version goes first: of another one, nothing else can be relied on.
        let found: Value = read_settings(&path)?;
        let version = found.get("format_version").and_then(Value::as_u64);
        if version != Some(u64::from(FORMAT_VERSION)) {
            return Err(DatasetError::Version(path, version.unwrap_or(0)));
        }
        let settings: Settings = read_settings(&path)?;
        let damaged = |reason| DatasetError::Damaged(path.clone(), reason);
        settings.validate().map_err(damaged)?;
        let items_path = folder.join(ITEMS_FILE);
        let items = read(&items_path, MAX_BYTES, |arrays| {
            items::read(arrays, &settings)
        })?;

        let mut hasher = blake3::Hasher::new();
        let sequences = (0..settings.sequences).map(|number| sequence_path(folder, number));
        for file in [path, items_path].into_iter().chain(sequences) {
            let opened = File::open(&file).map_err(read_error(&file))?;
            hasher.update_reader(opened).map_err(read_error(&file))?;
        }
        Ok(Self {
            folder: folder.to_owned(),
            layout: Layout { settings, items },
            hash: hasher.finalize().to_hex().to_string(),
        })
    }

    /// Gives the settings it was made with.
    pub fn settings(&self) -> &Settings {
        &self.layout.settings
    }

    /// Gives the digest of all files, in hexadecimal.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Gives the items that records refer to by index, in the settings' resolution: their heightmap
    /// pairs alone.
    pub fn items(&self) -> &[Arc<Item>] {
        &self.layout.items
    }

    /// Reads the steps of a split, by sequence and step. `progress` is called with the sequences
    /// done and their total.
    ///
    /// Values take two bytes per placement and candidate, about 14 kB a step of the reference
    /// setting; where they are not asked for, they take no memory.
    pub fn load(
        &self,
        split: Split,
        with_values: bool,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Vec<StepRecord>, DatasetError> {
        let all = 0..self.layout.settings.sequences;
        let wanted: Vec<u32> = all.filter(|number| Split::of(*number) == split).collect();
        let mut steps = Vec::new();
        for (done, sequence) in (1..).zip(&wanted) {
            steps.extend(self.layout.read(&self.folder, *sequence, with_values)?);
            progress(done, wanted.len());
        }
        Ok(steps)
    }
}

fn read_error(path: &Path) -> impl Fn(io::Error) -> DatasetError {
    move |error| DatasetError::Read(path.to_owned(), error)
}

/// Reads a file of settings.
pub(crate) fn read_settings<T: DeserializeOwned>(path: &Path) -> Result<T, DatasetError> {
    let mut content = Vec::new();
    let opened = File::open(path).map(|file| file.take(MAX_SETTINGS_BYTES));
    let read = opened.and_then(|mut file| file.read_to_end(&mut content));
    read.map_err(read_error(path))?;
    let damaged =
        |error: serde_json::Error| DatasetError::Damaged(path.to_owned(), error.to_string());
    serde_json::from_slice(&content).map_err(damaged)
}
