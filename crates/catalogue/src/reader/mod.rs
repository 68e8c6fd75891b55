//! Mesh files: PLY, OBJ and STL.

mod obj;
mod ply;
mod stl;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use nalgebra::Point3;

use crate::mesh::Mesh;
use crate::unit::LengthUnit;

/// The largest mesh file that is read, in bytes.
pub const MAX_FILE_BYTES: u64 = 256 << 20;

/// The endings of file names that are read as meshes, in lower case.
pub const EXTENSIONS: [&str; 3] = ["ply", "obj", "stl"];

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
    fn malformed(format: &'static str, reason: &str) -> Self {
        let words: Vec<&str> = reason.split_whitespace().collect();
        let reason = words.join(" ").trim_end_matches('.').to_owned();
        Self::Format { format, reason }
    }
}

/// A mesh file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Ply,
    Obj,
    Stl,
}

impl Format {
    fn of(path: &Path) -> Result<Self, ReadError> {
        let extension = path
            .extension()
            .and_then(|extension| extension.to_str())
            .unwrap_or("");
        match extension.to_ascii_lowercase().as_str() {
            "ply" => Ok(Self::Ply),
            "obj" => Ok(Self::Obj),
            "stl" => Ok(Self::Stl),
            _ => Err(ReadError::Extension),
        }
    }
}

/// Whether a file's name ends like that of a mesh.
pub fn is_mesh_file(path: &Path) -> bool {
    Format::of(path).is_ok()
}

/// The content of a mesh file, refused beyond [`MAX_FILE_BYTES`].
///
/// # Errors
/// [`ReadError`] where the ending is unknown, or the file cannot be read or is too large.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    Format::of(path)?;
    let file = File::open(path)?;
    let mut bytes = Vec::new();
    // Counted while reading, since what a file system says of a length need not hold.
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        Err(ReadError::TooLarge)
    } else {
        Ok(bytes)
    }
}

/// The mesh in a file's content, whose format follows from the path's ending, in metres.
///
/// Polygons are split into fans of triangles. Nothing is checked or repaired: see
/// [`crate::repair`].
///
/// # Errors
/// [`ReadError`] where the ending is unknown or the content malformed.
pub fn parse(path: &Path, bytes: &[u8], unit: LengthUnit) -> Result<Mesh, ReadError> {
    let mut mesh = match Format::of(path)? {
        Format::Ply => ply::parse(bytes)?,
        Format::Obj => obj::parse(bytes)?,
        Format::Stl => stl::parse(bytes)?,
    };
    if unit != LengthUnit::Metres {
        for vertex in &mut mesh.vertices {
            *vertex = Point3::from(vertex.coords * unit.metres());
        }
    }
    Ok(mesh)
}

/// Reads a mesh file, in metres.
///
/// # Errors
/// [`ReadError`] where the file cannot be read or is malformed.
pub fn read(path: &Path, unit: LengthUnit) -> Result<Mesh, ReadError> {
    parse(path, &read_bytes(path)?, unit)
}

/// The triangles of a polygon, as a fan around its first corner.
fn fan(polygon: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let first = polygon.first().copied().unwrap_or_default();
    polygon
        .windows(2)
        .skip(1)
        .filter_map(move |edge| match edge {
            [from, to] => Some([first, *from, *to]),
            _ => None,
        })
}

#[cfg(test)]
pub(crate) mod tests;
