//! Wavefront OBJ: positions and faces; whatever else a file says is left out.

use nalgebra::Point3;
use ppnpack_clouds::text::{quoted, words};

use super::coordinates;
use super::polygons::Polygons;
use crate::mesh::Mesh;

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let mut polygons = Polygons::default();
    let mut statement = Vec::new();
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    for (number, line) in (1..).zip(bytes.split(|byte| *byte == end)) {
        let comment = line.iter().position(|byte| *byte == b'#');
        let line = line.get(..comment.unwrap_or(line.len())).unwrap_or(line);
        let line = line.trim_ascii_end();
        if let Some(begun) = line.strip_suffix(b"\\") {
            statement.extend_from_slice(begun);
            statement.push(b' ');
            continue;
        }
        statement.extend_from_slice(line);
        take(&statement, &mut polygons)
            .ok_or_else(|| format!("line {number} has '{}'", quoted(&statement)))?;
        statement.clear();
    }
    Ok(in_order_of_use(polygons.triangulated()?))
}

/// Reads a statement; `None` where it is malformed.
fn take(statement: &[u8], polygons: &mut Polygons) -> Option<()> {
    let mut words = words(statement);
    match words.next() {
        Some(b"v") => polygons.vertices.push(coordinates(words)?),
        Some(b"f") => {
            let count = polygons.vertices.len() as i64;
            let corners = words.map(|word| {
                let position = word.split(|byte| *byte == b'/').next()?;
                let position: i64 = std::str::from_utf8(position).ok()?.parse().ok()?;
                let index = match position {
                    0 => return None,
                    1.. => position - 1,
                    _ => count.checked_add(position)?,
                };
                // One that is missing is found by the check of the mesh.
                Some(u32::try_from(index).unwrap_or(u32::MAX))
            });
            let corners: Vec<u32> = corners.collect::<Option<_>>()?;
            polygons.push(corners);
        }
        _ => {}
    }
    Some(())
}

/// Puts vertices in the order in which triangles name them, without those that none does.
fn in_order_of_use(mut mesh: Mesh) -> Mesh {
    let mut places = vec![None; mesh.vertices.len()];
    let mut vertices: Vec<Point3<f64>> = Vec::with_capacity(mesh.vertices.len());
    for corner in mesh.triangles.iter_mut().flatten() {
        let Some((place, vertex)) = places
            .get_mut(*corner as usize)
            .zip(mesh.vertices.get(*corner as usize))
        else {
            *corner = u32::MAX;
            continue;
        };
        *corner = *place.get_or_insert_with(|| {
            vertices.push(*vertex);
            vertices.len() as u32 - 1
        });
    }
    Mesh { vertices, ..mesh }
}
