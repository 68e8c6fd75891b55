//! Edges of a surface, and which way its triangles wind.

#![allow(
    clippy::indexing_slicing,
    reason = "sides hold triangle numbers of the mesh they were taken from"
)]

use super::error::MeshError;
use crate::hull;
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
    let of_triangle = |(triangle, corners): (usize, &[u32; 3])| {
        hull::sides(*corners).map(|(from, to)| Side {
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
    let marked = found.of_triangle.iter().zip(&found.turned);
    let marked = marked.map(|(component, turned)| {
        let (all, turned_ones) = sizes[*component];
        *turned != (turned_ones * 2 > all)
    });
    Ok(turn(mesh, marked))
}

/// Turns the triangles that are marked; returns how many.
fn turn(mesh: &mut Mesh, marked: impl Iterator<Item = bool>) -> usize {
    let mut count = 0;
    for (corners, marked) in mesh.triangles.iter_mut().zip(marked) {
        if marked {
            corners.swap(1, 2);
            count += 1;
        }
    }
    count
}

/// Turns the components of a closed surface that face inwards, unless they lie inside another, where they are
/// the wall of a cavity; returns how many triangles were turned.
pub(super) fn face_outwards(mesh: &mut Mesh) -> usize {
    let found = components(mesh);
    let mut parts = vec![Mesh::default(); found.count];
    for (corners, component) in mesh.corners().zip(&found.of_triangle) {
        let part = &mut parts[*component];
        let first = part.vertices.len() as u32;
        part.vertices.extend(corners);
        part.triangles.push([first, first + 1, first + 2]);
    }
    let bounds: Vec<Option<Bounds>> = parts.iter().map(Mesh::bounds).collect();
    let is_within = |inner: &Bounds, outer: &Bounds| {
        (0..3).all(|axis| {
            outer.lowest[axis] < inner.lowest[axis] && inner.highest[axis] < outer.highest[axis]
        })
    };
    // No box is within itself.
    let is_inside_another = |component: usize| {
        let inner = bounds[component];
        inner.is_some_and(|inner| {
            bounds
                .iter()
                .flatten()
                .any(|outer| is_within(&inner, outer))
        })
    };
    let turned: Vec<bool> = (0..found.count)
        .map(|component| parts[component].signed_volume_m3() < 0.0 && !is_inside_another(component))
        .collect();
    let marked = found.of_triangle.iter().map(|component| turned[*component]);
    turn(mesh, marked)
}
