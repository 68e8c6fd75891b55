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

/// What reads the content of a format, in the file's unit of length.
type Parser = fn(&[u8]) -> Result<Mesh, ReadError>;

/// The ending of a file's name, in lower case.
pub(crate) fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default();
    ending.to_string_lossy().to_ascii_lowercase()
}

fn parser(path: &Path) -> Result<Parser, ReadError> {
    match ending(path).as_str() {
        "ply" => Ok(ply::parse),
        "obj" => Ok(obj::parse),
        "stl" => Ok(stl::parse),
        _ => Err(ReadError::Extension),
    }
}

/// Whether a file's name ends like that of a mesh.
pub fn is_mesh_file(path: &Path) -> bool {
    parser(path).is_ok()
}

/// The content of a mesh file, refused beyond [`MAX_FILE_BYTES`].
///
/// # Errors
/// [`ReadError`] where the ending is unknown, or the file cannot be read or is too large.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    parser(path)?;
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
    let mut mesh = parser(path)?(bytes)?;
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
mod tests;
