//! STL, ASCII and binary. Its triangles share no vertices, so equal corners are welded.

use nalgebra::Point3;
use ppnpack_clouds::text::{quoted, words};

use super::coordinates;
use super::polygons::Polygons;
use crate::mesh::Mesh;
use crate::repair::weld;

/// Bytes before the first triangle of a binary file: a comment and the count.
const HEADER_BYTES: usize = 84;
/// Bytes of one triangle of a binary file.
const TRIANGLE_BYTES: usize = 50;

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let announced = bytes.get(80..HEADER_BYTES).and_then(<[u8]>::first_chunk);
    let announced = announced.map(|count| u32::from_le_bytes(*count) as usize);
    let length = |count: usize| HEADER_BYTES.saturating_add(count.saturating_mul(TRIANGLE_BYTES));
    let has_length = announced.is_some_and(|count| length(count) == bytes.len());
    // Many programs begin the comment of a binary file with "solid", the mark of an ASCII file.
    let text = bytes.get(..HEADER_BYTES + 12).unwrap_or(bytes);
    let polygons = match announced {
        Some(count) if has_length || text.contains(&0) => {
            if length(count) > bytes.len() {
                return Err(format!(
                    "its header announces {count} triangles, which take {} bytes, but it has {}",
                    length(count),
                    bytes.len()
                ));
            }
            binary(bytes, count)
        }
        _ => ascii(bytes)?,
    };
    let mut mesh = polygons.triangulated()?;
    weld(&mut mesh, 0.0);
    Ok(mesh)
}

/// Reads so many triangles; other bytes after them are left out.
fn binary(bytes: &[u8], count: usize) -> Polygons {
    let mut polygons = Polygons::default();
    let (triangles, _) = bytes
        .get(HEADER_BYTES..)
        .unwrap_or_default()
        .as_chunks::<TRIANGLE_BYTES>();
    for triangle in triangles.iter().take(count) {
        // After the normal.
        let (numbers, _) = triangle.as_chunks::<4>();
        let numbers: Vec<f64> = numbers
            .iter()
            .skip(3)
            .map(|bytes| f32::from_le_bytes(*bytes).into())
            .collect();
        let (corners, _) = numbers.as_chunks::<3>();
        let first = polygons.vertices.len() as u32;
        let vertices = corners.iter().map(|corner| Point3::from(*corner));
        polygons.vertices.extend(vertices);
        polygons.push(first..first + 3);
    }
    polygons
}

/// Reads all solids of a file, in any case; names and normals are left out.
fn ascii(bytes: &[u8]) -> Result<Polygons, String> {
    let mut polygons = Polygons::default();
    let mut first = 0;
    let mut is_whole = false;
    for line in bytes.split(|byte| matches!(byte, b'\n' | b'\r')) {
        let mut words = words(line);
        let Some(keyword) = words.next() else {
            continue;
        };
        match keyword.to_ascii_lowercase().as_slice() {
            b"vertex" => {
                let vertex = coordinates(words);
                let vertex = vertex.ok_or_else(|| format!("'{}' is no vertex", quoted(line)))?;
                polygons.vertices.push(vertex);
            }
            b"endloop" => {
                let end = polygons.vertices.len() as u32;
                if end < first + 3 {
                    return Err("it has a facet of fewer than 3 vertices".to_owned());
                }
                polygons.push(first..end);
                first = end;
            }
            b"solid" => is_whole = false,
            b"endsolid" | b"end" => is_whole = true,
            b"facet" | b"outer" | b"endfacet" | b"color" => {}
            // A file may begin with anything.
            _ if polygons.vertices.is_empty() => {}
            _ => return Err(format!("it has the line '{}'", quoted(line))),
        }
    }
    if is_whole && first as usize == polygons.vertices.len() {
        Ok(polygons)
    } else {
        Err("its end is missing".to_owned())
    }
}
