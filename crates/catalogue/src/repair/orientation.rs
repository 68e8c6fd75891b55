//! Edges of a surface, and which way its triangles wind.

#![allow(
    clippy::indexing_slicing,
    reason = "sides hold triangle numbers of the mesh they were taken from"
)]

use super::error::MeshError;
use crate::mesh::{Bounds, Mesh};

/// A side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    low: u32,
    high: u32,
    triangle: usize,
    /// Whether the triangle passes it from `low` to `high`.
    forward: bool,
}

impl Side {
    /// The vertices in the order in which the triangle passes them.
    pub(super) fn ends(&self) -> (u32, u32) {
        if self.forward {
            (self.low, self.high)
        } else {
            (self.high, self.low)
        }
    }

    fn edge(&self) -> (u32, u32) {
        (self.low, self.high)
    }
}

/// All sides, those of one edge together.
fn sides(mesh: &Mesh) -> Vec<Side> {
    let of_triangle = |(triangle, [a, b, c]): (usize, &[u32; 3])| {
        [(*a, *b), (*b, *c), (*c, *a)].map(|(from, to)| Side {
            low: from.min(to),
            high: from.max(to),
            triangle,
            forward: from < to,
        })
    };
    let mut sides: Vec<Side> = mesh
        .triangles
        .iter()
        .enumerate()
        .flat_map(of_triangle)
        .collect();
    sides.sort_unstable();
    sides
}

fn edges(sides: &[Side]) -> impl Iterator<Item = &[Side]> {
    sides.chunk_by(|a, b| a.edge() == b.edge())
}

fn is_open(edge: &[Side]) -> bool {
    edge.iter().filter(|side| side.forward).count() * 2 != edge.len()
}

/// How many edges are not passed as often in one direction as in the other.
pub(super) fn open_edges(mesh: &Mesh) -> usize {
    edges(&sides(mesh)).filter(|edge| is_open(edge)).count()
}

/// The sides without a neighbour; `None` where an open edge has several sides.
pub(super) fn boundary(mesh: &Mesh) -> Option<Vec<Side>> {
    let sides = sides(mesh);
    let open = edges(&sides).filter(|edge| is_open(edge));
    open.map(|edge| if let [side] = edge { Some(*side) } else { None })
        .collect()
}

/// For each triangle its component, and whether it must be turned to wind as the component's first.
///
/// Triangles belong together that share an edge which no third one has.
struct Components {
    of_triangle: Vec<usize>,
    turned: Vec<bool>,
    count: usize,
    consistent: bool,
}

fn components(mesh: &Mesh) -> Components {
    let sides = sides(mesh);
    let mut neighbours = vec![Vec::new(); mesh.triangles.len()];
    for edge in edges(&sides) {
        if let [one, other] = edge {
            let against = one.forward == other.forward;
            neighbours[one.triangle].push((other.triangle, against));
            neighbours[other.triangle].push((one.triangle, against));
        }
    }
    const NONE: usize = usize::MAX;
    let mut found = Components {
        of_triangle: vec![NONE; mesh.triangles.len()],
        turned: vec![false; mesh.triangles.len()],
        count: 0,
        consistent: true,
    };
    let mut open = Vec::new();
    for start in 0..mesh.triangles.len() {
        if found.of_triangle[start] != NONE {
            continue;
        }
        found.of_triangle[start] = found.count;
        open.push(start);
        while let Some(triangle) = open.pop() {
            for (neighbour, against) in &neighbours[triangle] {
                let turned = found.turned[triangle] != *against;
                if found.of_triangle[*neighbour] == NONE {
                    found.of_triangle[*neighbour] = found.count;
                    found.turned[*neighbour] = turned;
                    open.push(*neighbour);
                } else if found.turned[*neighbour] != turned {
                    found.consistent = false;
                }
            }
        }
        found.count += 1;
    }
    found
}

/// Turns triangles so that neighbours wind alike; returns how many.
pub(super) fn align(mesh: &mut Mesh) -> Result<usize, MeshError> {
    let found = components(mesh);
    if !found.consistent {
        return Err(MeshError::NotOrientable);
    }
    // The larger share of each component is taken to be right.
    let mut sizes = vec![(0_usize, 0_usize); found.count];
    for (component, turned) in found.of_triangle.iter().zip(&found.turned) {
        sizes[*component].0 += 1;
        sizes[*component].1 += usize::from(*turned);
    }
    let mut count = 0;
    let triangles = mesh
        .triangles
        .iter_mut()
        .zip(found.of_triangle.iter().zip(&found.turned));
    for (corners, (component, turned)) in triangles {
        let (all, turned_ones) = sizes[*component];
        if *turned != (turned_ones * 2 > all) {
            corners.swap(1, 2);
            count += 1;
        }
    }
    Ok(count)
}

/// Turns the components of a closed surface that face inwards, unless they lie inside another, where they are
/// the wall of a cavity; returns how many triangles were turned.
pub(super) fn face_outwards(mesh: &mut Mesh) -> usize {
    let found = components(mesh);
    let mut parts = vec![Mesh::default(); found.count];
    for (triangle, component) in mesh.triangles.iter().zip(&found.of_triangle) {
        parts[*component].triangles.push(*triangle);
    }
    let whole = &mesh.vertices;
    let measured: Vec<(f64, Option<Bounds>)> = parts
        .iter()
        .map(|part| {
            let corners = |index: u32| whole.get(index as usize).copied();
            let points: Vec<_> = part
                .triangles
                .iter()
                .flatten()
                .filter_map(|index| corners(*index))
                .collect();
            let solid = Mesh {
                triangles: (0..points.len() as u32 / 3)
                    .map(|at| [3 * at, 3 * at + 1, 3 * at + 2])
                    .collect(),
                vertices: points,
            };
            (solid.signed_volume_m3(), solid.bounds())
        })
        .collect();
    let inside_another = |component: usize| {
        let (_, Some(bounds)) = &measured[component] else {
            return false;
        };
        measured.iter().enumerate().any(|(other, (_, around))| {
            around.as_ref().is_some_and(|around| {
                other != component
                    && (0..3).all(|axis| {
                        around.lowest[axis] < bounds.lowest[axis]
                            && bounds.highest[axis] < around.highest[axis]
                    })
            })
        })
    };
    let turn: Vec<bool> = (0..found.count)
        .map(|component| measured[component].0 < 0.0 && !inside_another(component))
        .collect();
    let mut count = 0;
    for (corners, component) in mesh.triangles.iter_mut().zip(&found.of_triangle) {
        if turn[*component] {
            corners.swap(1, 2);
            count += 1;
        }
    }
    count
}
