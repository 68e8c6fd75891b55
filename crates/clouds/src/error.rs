//! Why a cloud could not be read.

use std::path::PathBuf;

use crate::cloud::MAX_POINTS;

/// Why a file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CloudError {
    /// The system does not give the file.
    #[error("{} cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is no point cloud, or a malformed one.
    #[error("{}: {source}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The fault.
        source: FormatError,
    },
}

/// A fault of a file's content.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// Neither format.
    #[error("is no point cloud: a PCD or PLY file is needed")]
    Unknown,
    /// The file is longer than [`MAX_FILE_BYTES`](crate::MAX_FILE_BYTES).
    #[error("has {0} bytes where at most {max} are read", max = crate::MAX_FILE_BYTES)]
    FileTooLarge(u64),
    /// More points announced than [`MAX_POINTS`].
    #[error("has {0} points where at most {MAX_POINTS} are read")]
    TooManyPoints(usize),
    /// Anything else.
    #[error("is no {format} file that can be read: {reason}")]
    Malformed {
        /// The format.
        format: &'static str,
        /// The fault, in one line.
        reason: String,
    },
}

/// Maximum length of a reason, in characters: it may quote the file.
const LONGEST_REASON: usize = 240;

impl FormatError {
    pub(crate) fn pcd(reason: impl std::fmt::Display) -> Self {
        Self::malformed("PCD", &reason)
    }

    pub(crate) fn ply(reason: impl std::fmt::Display) -> Self {
        Self::malformed("PLY", &reason)
    }

    fn malformed(format: &'static str, reason: &dyn std::fmt::Display) -> Self {
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let whole = words(&reason.to_string());
        let mut reason: String = whole.chars().take(LONGEST_REASON).collect();
        if reason.len() < whole.len() {
            reason.push_str(" ...");
        }
        Self::Malformed { format, reason }
    }

    pub(crate) fn check_points(points: usize) -> Result<(), Self> {
        match points {
            0..=MAX_POINTS => Ok(()),
            _ => Err(Self::TooManyPoints(points)),
        }
    }
}
