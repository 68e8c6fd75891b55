//! Mesh files: PLY, OBJ, STL, GLB and 3MF, as the field's programs write them.

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

use crate::error::ObjectError;
use crate::mesh::Mesh;
use crate::repair::MAX_TRIANGLES;
use crate::unit::LengthUnit;

/// The largest mesh file that is read, in bytes.
pub const MAX_FILE_BYTES: u64 = 256 << 20;

/// A format's name, and the reader of its content in the file's unit of length.
type Format = (&'static str, fn(&[u8]) -> Result<Mesh, String>);

/// The ending of a file's name, in lower case.
pub(crate) fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default();
    ending.to_string_lossy().to_ascii_lowercase()
}

fn format(path: &Path) -> Result<Format, ObjectError> {
    match ending(path).as_str() {
        "ply" => Ok(("PLY", ply::read)),
        "obj" => Ok(("OBJ", obj::read)),
        "stl" => Ok(("STL", stl::read)),
        "glb" => Ok(("GLB", glb::read)),
        "3mf" => Ok(("3MF", threemf::read)),
        _ => Err(ObjectError(
            "has an ending that is not read: give a .ply, .obj, .stl, .glb or .3mf file".to_owned(),
        )),
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
    format(path).is_ok()
}

/// The content of a mesh file, refused beyond [`MAX_FILE_BYTES`].
///
/// # Errors
/// [`ObjectError`] where the ending is unknown, or the file cannot be read or is too large.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, ObjectError> {
    format(path)?;
    let mut bytes = Vec::new();
    // Counted while reading, since what a file system says of a length need not hold.
    let read = |file: File| file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes);
    let length = File::open(path).and_then(read);
    match length.map_err(|error| ObjectError(format!("cannot be read: {error}")))? {
        length if length as u64 > MAX_FILE_BYTES => Err(ObjectError(format!(
            "is larger than {} MiB: reduce its triangles, some thousands are enough",
            MAX_FILE_BYTES >> 20
        ))),
        _ => Ok(bytes),
    }
}

/// A malformed file, with what its parser says put into one line.
fn malformed(format: &str, reason: &str) -> ObjectError {
    let words: Vec<&str> = reason.split_whitespace().collect();
    let reason = words.join(" ");
    let reason = reason.trim_end_matches('.');
    ObjectError(format!(
        "is no {format} file that can be read: {reason}. Export it again, complete"
    ))
}

/// Recognises what is often in place of a mesh by how it begins; with the way out.
fn in_place_of_a_mesh(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    let start = bytes.trim_ascii_start();
    let start = start.get(..40).unwrap_or(start).to_ascii_lowercase();
    if start.is_empty() {
        Some(("an empty file", "export it again"))
    } else if start.starts_with(b"version https://git-lfs") {
        Some(("a pointer of Git LFS", "fetch the file with `git lfs pull`"))
    } else if start.starts_with(b"<!doctype html") || start.starts_with(b"<html") {
        Some((
            "a web page",
            "download the file itself, such as by its button 'Raw'",
        ))
    } else if start.starts_with(&[0x1f, 0x8b]) {
        Some(("a file packed by gzip", "unpack it"))
    } else {
        None
    }
}

/// The mesh in a file's content, whose format follows from the path's ending, in metres.
///
/// Polygons become triangles. Nothing is checked or repaired: see [`crate::repair`].
///
/// # Errors
/// [`ObjectError`] where the ending is unknown or the content malformed.
pub fn parse(path: &Path, bytes: &[u8], unit: LengthUnit) -> Result<Mesh, ObjectError> {
    let (format, read) = format(path)?;
    if let Some((found, remedy)) = in_place_of_a_mesh(bytes) {
        return Err(ObjectError(format!(
            "is {found} in place of a mesh: {remedy}"
        )));
    }
    let mut mesh = read(&without_mark(bytes)).map_err(|reason| malformed(format, &reason))?;
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
/// [`ObjectError`] where the file cannot be read or is malformed.
pub fn read(path: &Path, unit: LengthUnit) -> Result<Mesh, ObjectError> {
    parse(path, &read_bytes(path)?, unit)
}

#[cfg(test)]
mod tests;
