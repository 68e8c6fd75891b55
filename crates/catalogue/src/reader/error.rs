//! Why a mesh file could not be read.

use std::fmt::Display;

/// The largest mesh file that is read, in bytes.
pub const MAX_FILE_BYTES: u64 = 256 << 20;

/// Why a mesh file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// The file is larger than any mesh that makes sense to pack.
    #[error(
        "is larger than {} MiB: reduce its triangles, some thousands are enough",
        MAX_FILE_BYTES >> 20
    )]
    TooLarge,
    /// The file's name has an unknown ending.
    #[error("has an ending that is not read: give a .ply, .obj or .stl file")]
    Extension,
    /// The content is not what the format asks for.
    #[error("is no {format} file that can be read: {reason}. Export it again, complete")]
    Format {
        /// The format by its usual name.
        format: &'static str,
        /// What is wrong.
        reason: String,
    },
}

impl ReadError {
    /// A malformed file, with what its parser says put into one line.
    pub(super) fn malformed(format: &'static str, reason: impl Display) -> Self {
        let reason = reason.to_string();
        let words: Vec<&str> = reason.split_whitespace().collect();
        let reason = words.join(" ").trim_end_matches('.').to_owned();
        Self::Format { format, reason }
    }
}
