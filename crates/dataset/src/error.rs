//! What can be wrong with a dataset.

use std::path::PathBuf;

use ppnpack_files::WriteError;

use crate::settings::FORMAT_VERSION;

/// Why a dataset could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// A file cannot be read.
    #[error("{} cannot be read: {source}; give the folder of a finished dataset, or make it once more", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file is of another version of the format.
    #[error(
        "{} has version {found} of the format, but this program reads version {FORMAT_VERSION}: make the dataset \
         anew, or use the program that made it",
        path.display()
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version; 0 where it names none.
        found: u64,
    },
    /// A file is not what it should be.
    #[error("{} is damaged: {reason}; make the dataset again, which keeps its intact files", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The folder has data made with other settings.
    #[error(
        "{} holds data made with other settings ({difference}): ask for the same settings, or choose another folder",
        folder.display()
    )]
    OtherSettings {
        /// The folder.
        folder: PathBuf,
        /// Which settings, with both values.
        difference: String,
    },
    /// Settings that no dataset can have.
    #[error("a dataset cannot have these settings: {0}")]
    Settings(String),
    /// A recorded sequence that does not fit the settings; the program that recorded it is wrong.
    #[error("the record of sequence {sequence} cannot be kept: {reason}")]
    Record {
        /// The sequence.
        sequence: u32,
        /// What is wrong.
        reason: String,
    },
}
