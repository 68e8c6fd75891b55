//! Mesh files: PLY, OBJ, STL, GLB and 3MF, as the field's programs write them.

mod error;
mod glb;
mod obj;
mod ply;
mod polygons;
mod stl;
mod threemf;

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use nalgebra::{Matrix4, Point3};
use ppnpack_clouds::text::number;

use crate::mesh::Mesh;
use crate::repair::MAX_TRIANGLES;
use crate::unit::LengthUnit;

pub use error::{MAX_FILE_BYTES, ReadError};

/// Reader of a format's content, in the file's unit of length.
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
        "glb" => Ok(glb::parse),
        "3mf" => Ok(threemf::parse),
        _ => Err(ReadError::Extension),
    }
}

/// The unit of formats that have one of their own, whatever the unit of other files.
pub(crate) fn own_unit(path: &Path) -> Option<LengthUnit> {
    match ending(path).as_str() {
        "glb" => Some(LengthUnit::Metres),
        "3mf" => Some(LengthUnit::Millimetres),
        _ => None,
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
/// Polygons become triangles. Nothing is checked or repaired: see [`crate::repair`].
///
/// # Errors
/// [`ReadError`] where the ending is unknown or the content malformed.
pub fn parse(path: &Path, bytes: &[u8], unit: LengthUnit) -> Result<Mesh, ReadError> {
    let parser = parser(path)?;
    if let Some(error) = ReadError::in_place_of_a_mesh(bytes) {
        return Err(error);
    }
    let mut mesh = parser(&without_mark(bytes))?;
    if unit != LengthUnit::Metres {
        for vertex in &mut mesh.vertices {
            *vertex = Point3::from(vertex.coords * unit.metres());
        }
    }
    Ok(mesh)
}

/// A file without its mark of byte order, as UTF-8 where it is UTF-16.
fn without_mark(bytes: &[u8]) -> Cow<'_, [u8]> {
    let utf16 = |text: &[u8], unit: fn([u8; 2]) -> u16| {
        let (pairs, _) = text.as_chunks::<2>();
        let units: Vec<u16> = pairs.iter().map(|pair| unit(*pair)).collect();
        Cow::Owned(String::from_utf16_lossy(&units).into_bytes())
    };
    match bytes {
        [0xef, 0xbb, 0xbf, text @ ..] => Cow::Borrowed(text),
        [0xff, 0xfe, text @ ..] => utf16(text, u16::from_le_bytes),
        [0xfe, 0xff, text @ ..] => utf16(text, u16::from_be_bytes),
        _ => Cow::Borrowed(bytes),
    }
}

/// The first three of a text's numbers, as coordinates; others after them are left out.
fn coordinates<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> Option<Point3<f64>> {
    let mut next = || Some(f64::from(number(words.next()?)? as f32));
    Some(Point3::new(next()?, next()?, next()?))
}

/// Adds a part of a file in its place. A file may name a part many times, so that triangles are
/// counted.
fn add(mesh: &mut Mesh, part: &Mesh, pose: &Matrix4<f64>) -> Result<(), String> {
    if mesh.triangles.len() + part.triangles.len() > MAX_TRIANGLES
        || mesh.vertices.len() + part.vertices.len() > 3 * MAX_TRIANGLES
    {
        return Err(format!(
            "it has more than {MAX_TRIANGLES} triangles: reduce them"
        ));
    }
    let mut part = part.clone();
    for vertex in &mut part.vertices {
        *vertex = pose.transform_point(vertex);
    }
    if pose.determinant() < 0.0 {
        // Of a mirrored part.
        part.triangles
            .iter_mut()
            .for_each(|corners| corners.swap(1, 2));
    }
    mesh.append(&part);
    Ok(())
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
