//! Mesh files: PLY, OBJ and STL.

mod error;
mod obj;
mod ply;
mod stl;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use nalgebra::Point3;

use crate::mesh::Mesh;
use crate::unit::LengthUnit;

pub use error::{MAX_FILE_BYTES, ReadError};

/// The endings of file names that are read as meshes, in lower case.
pub const EXTENSIONS: [&str; 3] = ["ply", "obj", "stl"];

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

#[cfg(test)]
pub(crate) mod tests;
