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
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is no point cloud, or a malformed one.
    #[error("{}: {source}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: FormatError,
    },
}

/// What is wrong with a file's content.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// Neither format.
    #[error("is no point cloud: a PCD or PLY file is needed")]
    Unknown,
    /// The file is longer than [`MAX_FILE_BYTES`](crate::MAX_FILE_BYTES).
    #[error("has {bytes} bytes where at most {limit} are read")]
    FileTooLarge {
        /// The file's length.
        bytes: u64,
        /// The greatest length.
        limit: u64,
    },
    /// More points than [`MAX_POINTS`].
    #[error("has {points} points where at most {limit} are read")]
    TooManyPoints {
        /// How many it announces.
        points: usize,
        /// The greatest number.
        limit: usize,
    },
    /// Anything else.
    #[error("is no {format} file that can be read: {reason}")]
    Malformed {
        /// The format.
        format: &'static str,
        /// What is wrong, in one line.
        reason: String,
    },
}

/// The longest reason, in characters: it may quote the file.
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
        if points > MAX_POINTS {
            return Err(Self::TooManyPoints {
                points,
                limit: MAX_POINTS,
            });
        }
        Ok(())
    }
}
