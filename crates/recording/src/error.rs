//! Reasons why a recording cannot be written or read.

use std::path::PathBuf;
use std::thread::JoinHandle;

/// A reason why a recording cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// A file or a folder cannot be used.
    #[error("{} cannot be {action}: {source}", path.display())]
    File {
        /// Its path.
        path: PathBuf,
        /// The act that failed, such as `read`.
        action: &'static str,
        /// The cause.
        source: std::io::Error,
    },
    /// The file is no recording at all.
    #[error("{} is no MCAP file: recordings are those that `ppnpack record` writes", path.display())]
    NoRecording {
        /// Its path.
        path: PathBuf,
    },
    /// The file is damaged.
    #[error(
        "{} is damaged at byte {offset}: {reason}; what is before that can be read",
        path.display()
    )]
    Damaged {
        /// Its path.
        path: PathBuf,
        /// How many bytes are good.
        offset: u64,
        /// The fault there.
        reason: String,
    },
    /// The streams cannot be read.
    #[error(transparent)]
    Service(#[from] ppnpack_service::ServiceError),
    /// A thread ended by a panic.
    #[error("a thread of the recorder ended by a panic")]
    Thread,
    /// Two messages cannot be compared, or one has no schema.
    #[error("messages that cannot be compared: {0}")]
    Message(String),
}

pub(crate) fn joined<T>(thread: JoinHandle<T>) -> Result<T, RecordingError> {
    thread.join().map_err(|_| RecordingError::Thread)
}
