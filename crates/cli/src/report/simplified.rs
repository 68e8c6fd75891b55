//! Meshes of few, quantised vertices, which a page can carry.

use std::collections::{HashMap, HashSet};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nalgebra::{Point3, Vector3};
use ppnpack_packing::scene::model::mesh::{Bounds, Mesh};
use serde::Serialize;

/// Numbers of cells along the longest side of what is simplified, from fine to coarse.
const FINENESS: [u16; 8] = [48, 32, 24, 16, 11, 8, 5, 3];

/// Maximum of a quantised coordinate.
const GREATEST: f64 = 65_535.0;

/// A mesh whose coordinates are whole steps above its lowest corner. Both lists are base64 of
/// 16-bit numbers, the low byte first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct QuantisedMesh {
    /// The lowest corner, in metres.
    lowest_m: [f64; 3],
    /// The length of a step, in metres.
    step_m: f64,
    /// Three coordinates a vertex.
    vertices: String,
    /// Three vertices a triangle.
    triangles: String,
}

impl QuantisedMesh {
    /// Simplifies a mesh to at most so many vertices (never fewer than the eight of its box); none
    /// of a mesh without vertices.
    pub(super) fn of(mesh: &Mesh, most_vertices: usize) -> Option<Self> {
        let bounds = Bounds::of(&mesh.vertices)?;
        let longest_m = bounds.extents_m().max();
        let few = few_vertices(mesh, &bounds, most_vertices);
        let step_m = (longest_m / GREATEST).max(f64::MIN_POSITIVE);
        let vertices = few.vertices.iter().flat_map(|vertex| {
            let steps = (vertex - bounds.lowest) / step_m;
            [steps.x, steps.y, steps.z].map(|step| step.round().clamp(0.0, GREATEST) as u16)
        });
        let corners = few.triangles.iter().flatten();
        let corners = corners.map(|corner| u16::try_from(*corner).unwrap_or(u16::MAX));
        Some(Self {
            lowest_m: bounds.lowest.coords.into(),
            step_m,
            vertices: encoded(vertices),
            triangles: encoded(corners),
        })
    }
}

fn encoded(numbers: impl Iterator<Item = u16>) -> String {
    let bytes: Vec<u8> = numbers.flat_map(u16::to_le_bytes).collect();
    STANDARD.encode(bytes)
}

/// Gives the mesh itself where it is small enough, else with its vertices merged on the finest
/// lattice that leaves few enough, else its box.
fn few_vertices(mesh: &Mesh, bounds: &Bounds, most: usize) -> Mesh {
    let most = most.min(usize::from(u16::MAX));
    if mesh.vertices.len() <= most {
        return mesh.clone();
    }
    let mut fineness = FINENESS.into_iter();
    let merged = fineness.find_map(|cells| merged(mesh, bounds, cells, most));
    merged.unwrap_or_else(|| bounds.mesh())
}

/// Merges all vertices in a cell of a lattice in their mean; none where more than so many are left.
fn merged(mesh: &Mesh, bounds: &Bounds, cells: u16, most: usize) -> Option<Mesh> {
    let cell_m = bounds.extents_m().max() / f64::from(cells);
    let mut numbers: HashMap<[u16; 3], u32> = HashMap::new();
    let mut sums: Vec<(Vector3<f64>, f64)> = Vec::new();
    let mut number_of = Vec::with_capacity(mesh.vertices.len());
    for vertex in &mesh.vertices {
        let at = (vertex - bounds.lowest) / cell_m;
        let cell = [at.x, at.y, at.z].map(|along| along as u16);
        let next = u32::try_from(sums.len()).ok()?;
        let number = *numbers.entry(cell).or_insert(next);
        if number == next {
            sums.push((Vector3::zeros(), 0.0));
        }
        if sums.len() > most {
            return None;
        }
        if let Some((sum, count)) = sums.get_mut(number as usize) {
            *sum += vertex.coords;
            *count += 1.0;
        }
        number_of.push(number);
    }
    let means = sums.iter().map(|(sum, count)| Point3::from(sum / *count));
    Some(Mesh {
        vertices: means.collect(),
        triangles: kept(&mesh.triangles, &number_of),
    })
}

/// Gives the triangles whose corners were not merged with each other, each once.
fn kept(triangles: &[[u32; 3]], number_of: &[u32]) -> Vec<[u32; 3]> {
    let mut seen = HashSet::new();
    let number = |corner: u32| number_of.get(corner as usize).copied();
    let corners = |[a, b, c]: &[u32; 3]| Some([number(*a)?, number(*b)?, number(*c)?]);
    let numbered = triangles.iter().filter_map(corners);
    let numbered = numbered.filter(|[a, b, c]| a != b && b != c && c != a);
    let once = numbered.filter(|triangle| {
        let mut corners = *triangle;
        corners.sort_unstable();
        seen.insert(corners)
    });
    once.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The 16-bit numbers in a text.
    fn decoded(text: &str) -> Vec<u16> {
        let bytes = STANDARD.decode(text).unwrap();
        let numbers = bytes.chunks_exact(2);
        let numbers = numbers.map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
        numbers.collect()
    }

    /// A sphere's surface of 20 cm, of `rings` times `rings` vertices.
    fn sphere(rings: u32) -> Mesh {
        let angle = |part: u32| f64::from(part) / f64::from(rings) * std::f64::consts::PI;
        let points = (0..rings * rings).map(|index| {
            let (up, around) = (angle(index / rings), 2.0 * angle(index % rings));
            let (sin, cos) = up.sin_cos();
            Point3::new(sin * around.cos(), sin * around.sin(), cos) * 0.1
        });
        let quads = (0..rings * (rings - 1)).map(|at| (at, at + 1, at + rings));
        Mesh {
            vertices: points.collect(),
            triangles: quads.map(|(a, b, c)| [a, b, c]).collect(),
        }
    }

    #[test]
    fn a_small_mesh_keeps_its_vertices_to_a_step() {
        let mesh = Mesh::cuboid([-0.05, 0.0, 0.01], [0.05, 0.02, 0.03]);
        let quantised = QuantisedMesh::of(&mesh, 100).unwrap();
        let numbers = decoded(&quantised.vertices);
        assert_eq!(numbers.len(), 3 * mesh.vertices.len());
        for (vertex, steps) in mesh.vertices.iter().zip(numbers.chunks_exact(3)) {
            for axis in 0..3 {
                let at_m = quantised.lowest_m[axis] + f64::from(steps[axis]) * quantised.step_m;
                assert!((at_m - vertex[axis]).abs() <= quantised.step_m, "{at_m}");
            }
        }
        let corners = mesh.triangles.iter().flatten().map(|at| *at as u16);
        assert_eq!(decoded(&quantised.triangles), corners.collect::<Vec<u16>>());
    }

    #[test]
    fn a_large_mesh_is_cut_to_the_limit_and_keeps_its_extent() {
        let mesh = sphere(120);
        for most in [1_000, 200, 30] {
            let quantised = QuantisedMesh::of(&mesh, most).unwrap();
            let vertices = decoded(&quantised.vertices);
            let count = vertices.len() / 3;
            assert!(count <= most, "{count} of {most}");
            assert!(!quantised.triangles.is_empty());
            let reach_m = f64::from(*vertices.iter().max().unwrap()) * quantised.step_m;
            assert!(reach_m > 0.14, "{reach_m} m of 0.2 m with {most}");
        }
        // Below any lattice the box is left, and of nothing nothing.
        let quantised = QuantisedMesh::of(&mesh, 2).unwrap();
        assert_eq!(decoded(&quantised.vertices).len(), 3 * 8);
        assert_eq!(QuantisedMesh::of(&Mesh::default(), 100), None);
    }
}
