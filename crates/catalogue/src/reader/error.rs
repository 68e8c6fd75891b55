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
    #[error("has an ending that is not read: give a .ply, .obj, .stl, .glb or .3mf file")]
    Extension,
    /// The file is something else.
    #[error("is {found} in place of a mesh: {remedy}")]
    NoMesh {
        /// Its kind.
        found: &'static str,
        /// Way out.
        remedy: &'static str,
    },
    /// The content is not what the format asks for.
    #[error("is no {format} file that can be read: {reason}. Export it again, complete")]
    Format {
        /// The format by its usual name.
        format: &'static str,
        /// Fault.
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

    /// Recognises what is often in place of a mesh by how it begins.
    pub(super) fn in_place_of_a_mesh(bytes: &[u8]) -> Option<Self> {
        let start = bytes.trim_ascii_start();
        let start = start.get(..40).unwrap_or(start).to_ascii_lowercase();
        let (found, remedy) = if bytes.trim_ascii().is_empty() {
            ("an empty file", "export it again")
        } else if start.starts_with(b"version https://git-lfs") {
            ("a pointer of Git LFS", "fetch the file with `git lfs pull`")
        } else if start.starts_with(b"<!doctype html") || start.starts_with(b"<html") {
            (
                "a web page",
                "download the file itself, such as by its button 'Raw'",
            )
        } else if start.starts_with(&[0x1f, 0x8b]) {
            ("a file packed by gzip", "unpack it")
        } else {
            return None;
        };
        Some(Self::NoMesh { found, remedy })
    }
}
