//! PCD, the format of the Point Cloud Library, versions 0.5 to 0.7.

mod body;
mod header;
mod lzf;
pub(crate) mod write;

use crate::{Cloud, FormatError};
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
