//! PCD, the format of the Point Cloud Library, versions 0.5 to 0.7.
//!
//! Written here, as `pcd-rs` 0.13.0 trusts a file's words: one that announces 9 points and packs 12 bytes makes it panic (an
//! index out of range), and 4 bytes make it ask for 4 GiB. It also refuses files without POINTS, and takes those whose WIDTH
//! and HEIGHT contradict POINTS.

mod body;
mod header;
mod lzf;
pub(crate) mod write;

use crate::cloud::Cloud;
use crate::error::FormatError;
use header::{Data, Header};

/// Whether this begins like a PCD file.
pub(crate) fn is_likely(content: &[u8]) -> bool {
    header::lines(content).next().is_some_and(|(line, _)| {
        ["VERSION ", "FIELDS ", "COLUMNS "]
            .iter()
            .any(|keyword| line.starts_with(keyword.as_bytes()))
    })
}

pub(crate) fn parse(content: &[u8]) -> Result<Cloud, FormatError> {
    let (header, body) = Header::parse(content)?;
    let points_m = match header.data {
        Data::Ascii => body::ascii(&header, body)?,
        Data::Binary => body::binary(&header, body)?,
        Data::BinaryCompressed => body::compressed(&header, body)?,
    };
    Cloud::organised(header.width, points_m).map_err(FormatError::pcd)
}
