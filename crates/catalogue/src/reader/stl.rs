//! STL, ASCII and binary. Its triangles share no vertices, so equal corners are welded.

use std::fmt::Display;
use std::io::Cursor;

use nalgebra::Point3;

use super::error::ReadError;
use crate::mesh::Mesh;

/// Bytes before the first triangle of a binary file: a comment and the count.
const HEADER_BYTES: usize = 84;
/// Bytes of one triangle of a binary file.
const TRIANGLE_BYTES: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let read = match binary_triangles(bytes) {
        // Many programs begin the comment of a binary file with "solid", the mark of an ASCII file.
        Some(count) if bytes.len() == HEADER_BYTES + count * TRIANGLE_BYTES => {
            let mut content = bytes.to_vec();
            content.iter_mut().take(5).for_each(|byte| *byte = b' ');
            stl_io::read_stl(&mut Cursor::new(content))
        }
        Some(count) if !bytes.starts_with(b"solid") => {
            return Err(malformed(format_args!(
                "its header announces {count} triangles, which take {} bytes, but it has {}",
                HEADER_BYTES.saturating_add(count.saturating_mul(TRIANGLE_BYTES)),
                bytes.len()
            )));
        }
        _ => stl_io::read_stl(&mut Cursor::new(bytes)),
    };
    let read = read.map_err(malformed)?;
    let index =
        |index: usize| u32::try_from(index).map_err(|_| malformed("it has too many vertices"));
    let vertices = read
        .vertices
        .iter()
        .map(|vertex| Point3::from(vertex.0.map(f64::from)));
    let triangles = read.faces.iter().map(|face| {
        let [a, b, c] = face.vertices;
        Ok([index(a)?, index(b)?, index(c)?])
    });
    let triangles = triangles.collect::<Result<_, ReadError>>()?;
    Ok(Mesh {
        vertices: vertices.collect(),
        triangles,
    })
}

fn malformed(reason: impl Display) -> ReadError {
    ReadError::malformed("STL", reason)
}

/// How many triangles the header of a binary file announces.
fn binary_triangles(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEADER_BYTES)?.first_chunk::<4>()?;
    usize::try_from(u32::from_le_bytes(*count)).ok()
}
