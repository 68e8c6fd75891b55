//! Faults of a dataset.

use std::path::PathBuf;

use ppnpack_files::WriteError;

use crate::settings::FORMAT_VERSION;

/// A dataset that could not be written or read; faults of a file come with its path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// A file that cannot be read.
    #[error("{} cannot be read: {1}; give the folder of a finished dataset, or make it once more", .0.display())]
    Read(PathBuf, #[source] std::io::Error),
    /// A file that cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file of another version of the format, 0 where it names none.
    #[error(
        "{} has version {1} of the format, but this program reads version {FORMAT_VERSION}: make the dataset \
         anew, or use the program that made it",
        .0.display()
    )]
    Version(PathBuf, u64),
    /// A file that is not what it should be, with the fault.
    #[error("{} is damaged: {1}; make the dataset again, which keeps its intact files", .0.display())]
    Damaged(PathBuf, String),
    /// A folder of data made with other settings, with those that differ and both values.
    #[error(
        "{} holds data made with other settings ({1}): ask for the same settings, or choose another folder",
        .0.display()
    )]
    OtherSettings(PathBuf, String),
    /// Settings that no dataset can have.
    #[error("a dataset cannot have these settings: {0}")]
    Settings(String),
    /// A recorded sequence, by its number, that does not fit the settings, with the fault; the
    /// program that recorded it is wrong.
    #[error("the record of sequence {0} cannot be kept: {1}")]
    Record(u32, String),
}
