//! Triangles that add nothing to a surface.

use std::collections::HashMap;

use super::orientation::open_edges;
use crate::mesh::Mesh;

/// A triangle lower than this has no area, in metres.
const FLAT_M: f64 = 1e-9;

/// Removes the triangles that name a vertex twice; returns how many.
pub(super) fn without_collapsed(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    mesh.triangles
        .retain(|[a, b, c]| a != b && b != c && c != a);
    before - mesh.triangles.len()
}

/// Keeps one of the triangles over the same vertices that face the same way, and none of each pair
/// that faces opposite ways, which enclose nothing; returns how many went.
pub(super) fn without_duplicates(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let key = |corners: &[u32; 3]| {
        let mut sorted = *corners;
        sorted.sort_unstable();
        // A cyclic shift of the sorted corners is an even permutation of them.
        let [a, b, c] = *corners;
        let shifts = [[a, b, c], [b, c, a], [c, a, b]];
        (sorted, shifts.contains(&sorted))
    };
    let mut counts: HashMap<[u32; 3], [usize; 2]> = HashMap::with_capacity(before);
    for corners in &mesh.triangles {
        let (sorted, even) = key(corners);
        let [forward, backward] = counts.entry(sorted).or_default();
        *if even { forward } else { backward } += 1;
    }
    mesh.triangles.retain(|corners| {
        let (sorted, even) = key(corners);
        let Some([forward, backward]) = counts.get_mut(&sorted) else {
            return true;
        };
        let (same, opposite) = if even {
            (forward, backward)
        } else {
            (backward, forward)
        };
        // The first of its kind stays, unless it faces another.
        let stays = *same > 0 && *opposite == 0;
        if stays {
            *same = 0;
        }
        stays
    });
    before - mesh.triangles.len()
}

/// Removes triangles without area if the surface stays closed without them; returns how many.
pub(super) fn without_slivers(mesh: &mut Mesh) -> usize {
    let flat: Vec<bool> = mesh
        .corners()
        .map(|[a, b, c]| {
            let sides = [b - a, c - b, a - c].map(|side| side.norm());
            let longest_m = sides.into_iter().fold(0.0, f64::max);
            (b - a).cross(&(c - a)).norm() <= FLAT_M * longest_m
        })
        .collect();
    if !flat.contains(&true) {
        return 0;
    }
    let triangles = mesh.triangles.iter().zip(flat).filter(|(_, flat)| !flat);
    let rest = Mesh {
        vertices: mesh.vertices.clone(),
        triangles: triangles.map(|(corners, _)| *corners).collect(),
    };
    if open_edges(&rest) > 0 {
        return 0;
    }
    let gone = mesh.triangles.len() - rest.triangles.len();
    *mesh = rest;
    gone
}
