//! Vertices that lie on a side of a triangle which does not name them: the surface looks closed
//! there and is not.

use nalgebra::Point3;

use super::orientation::boundary_edges;
use crate::mesh::Mesh;

/// More open edges than this are no seam between parts.
const MAX_EDGES: usize = 4_000;

/// Cuts triangles with an open side at the vertices of other open sides that lie on it, within a
/// distance; returns how many.
pub(super) fn cut(mesh: &mut Mesh, tolerance_m: f64) -> usize {
    let mut count = 0;
    // A triangle is cut at one of its sides a round.
    for _ in 0..3 {
        let open = boundary_edges(mesh);
        if open.is_empty() || open.len() > MAX_EDGES {
            break;
        }
        let mut vertices: Vec<u32> = open.iter().flat_map(|(_, ends)| *ends).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut last = None;
        for (triangle, [from, to]) in open {
            let mut on_side = on_side(mesh, &vertices, [from, to], tolerance_m);
            let Some(corners) = mesh.triangles.get_mut(triangle) else {
                continue;
            };
            let Some(apex) = corners.iter().copied().find(|at| *at != from && *at != to) else {
                continue;
            };
            on_side.retain(|vertex| *vertex != apex);
            if on_side.is_empty() || last == Some(triangle) {
                continue;
            }
            last = Some(triangle);
            let stops: Vec<u32> = [vec![from], on_side, vec![to]].concat();
            let mut pieces = stops.iter().zip(stops.iter().skip(1));
            let mut piece = || pieces.next().map(|(from, to)| [*from, *to, apex]);
            if let Some(first) = piece() {
                *corners = first;
            }
            mesh.triangles.extend(std::iter::from_fn(piece));
            count += 1;
        }
    }
    count
}

/// Gives the vertices between the ends of a side, from one end to the other.
fn on_side(mesh: &Mesh, vertices: &[u32], ends: [u32; 2], tolerance_m: f64) -> Vec<u32> {
    let point = |vertex: u32| mesh.vertices.get(vertex as usize);
    let [Some(from), Some(to)] = ends.map(point) else {
        return Vec::new();
    };
    let side = to - from;
    let share = |at: &Point3<f64>| (at - from).dot(&side) / side.norm_squared();
    let mut found: Vec<(f64, u32)> = vertices
        .iter()
        .filter(|vertex| !ends.contains(vertex))
        .filter_map(|vertex| {
            let at = point(*vertex)?;
            let share = share(at);
            let beside_m = (from + side * share - at).norm();
            ((0.0..=1.0).contains(&share) && beside_m <= tolerance_m).then_some((share, *vertex))
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, vertex)| vertex).collect()
}
