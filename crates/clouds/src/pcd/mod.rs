//! PCD, the format of the Point Cloud Library, versions 0.5 to 0.7.
//!
//! Written here, as `pcd-rs` 0.13.0 trusts a file's words: one that announces 9 points and packs 12
//! bytes makes it panic (an index out of range), and 4 bytes make it ask for 4 GiB. It also refuses
//! files without POINTS, and takes those whose WIDTH and HEIGHT contradict POINTS.

mod body;
mod header;
mod lzf;

use crate::cloud::Cloud;
use crate::error::FormatError;
use header::Header;

/// Says whether this begins like a PCD file.
pub(crate) fn is_likely(content: &[u8]) -> bool {
    let keywords: [&[u8]; 3] = [b"VERSION ", b"FIELDS ", b"COLUMNS "];
    let first = header::lines(content).next();
    first.is_some_and(|(line, _)| keywords.iter().any(|keyword| line.starts_with(keyword)))
}

pub(crate) fn parse(content: &[u8]) -> Result<Cloud, FormatError> {
    let (header, body) = Header::parse(content)?;
    let points_m = (header.read_body)(&header, body)?;
    Cloud::organised(header.width, points_m).map_err(FormatError::pcd)
}

fn refused<T>(reason: impl std::fmt::Display) -> Result<T, FormatError> {
    Err(FormatError::pcd(reason))
}

/// Gives the content of a binary PCD file with a cloud's points, holes included.
pub fn to_pcd(cloud: &Cloud) -> Vec<u8> {
    let header = format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n\
         WIDTH {}\nHEIGHT {}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
        cloud.width(),
        cloud.height(),
        cloud.points_m().len()
    );
    let mut content = header.into_bytes();
    let sides_m = cloud.points_m().iter().flat_map(|point| point.iter());
    content.extend(sides_m.flat_map(|side_m| side_m.to_le_bytes()));
    content
}
