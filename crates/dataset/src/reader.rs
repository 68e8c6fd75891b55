//! Reading a dataset.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ppnpack_packing::item::Item;

use crate::error::DatasetError;
use crate::files::read_bounded;
use crate::items;
use crate::manifest::{FileEntry, MANIFEST_FILE, Manifest};
use crate::record::StepRecord;
use crate::settings::{FORMAT_VERSION, Settings};
use crate::shard::{Flaw, Layout};

/// Larger manifests are not read, in bytes.
pub(crate) const MAX_JSON_BYTES: u64 = 1 << 28;

/// Which part of a dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Split {
    /// What is learnt from: nine of ten sequences.
    Train,
    /// What is measured on: every tenth sequence.
    Test,
}

impl Split {
    /// The split of a sequence: test where its number ends in 9.
    ///
    /// Steps of one sequence resemble each other, so all of them belong to one split.
    pub fn of(sequence: u32) -> Self {
        if sequence % 10 == 9 {
            Self::Test
        } else {
            Self::Train
        }
    }
}

/// A finished dataset.
#[derive(Debug)]
pub struct Dataset {
    folder: PathBuf,
    manifest: Manifest,
    layout: Layout,
}

impl Dataset {
    /// Opens the folder of a finished dataset: reads and checks its manifest and items.
    ///
    /// # Errors
    /// [`DatasetError`] where there is none, or it is damaged or of another version.
    pub fn open(folder: &Path) -> Result<Self, DatasetError> {
        let path = folder.join(MANIFEST_FILE);
        let content = read_bounded(&path, MAX_JSON_BYTES)?;
        let manifest = parse(&content).map_err(|flaw| flaw.at(&path))?;
        let content = read(folder, &manifest.items)?;
        let items = items::decode(&content, &manifest.settings)
            .map_err(|flaw| flaw.at(&folder.join(&manifest.items.file)))?;
        Ok(Self {
            folder: folder.to_owned(),
            layout: Layout::new(manifest.settings.clone(), items),
            manifest,
        })
    }

    /// What the dataset consists of.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// What it was made with.
    pub fn settings(&self) -> &Settings {
        &self.manifest.settings
    }

    /// The dataset's digest, in hexadecimal: over the settings and the digests of all files.
    pub fn hash(&self) -> &str {
        &self.manifest.hash
    }

    /// The items that records refer to by index, in the settings' resolution; without undersides.
    pub fn items(&self) -> &[Arc<Item>] {
        &self.layout.items
    }

    /// The steps of a split, by sequence and step. `progress` is called with the sequences done and their total.
    ///
    /// Values take two bytes per placement and candidate, about 14 kB a step of the reference setting; where they are
    /// not asked for, they take neither time nor memory.
    ///
    /// # Errors
    /// [`DatasetError`] where a file cannot be read or is damaged.
    pub fn load(
        &self,
        split: Split,
        with_values: bool,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Vec<StepRecord>, DatasetError> {
        let is_wanted = |sequence: &u32| Split::of(*sequence) == split;
        let total = (0..self.manifest.sequences).filter(is_wanted).count();
        let (mut done, mut steps) = (0, Vec::new());
        for entry in &self.manifest.shards {
            let sequences = entry.first_sequence..entry.first_sequence + entry.sequences;
            if !sequences.clone().any(|sequence| is_wanted(&sequence)) {
                continue;
            }
            let path = self.folder.join(&entry.file.file);
            let content = read(&self.folder, &entry.file)?;
            let shard = self.layout.open(&content).map_err(|flaw| flaw.at(&path))?;
            let found = shard.blocks.iter().map(|block| block.sequence);
            if !found.eq(sequences) {
                let reason = "it has other sequences than the manifest says".to_owned();
                return Err(DatasetError::Damaged { path, reason });
            }
            let wanted = shard.blocks.iter();
            for block in wanted.filter(|block| is_wanted(&block.sequence)) {
                let found = self.layout.unpack(block, with_values);
                steps.extend(found.map_err(|reason| Flaw::Damaged(reason).at(&path))?);
                done += 1;
                progress(done, total);
            }
        }
        Ok(steps)
    }
}

/// The content of a file that is exactly what the manifest says.
fn read(folder: &Path, entry: &FileEntry) -> Result<Vec<u8>, DatasetError> {
    let path = folder.join(&entry.file);
    let content = read_bounded(&path, entry.bytes)?;
    if entry.matches(&content) {
        Ok(content)
    } else {
        let reason = "its content is not what the manifest names".to_owned();
        Err(DatasetError::Damaged { path, reason })
    }
}

/// A manifest, checked. The version goes first: of another one, nothing else can be relied on.
fn parse(content: &[u8]) -> Result<Manifest, Flaw> {
    let wrong = |error: serde_json::Error| Flaw::Damaged(error.to_string());
    let value: serde_json::Value = serde_json::from_slice(content).map_err(wrong)?;
    let version = value.pointer("/settings/format_version");
    match version.and_then(serde_json::Value::as_u64) {
        Some(version) if version == u64::from(FORMAT_VERSION) => {}
        Some(version) => return Err(Flaw::Version(version)),
        None => return Err("it names no version of the format".to_owned().into()),
    }
    let manifest: Manifest = serde_json::from_value(value).map_err(wrong)?;
    manifest.validate()?;
    Ok(manifest)
}
