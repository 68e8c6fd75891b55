//! The mark of a database: the number of its last commit, in a file beside it.
//!
//! A database whose last commit is damaged goes on with the one before, as after a crash in the
//! middle of the last. The mark tells the two apart, as it is written once a commit is on disk.
//! Nobody waits for it: after a power failure it may be behind, never ahead.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Size of a mark: the number of the last commit, and its complement.
const BYTES: usize = 16;

fn path_of(database: &Path) -> PathBuf {
    let mut name = database.as_os_str().to_owned();
    name.push(".revision");
    name.into()
}

/// The mark of a database, open to be written.
pub(super) struct Mark(File);

impl Mark {
    /// Opens the mark of a database, and begins it where there is none.
    pub(super) fn open(database: &Path) -> io::Result<Self> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        options.open(path_of(database)).map(Self)
    }

    /// Reads the number of a commit that was on disk; zero where the mark is new or damaged.
    pub(super) fn read(&mut self) -> io::Result<u64> {
        let mut bytes = [0; BYTES];
        self.0.seek(SeekFrom::Start(0))?;
        match self.0.read_exact(&mut bytes) {
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(0),
            read => read?,
        }
        let noted = u128::from_le_bytes(bytes);
        let (revision, complement) = (noted as u64, (noted >> 64) as u64);
        Ok(if complement == !revision { revision } else { 0 })
    }

    /// Notes that a commit is on disk. Where that fails, the mark stays behind and tells less.
    pub(super) fn write(&mut self, revision: u64) {
        let noted = u128::from(revision) | u128::from(!revision) << 64;
        let begun = self.0.seek(SeekFrom::Start(0));
        if let Err(error) = begun.and_then(|_| self.0.write_all(&noted.to_le_bytes())) {
            tracing::warn!(%error, revision, "the mark of a database cannot be written");
        }
    }
}

/// Removes the mark of a database that is put aside, or of which an older copy counts from now on.
///
/// # Errors
/// Those of the system.
pub fn remove(database: &Path) -> io::Result<()> {
    match fs::remove_file(path_of(database)) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        removed => removed,
    }
}
