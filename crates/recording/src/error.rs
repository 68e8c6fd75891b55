//! What keeps a recording from being written or read.

use std::path::PathBuf;
use std::thread::JoinHandle;

/// What keeps a recording from being written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// A file or a folder cannot be used.
    #[error("{} cannot be {action}: {source}", path.display())]
    File {
        /// Which one.
        path: PathBuf,
        /// What was to be done with it, such as `read`.
        action: &'static str,
        /// Why it could not.
        source: std::io::Error,
    },
    /// The file is no recording at all.
    #[error("{} is no MCAP file: recordings are those that `ppnpack record` writes", path.display())]
    NoRecording {
        /// Which one.
        path: PathBuf,
    },
    /// The file is damaged.
    #[error(
        "{} is damaged at byte {offset}: {reason}; what is before that can be read",
        path.display()
    )]
    Damaged {
        /// Which one.
        path: PathBuf,
        /// How many bytes are good.
        offset: u64,
        /// What is wrong there.
        reason: String,
    },
    /// A message cannot be written.
    #[error("{} cannot be written: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The streams cannot be read.
    #[error(transparent)]
    Service(#[from] ppnpack_service::ServiceError),
    /// A thread ended by a panic.
    #[error("a thread of the recorder ended by a panic")]
    Thread,
    /// Messages that cannot be compared.
    #[error("messages that cannot be compared: {0}")]
    Message(String),
}

/// What a thread gives at its end.
pub(crate) fn joined<T>(thread: JoinHandle<T>) -> Result<T, RecordingError> {
    thread.join().map_err(|_| RecordingError::Thread)
}
