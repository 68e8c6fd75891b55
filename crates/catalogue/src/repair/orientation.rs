//! Edges of a surface, and which way its triangles wind.

#![allow(
    clippy::indexing_slicing,
    reason = "sides hold triangle numbers of the mesh they were taken from"
)]

use std::collections::BTreeMap;

use nalgebra::Point3;

use crate::error::ObjectError;
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

/// The open sides, with their triangles in order, each in the direction in which its triangle
/// passes it.
pub(super) fn boundary_edges(mesh: &Mesh) -> Vec<(usize, [u32; 2])> {
    let sides = sides(mesh);
    let open = edges(&sides).filter(|edge| is_open(edge)).flatten();
    let mut open: Vec<_> = open
        .map(|side| {
            let (from, to) = side.ends();
            (side.triangle, [from, to])
        })
        .collect();
    open.sort_unstable();
    open
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
pub(super) fn align(mesh: &mut Mesh) -> Result<usize, ObjectError> {
    let found = components(mesh);
    if !found.consistent {
        return Err(ObjectError(
            "has no inside and outside, like a Moebius strip or with edges where walls meet: make it manifold in a mesh editor"
                .to_owned(),
        ));
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

/// Gives for each triangle of a closed surface its shell, and a number above those of all shells.
///
/// Components that are open at an edge which others have too close each other there, so that only
/// together they have an inside.
fn closed_shells(mesh: &Mesh) -> (Vec<usize>, usize) {
    let found = components(mesh);
    let mut shells: Vec<usize> = (0..found.count).collect();
    for edge in edges(&sides(mesh)).filter(|edge| edge.len() > 2) {
        let mut balances = BTreeMap::new();
        for side in edge {
            let component = found.of_triangle[side.triangle];
            *balances.entry(component).or_insert(0) += if side.forward { 1 } else { -1 };
        }
        balances.retain(|_, balance| *balance != 0);
        let mut open = balances.into_keys();
        let Some(first) = open.next() else { continue };
        for other in open {
            let other = shell_of(&mut shells, other);
            shells[other] = shell_of(&mut shells, first);
        }
    }
    let of_triangle = found.of_triangle.iter();
    let of_triangle = of_triangle.map(|component| shell_of(&mut shells, *component));
    (of_triangle.collect(), found.count)
}

/// Gives the component that stands for all of a shell, and shortens the way to it.
fn shell_of(shells: &mut [usize], mut component: usize) -> usize {
    while shells[component] != component {
        shells[component] = shells[shells[component]];
        component = shells[component];
    }
    component
}

/// Turns the shells of a closed surface that face inwards, unless they lie inside another, where
/// they are the wall of a cavity. Leaves out those that face outwards inside another, which would
/// count its space twice.
///
/// Returns how many triangles were turned, and how many shells left out.
pub(super) fn face_outwards(mesh: &mut Mesh) -> (usize, usize) {
    let (of_triangle, count) = closed_shells(mesh);
    let mut shells = vec![Mesh::default(); count];
    for (corners, shell) in mesh.corners().zip(&of_triangle) {
        let shell = &mut shells[*shell];
        let first = shell.vertices.len() as u32;
        shell.vertices.extend(corners);
        shell.triangles.push([first, first + 1, first + 2]);
    }
    let volumes_m3: Vec<f64> = shells.iter().map(Mesh::signed_volume_m3).collect();
    let bounds: Vec<Option<Bounds>> = shells.iter().map(Mesh::bounds).collect();
    let large_m3 = LARGE_SHARE * volumes_m3.iter().map(|volume| volume.abs()).sum::<f64>();
    let contains = |outer: &Bounds, inner: &Bounds| {
        (0..3).all(|axis| {
            outer.lowest[axis] < inner.lowest[axis] && inner.highest[axis] < outer.highest[axis]
        })
    };
    // Outer ones first, since it depends on them which way inner ones face.
    let mut order: Vec<usize> = (0..count).collect();
    let size = |shell: &usize| bounds[*shell].map_or(0.0, |bounds| bounds.extents_m().norm());
    order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let mut turned = vec![false; count];
    let mut left_out = vec![false; count];
    for (rank, shell) in order.iter().copied().enumerate() {
        let Some(inner) = bounds[shell] else { continue };
        let around = order[..rank].iter().copied().filter(|outer| {
            bounds[*outer].is_some_and(|outer| contains(&outer, &inner)) && !left_out[*outer]
        });
        let around: Vec<usize> = around.collect();
        // A file may be inside out as a whole.
        let flipped = around.iter().any(|outer| turned[*outer]);
        let faces_inwards = (volumes_m3[shell] < 0.0) != flipped;
        // Crumbs of scans are judged by their boxes.
        let is_inside = if volumes_m3[shell].abs() < large_m3 {
            faces_inwards && !around.is_empty()
        } else {
            let vertices = &shells[shell].vertices;
            let mut some = vertices
                .iter()
                .step_by(vertices.len().div_ceil(MAX_SAMPLES));
            !around.is_empty()
                && some.all(|vertex| {
                    let windings = around.iter().map(|outer| {
                        let winding = winding(&shells[*outer], vertex);
                        if turned[*outer] { -winding } else { winding }
                    });
                    windings.sum::<f64>() > INSIDE
                })
        };
        turned[shell] = if is_inside {
            flipped
        } else {
            volumes_m3[shell] < 0.0
        };
        left_out[shell] = is_inside && !faces_inwards;
    }
    let marked = of_triangle.iter().map(|shell| turned[*shell]);
    let count = turn(mesh, marked);
    let mut of_triangle = of_triangle.iter();
    mesh.triangles
        .retain(|_| of_triangle.next().is_some_and(|shell| !left_out[*shell]));
    (count, left_out.iter().filter(|out| **out).count())
}

/// Shells of at least this share of all are judged by where they are.
const LARGE_SHARE: f64 = 0.01;

/// A shell is inside others where so many of its vertices, at most, all are.
const MAX_SAMPLES: usize = 16;

/// How often a surface winds around a point inside it, at least: once, and half as often around one
/// that lies on it.
const INSIDE: f64 = 0.75;

/// How often a closed surface winds around a point, by the solid angles of its triangles (Van
/// Oosterom and Strackee, 1983).
fn winding(mesh: &Mesh, point: &Point3<f64>) -> f64 {
    let half_angles = mesh.corners().map(|corners| {
        let [a, b, c] = corners.map(|corner| corner - point);
        let [a_m, b_m, c_m] = [a, b, c].map(|arm| arm.norm());
        let below = a_m * b_m * c_m + a.dot(&b) * c_m + b.dot(&c) * a_m + c.dot(&a) * b_m;
        a.dot(&b.cross(&c)).atan2(below)
    });
    half_angles.sum::<f64>() / std::f64::consts::TAU
}
