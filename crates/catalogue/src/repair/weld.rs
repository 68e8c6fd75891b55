//! Vertices in the same place become one.

use std::collections::HashMap;

use nalgebra::Point3;

use crate::mesh::Mesh;

/// Makes vertices within `tolerance_m` of each other one, those that are equal where it is 0;
/// returns how many went.
pub(crate) fn weld(mesh: &mut Mesh, tolerance_m: f64) -> usize {
    let before = mesh.vertices.len();
    let replacement = if tolerance_m > 0.0 {
        near(&mesh.vertices, tolerance_m)
    } else {
        equal(&mesh.vertices)
    };
    rename(mesh, &replacement.vertex);
    mesh.vertices = replacement.kept;
    before - mesh.vertices.len()
}

/// Removes the vertices that no triangle names; returns how many.
pub(super) fn without_unused(mesh: &mut Mesh) -> usize {
    let before = mesh.vertices.len();
    let mut used = vec![false; before];
    for corner in mesh.triangles.iter().flatten() {
        if let Some(used) = used.get_mut(*corner as usize) {
            *used = true;
        }
    }
    let mut kept = Vec::with_capacity(before);
    let mut vertex = Vec::with_capacity(before);
    for (point, used) in mesh.vertices.iter().zip(used) {
        vertex.push(kept.len() as u32);
        if used {
            kept.push(*point);
        }
    }
    rename(mesh, &vertex);
    mesh.vertices = kept;
    before - mesh.vertices.len()
}

/// The vertices that stay, and for each former vertex the one that stands for it.
struct Replacement {
    kept: Vec<Point3<f64>>,
    vertex: Vec<u32>,
}

fn rename(mesh: &mut Mesh, vertex: &[u32]) {
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = vertex.get(*corner as usize).copied().unwrap_or(*corner);
    }
}

fn equal(vertices: &[Point3<f64>]) -> Replacement {
    let mut kept: Vec<Point3<f64>> = Vec::with_capacity(vertices.len());
    let mut places: HashMap<[u64; 3], u32> = HashMap::with_capacity(vertices.len());
    let vertex = vertices.iter().map(|point| {
        // Adding zero makes -0 equal to 0 in bits.
        let bits = [point.x, point.y, point.z].map(|at| (at + 0.0).to_bits());
        *places.entry(bits).or_insert_with(|| {
            kept.push(*point);
            (kept.len() - 1) as u32
        })
    });
    let vertex = vertex.collect();
    Replacement { kept, vertex }
}

fn near(vertices: &[Point3<f64>], tolerance_m: f64) -> Replacement {
    let mut kept: Vec<Point3<f64>> = Vec::with_capacity(vertices.len());
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(vertices.len());
    let vertex = vertices.iter().map(|point| {
        let cell = [point.x, point.y, point.z].map(|at| (at / tolerance_m).floor() as i64);
        let around = (0..27).map(|index| [index / 9 - 1, index / 3 % 3 - 1, index % 3 - 1]);
        let neighbours = around.filter_map(|step| {
            let [x, y, z] = cell;
            let [dx, dy, dz] = step;
            cells.get(&[x.wrapping_add(dx), y.wrapping_add(dy), z.wrapping_add(dz)])
        });
        let found = neighbours.flatten().copied().find(|index| {
            kept.get(*index as usize)
                .is_some_and(|other| nalgebra::distance(other, point) <= tolerance_m)
        });
        found.unwrap_or_else(|| {
            let index = kept.len() as u32;
            kept.push(*point);
            cells.entry(cell).or_default().push(index);
            index
        })
    });
    let vertex = vertex.collect();
    Replacement { kept, vertex }
}
