//! PLY, ASCII and binary: vertices, faces and strips of triangles.

use nalgebra::Point3;
use ppnpack_clouds::ply_rows::header;

use super::polygons::{Polygons, strip};
use crate::mesh::Mesh;

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let (elements, mut body) = header(bytes)?;
    let mut polygons = Polygons::default();
    let mut strips = Vec::new();
    for element in &elements {
        let place = |names: &[&str]| {
            let mut properties = element.properties.iter();
            properties.position(|property| names.contains(&property.name.as_str()))
        };
        let corners = place(&["vertex_indices", "vertex_index"]);
        let [x, y, z] = [["x"], ["y"], ["z"]].map(|name| place(&name));
        // A coordinate that the file does not give is found by the check for finite vertices.
        let coordinate = |row: &[Vec<f64>], place: Option<usize>| {
            let values = place.and_then(|place| row.get(place));
            values
                .and_then(|values| values.first().copied())
                .unwrap_or(f64::NAN)
        };
        match element.name.as_str() {
            "vertex" => body.rows(element, |row| {
                let vertex = [x, y, z].map(|place| coordinate(row, place));
                polygons.vertices.push(Point3::from(vertex));
            })?,
            "face" => body.rows(element, |row| {
                let numbers = corners.and_then(|place| row.get(place));
                polygons.push(numbers.into_iter().flatten().map(|number| index(*number)));
            })?,
            "tristrips" => body.rows(element, |row| {
                let numbers = corners.and_then(|place| row.get(place));
                strips.extend(numbers.into_iter().flatten().map(|number| index(*number)));
                strips.push(u32::MAX);
            })?,
            _ => body.rows(element, |_| ())?,
        }
    }
    strip(&strips).for_each(|triangle| polygons.push(triangle));
    polygons.triangulated()
}

/// The number of a vertex; -1, which ends a strip, and what is no number of a vertex are
/// `u32::MAX`.
fn index(number: f64) -> u32 {
    if (0.0..f64::from(u32::MAX)).contains(&number) {
        number as u32
    } else {
        u32::MAX
    }
}
