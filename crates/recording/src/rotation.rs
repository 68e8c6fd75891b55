//! When a recording goes on in another file, and how many files are kept.

use std::path::{Path, PathBuf};
use std::time::Duration;

use time::OffsetDateTime;

use crate::error::RecordingError;

const PREFIX: &str = "ppnpack-";

const SUFFIX: &str = ".mcap";

/// When a recording goes on in another file, and how many files are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rotation {
    /// A file of this size is followed by another one, in bytes.
    pub size_bytes: u64,
    /// A file that was begun so long ago is followed by another one.
    pub age: Option<Duration>,
    /// Maximum of recordings in the folder; the oldest ones are deleted. `None`: all are kept.
    pub keep: Option<usize>,
}

impl Default for Rotation {
    fn default() -> Self {
        Self {
            size_bytes: 1 << 30,
            age: None,
            keep: None,
        }
    }
}

/// Names a file that is begun now, such as `ppnpack-20260131T235959Z-000001.mcap`. The number tells
/// those of one second apart.
pub(crate) fn name(folder: &Path, now_ns: u64, number: u64) -> PathBuf {
    let at = utc(now_ns / 1_000_000_000);
    folder.join(format!("{PREFIX}{at}-{number:06}{SUFFIX}"))
}

/// Deletes the oldest recordings of a folder, by their names, until no more than `keep` are left.
/// Gives the deleted ones.
pub(crate) fn delete_oldest(folder: &Path, keep: usize) -> Result<Vec<PathBuf>, RecordingError> {
    let failed = |source| RecordingError::File {
        path: folder.to_owned(),
        action: "listed",
        source,
    };
    let mut recordings = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_name().and_then(|name| name.to_str());
        if name.is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX)) {
            recordings.push(path);
        }
    }
    recordings.sort();
    let surplus = recordings.len().saturating_sub(keep);
    recordings.truncate(surplus);
    for path in &recordings {
        std::fs::remove_file(path).map_err(|source| RecordingError::File {
            path: path.clone(),
            action: "deleted",
            source,
        })?;
    }
    Ok(recordings)
}

/// Writes a time of the Gregorian calendar in UTC, such as `20260131T235959Z`.
pub fn utc(seconds: u64) -> String {
    let seconds = i64::try_from(seconds).unwrap_or(i64::MAX);
    // What is past the calendar's end is no time of a recording.
    let at = OffsetDateTime::from_unix_timestamp(seconds).unwrap_or(OffsetDateTime::UNIX_EPOCH);
    let (year, month, day) = at.to_calendar_date();
    let (hour, minute, second) = at.to_hms();
    let month = u8::from(month);
    format!("{year:04}{month:02}{day:02}T{hour:02}{minute:02}{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_are_deleted() {
        let folder = tempfile::tempdir().unwrap();
        let at = |seconds: u64, number: u64| {
            let path = name(folder.path(), seconds * 1_000_000_000, number);
            std::fs::write(&path, "").unwrap();
            path
        };
        let (first, second, third) = (at(0, 9), at(0, 10), at(951_868_799, 1));
        let notes = folder.path().join("notes.txt");
        std::fs::write(&notes, "").unwrap();
        assert_eq!(
            second,
            folder.path().join("ppnpack-19700101T000000Z-000010.mcap")
        );
        assert!(third.ends_with("ppnpack-20000229T235959Z-000001.mcap"));
        assert_eq!(delete_oldest(folder.path(), 2).unwrap(), [first]);
        assert_eq!(delete_oldest(folder.path(), 0).unwrap(), [second, third]);
        assert!(notes.exists());
    }
}
