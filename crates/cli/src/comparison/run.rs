//! A run's folder, as `ppnpack pack` writes it.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail, ensure};
use serde_json::Value;

use super::parting::{Choice, Line};
use crate::report::container_folder;

/// The version of `summary.json` that is read: that of this program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Larger files are no results of a packing.
const MOST_BYTES: u64 = 256 << 20;

/// A packing that was written.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) folder: PathBuf,
    /// `summary.json`.
    pub(crate) summary: Value,
    /// `placements.csv`, in the order of steps.
    pub(super) placements: Vec<Choice>,
    /// `packed.png`, where there is one.
    pub(super) picture_png: Option<Vec<u8>>,
}

impl Run {
    /// Reads a run's folder.
    ///
    /// # Errors
    /// That it is none, or one of another version, with what to do about it.
    pub(crate) fn read(folder: &Path) -> anyhow::Result<Self> {
        let summary = summary(folder)?;
        let placements = placements(folder, &summary)?;
        Ok(Self {
            folder: folder.to_owned(),
            summary,
            placements,
            picture_png: content(folder, "packed.png").ok(),
        })
    }

    /// Everything the run depended on.
    pub(super) fn settings(&self) -> &Value {
        self.summary.get("settings").unwrap_or(&Value::Null)
    }

    /// Why it ended, for people.
    pub(super) fn ending(&self) -> String {
        let text = |pointer: &str| self.summary.pointer(pointer).and_then(Value::as_str);
        match text("/ending/kind") {
            Some("all-packed") => "everything is packed".to_owned(),
            Some("others-set-aside") => "everything that was not set aside is packed".to_owned(),
            Some("nothing-fits") => {
                let left = self.summary.pointer("/ending/items");
                let count = left.and_then(Value::as_array).map_or(0, Vec::len);
                format!("none of the {count} items in the buffer has a valid placement")
            }
            Some("closed") => format!("closed: {}", text("/ending/why").unwrap_or_default()),
            other => other.unwrap_or("unknown").to_owned(),
        }
    }
}

/// A file of the folder, whole.
fn content(folder: &Path, file: &str) -> anyhow::Result<Vec<u8>> {
    let path = folder.join(file);
    let read = || -> std::io::Result<Vec<u8>> {
        let mut content = Vec::new();
        let mut limited = File::open(&path)?.take(MOST_BYTES + 1);
        limited.read_to_end(&mut content)?;
        Ok(content)
    };
    let content = read().map_err(|cause| {
        anyhow!(
            "{} is no run: its {file} cannot be read ({cause}); name a folder that `ppnpack pack --out` wrote",
            folder.display()
        )
    })?;
    ensure!(
        content.len() as u64 <= MOST_BYTES,
        "{} is larger than {MOST_BYTES} bytes, and so not of a run; name a folder that `ppnpack pack --out` wrote",
        path.display()
    );
    Ok(content)
}

/// The summary, of one container and of this version.
fn summary(folder: &Path) -> anyhow::Result<Value> {
    const FILE: &str = "summary.json";
    let unreadable = |why: &str| unreadable(&folder.join(FILE), why);
    let summary: Value = serde_json::from_slice(&content(folder, FILE)?)
        .map_err(|error| unreadable(&error.to_string()))?;
    match summary.get("version").and_then(Value::as_str) {
        Some(VERSION) => {}
        Some(version) => bail!(
            "{} was written by version {version} of ppnpack, and this is {VERSION}: pack again, or compare with that version",
            folder.display()
        ),
        None => return Err(unreadable("it names no version of ppnpack")),
    }
    ensure!(
        summary.get("containers").is_none(),
        "{} holds the report of several containers: compare one of them, such as {}",
        folder.display(),
        folder.join(container_folder(1)).display()
    );
    match summary.get("settings").is_some_and(Value::is_object) {
        true => Ok(summary),
        false => Err(unreadable("it has no settings")),
    }
}

fn placements(folder: &Path, summary: &Value) -> anyhow::Result<Vec<Choice>> {
    const FILE: &str = "placements.csv";
    let unreadable = |why: &str| unreadable(&folder.join(FILE), why);
    let cell_m = summary.pointer("/settings/grid/resolution/cell_m");
    let cell_m = cell_m.and_then(Value::as_f64);
    let cell_m = cell_m.ok_or_else(|| unreadable("summary.json names no cell size for it"))?;
    let text = content(folder, FILE)?;
    let mut reader = csv::Reader::from_reader(text.as_slice());
    let lines: Result<Vec<Line>, csv::Error> = reader.deserialize().collect();
    let lines = lines.map_err(|error| unreadable(&error.to_string()))?;
    let choices = lines.into_iter().map(|line| Choice::of(line, cell_m));
    Ok(choices.collect())
}

/// Of a file that is there but no result of a packing.
fn unreadable(file: &Path, why: &str) -> anyhow::Error {
    anyhow!(
        "{} is no result of a packing: {why}; pack again",
        file.display()
    )
}
