//! Files, and which format they have.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::cloud::{Cloud, MAX_POINTS};
use crate::error::{CloudError, FormatError};
use crate::{pcd, ply};

/// The longest file that is read: all points that are possible, at 32 bytes each, and a header.
pub const MAX_FILE_BYTES: u64 = (MAX_POINTS as u64) * 32 + (1 << 20);

/// Reads a PCD or PLY file.
///
/// # Errors
/// [`CloudError`] names the file and what is wrong with it.
pub fn read(path: &Path) -> Result<Cloud, CloudError> {
    let unreadable = |source| CloudError::Read {
        path: path.to_owned(),
        source,
    };
    let malformed = |source| CloudError::Format {
        path: path.to_owned(),
        source,
    };
    let file = File::open(path).map_err(unreadable)?;
    let mut content = Vec::new();
    let mut bounded = file.take(MAX_FILE_BYTES + 1);
    bounded.read_to_end(&mut content).map_err(unreadable)?;
    if content.len() as u64 > MAX_FILE_BYTES {
        let metadata = bounded.into_inner().metadata();
        let bytes = metadata.map_or(content.len() as u64, |metadata| metadata.len());
        return Err(malformed(FormatError::FileTooLarge(bytes)));
    }
    let is_named = |name| {
        let extension = path.extension();
        extension.is_some_and(|extension| extension.eq_ignore_ascii_case(name))
    };
    let parsed = match parse(&content) {
        // By its name it should be one: what it lacks says more than that it is none.
        Err(FormatError::Unknown) if is_named("pcd") => pcd::parse(&content),
        Err(FormatError::Unknown) if is_named("ply") => ply::parse(&content),
        parsed => parsed,
    };
    parsed.map_err(malformed)
}

/// Reads the content of a PCD or PLY file.
///
/// # Errors
/// [`FormatError`] says what is wrong.
pub fn parse(content: &[u8]) -> Result<Cloud, FormatError> {
    if content.starts_with(b"ply\n") || content.starts_with(b"ply\r") {
        ply::parse(content)
    } else if pcd::is_likely(content) {
        pcd::parse(content)
    } else {
        Err(FormatError::Unknown)
    }
}
