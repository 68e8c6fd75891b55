//! Files that are written whole or not at all.
//!
//! What is written appears in its place when all of it is on disk. A kill or a power cut before
//! leaves what was there.
//!
//! ```
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("results/summary.json");
//! ppnpack_files::write_whole(&path, b"{}")?;
//! assert_eq!(std::fs::read(&path)?, b"{}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod staged;

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

pub use staged::StagedFolder;

/// The beginning of the names of what is being written.
const UNFINISHED: &str = ".unfinished-";

/// A file that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be written: {cause}; free some space, or choose another place", path.display())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// The system's error. It is part of the message, and so not a source of its own.
    pub cause: std::io::Error,
}

impl WriteError {
    /// Names the file of a system's error.
    pub fn at(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |cause| Self {
            path: path.to_owned(),
            cause,
        }
    }
}

/// Writes a file so that it either has all of its content or does not change, also after a power
/// cut. Its folder is made where there is none. As any new file, it is readable by whom the
/// process's mask allows.
///
/// # Errors
/// [`WriteError`] names the file.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), WriteError> {
    let write = || -> std::io::Result<()> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        std::fs::create_dir_all(folder)?;
        let mut file = unfinished(folder)?;
        file.write_all(content)?;
        file.as_file().sync_all()?;
        file.persist(path)?;
        // The new name is on disk when its folder is.
        File::open(folder)?.sync_all()
    };
    write().map_err(WriteError::at(path))
}

/// Makes a new file in a folder. Temporary files are private unless asked otherwise; results are
/// not.
fn unfinished(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(UNFINISHED);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unwritable_place_is_named_once_with_its_cause() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        write_whole(&file, b"x").unwrap();
        let error = write_whole(&file.join("below"), b"x").unwrap_err();
        assert!(error.to_string().contains("below cannot be written: "));
        assert!(std::error::Error::source(&error).is_none());
        assert_eq!(std::fs::read(&file).unwrap(), b"x");
    }

    #[cfg(unix)]
    #[test]
    fn what_is_written_is_readable_by_whom_any_new_file_is() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (whole, plain) = (folder.path().join("whole"), folder.path().join("plain"));
        write_whole(&whole, b"x").unwrap();
        std::fs::write(&plain, b"x").unwrap();
        let mode = |path: &Path| path.metadata().unwrap().permissions().mode();
        assert_eq!(mode(&whole), mode(&plain));
    }
}
