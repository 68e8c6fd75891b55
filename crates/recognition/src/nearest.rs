//! The nearest point of a mesh, looked up in a grid.
//!
//! A pose search asks for the nearest surface millions of times for a few fixed meshes. A grid that
//! knows the nearest triangle of each cell's centre answers in constant time, where a k-d tree
//! descends; the exact point follows from that triangle and, where the foot lies on its border,
//! from its neighbours.

#![allow(
    clippy::indexing_slicing,
    reason = "cells and triangles are numbered by the vectors that hold them"
)]

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};
use ppnpack_catalogue::mesh::Mesh;

/// Reach of the grid beyond the mesh, in metres. Farther points start from the nearest cell.
const MARGIN_M: f64 = 0.012;
/// Number of cells along the mesh's longest side, where the pitch's limits allow it.
const CELLS_ALONG: f64 = 60.0;
/// Minimum and maximum edge of a cell, in metres.
const PITCH_M: (f64, f64) = (0.002, 0.005);
/// Maximum number of cells along one side, for meshes of any size.
const MOST_CELLS_ALONG: f64 = 160.0;

/// Maximum number of steps of the walk from triangle to triangle.
const MAX_STEPS: usize = 6;

/// Stands for no triangle.
const NONE: u32 = u32::MAX;

/// The place of a mesh that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// The point of the surface.
    pub foot: Point3<f64>,
    /// The unit normal of the triangle it lies on.
    pub normal: Vector3<f64>,
    /// The distance, in metres.
    pub distance_m: f64,
}

/// A mesh prepared for lookups of its nearest point.
#[derive(Debug, Clone)]
pub struct NearestSurface {
    triangles: Vec<Triangle>,
    /// Per triangle, those across its three sides.
    neighbours: Vec<[u32; 3]>,
    lowest: Point3<f64>,
    cells_per_m: f64,
    sizes: [usize; 3],
    /// The nearest triangle per cell.
    cells: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Triangle {
    a: Point3<f64>,
    ab: Vector3<f64>,
    ac: Vector3<f64>,
    normal: Vector3<f64>,
}

impl NearestSurface {
    /// Prepares a mesh; `None` where no triangle has an area.
    pub fn of(mesh: &Mesh) -> Option<Self> {
        let mut triangles = Vec::with_capacity(mesh.triangles.len());
        let mut sides: HashMap<(u32, u32), u32> = HashMap::new();
        let mut kept = Vec::with_capacity(mesh.triangles.len());
        for [i, j, k] in &mesh.triangles {
            let vertex = |index: &u32| mesh.vertices.get(*index as usize).copied();
            let (Some(a), Some(b), Some(c)) = (vertex(i), vertex(j), vertex(k)) else {
                continue;
            };
            let (ab, ac) = (b - a, c - a);
            let Some(normal) = ab.cross(&ac).try_normalize(1e-14) else {
                continue;
            };
            let number = triangles.len() as u32;
            for side in [(*i, *j), (*j, *k), (*k, *i)] {
                sides.insert(side, number);
            }
            kept.push([*i, *j, *k]);
            triangles.push(Triangle { a, ab, ac, normal });
        }
        let across = |from: u32, to: u32| sides.get(&(to, from)).copied().unwrap_or(NONE);
        let around = |[i, j, k]: &[u32; 3]| [across(*i, *j), across(*j, *k), across(*k, *i)];
        let neighbours = kept.iter().map(around).collect();
        let bounds = mesh.bounds()?;
        let extents_m = bounds.extents_m().add_scalar(2.0 * MARGIN_M);
        if triangles.is_empty() || !extents_m.iter().all(|extent| extent.is_finite()) {
            return None;
        }
        let longest_m = extents_m.max();
        let pitch_m = (longest_m / CELLS_ALONG)
            .clamp(PITCH_M.0, PITCH_M.1)
            .max(longest_m / MOST_CELLS_ALONG);
        let size = |axis: usize| (extents_m[axis] / pitch_m).ceil().max(1.0) as usize;
        let sizes = [size(0), size(1), size(2)];
        let mut surface = Self {
            triangles,
            neighbours,
            lowest: bounds.lowest - Vector3::repeat(MARGIN_M),
            cells_per_m: 1.0 / pitch_m,
            sizes,
            cells: vec![NONE; sizes.iter().product()],
        };
        surface.fill();
        Some(surface)
    }

    /// Finds the point of the surface nearest to a point with finite coordinates.
    ///
    /// Within the grid, which reaches 12 mm around the mesh, the distance is at most two half
    /// diagonals of a cell above the least, and exact but where parts of the surface that do not
    /// touch are about equally near. Beyond the grid, the foot is a point of the surface near the
    /// nearest.
    #[inline]
    pub fn nearest(&self, point: &Point3<f64>) -> Nearest {
        let mut at = self.cells[self.cell_of(point)] as usize;
        let mut foot = self.triangles[at].foot(point);
        for _ in 0..MAX_STEPS {
            if foot.is_inside {
                break;
            }
            let mut next = at;
            let neighbours = self.neighbours[at].into_iter();
            for neighbour in neighbours.filter(|neighbour| *neighbour != NONE) {
                let other = self.triangles[neighbour as usize].foot(point);
                if other.squared_m2 < foot.squared_m2 * (1.0 - 1e-9) {
                    foot = other;
                    next = neighbour as usize;
                }
            }
            if next == at {
                break;
            }
            at = next;
        }
        Nearest {
            foot: foot.point,
            normal: self.triangles[at].normal,
            distance_m: foot.squared_m2.sqrt(),
        }
    }

    /// Gives the cell that a point lies in, or the nearest one.
    #[inline]
    fn cell_of(&self, point: &Point3<f64>) -> usize {
        let offset = (point - self.lowest) * self.cells_per_m;
        let [nx, ny, nz] = self.sizes;
        // Casts saturate: what is negative becomes 0.
        let x = (offset.x as usize).min(nx - 1);
        let y = (offset.y as usize).min(ny - 1);
        let z = (offset.z as usize).min(nz - 1);
        (x * ny + y) * nz + z
    }

    /// Finds the nearest triangle of each cell: exactly near the surface, and from there outwards,
    /// each cell taking the nearest of its neighbours' triangles, in sweeps.
    fn fill(&mut self) {
        let mut squared_m2 = vec![f64::INFINITY; self.cells.len()];
        self.seed(&mut squared_m2);
        let [_, ny, nz] = self.sizes;
        let count = self.cells.len();
        for number in 0..4 * count {
            let is_back = number / count % 2 == 1;
            let number = number % count;
            let cell = if is_back { count - 1 - number } else { number };
            let place = self.place(cell);
            let steps = [ny * nz, nz, 1];
            for ((at, size), step) in place.into_iter().zip(self.sizes).zip(steps) {
                let before = match is_back {
                    true => (at + 1 < size).then_some(cell + step),
                    false => (at > 0).then(|| cell - step),
                };
                let triangle = before.map_or(NONE, |before| self.cells[before]);
                if triangle != NONE {
                    self.offer(&mut squared_m2, place, triangle);
                }
            }
        }
    }

    fn place(&self, cell: usize) -> [usize; 3] {
        let [_, ny, nz] = self.sizes;
        [cell / (ny * nz), cell / nz % ny, cell % nz]
    }

    /// Gives a cell a triangle where that is nearer than its own.
    fn offer(&mut self, squared_m2: &mut [f64], [x, y, z]: [usize; 3], triangle: u32) {
        let [_, ny, nz] = self.sizes;
        let cell = (x * ny + y) * nz + z;
        if self.cells[cell] == triangle {
            return;
        }
        let offset = Vector3::new(x as f64, y as f64, z as f64).add_scalar(0.5);
        let centre = self.lowest + offset / self.cells_per_m;
        let found = self.triangles[triangle as usize].foot(&centre);
        if found.squared_m2 < squared_m2[cell] {
            squared_m2[cell] = found.squared_m2;
            self.cells[cell] = triangle;
        }
    }

    /// Gives the cells that a triangle passes through, and those beside them, their nearest
    /// triangle.
    fn seed(&mut self, squared_m2: &mut [f64]) {
        let pitch_m = 1.0 / self.cells_per_m;
        for number in 0..self.triangles.len() {
            let triangle = self.triangles[number];
            let (ab, ac) = (triangle.ab, triangle.ac);
            let longest_m = ab.norm().max(ac.norm()).max((ab - ac).norm());
            let steps = (longest_m / pitch_m).ceil().max(1.0) as usize;
            for i in 0..=steps {
                for j in 0..=steps - i {
                    let (s, t) = (i as f64 / steps as f64, j as f64 / steps as f64);
                    let point = triangle.a + ab * s + ac * t;
                    let place = self.place(self.cell_of(&point));
                    let beside = |at: usize, size: usize| at.saturating_sub(1)..(at + 2).min(size);
                    for x in beside(place[0], self.sizes[0]) {
                        for y in beside(place[1], self.sizes[1]) {
                            for z in beside(place[2], self.sizes[2]) {
                                self.offer(squared_m2, [x, y, z], number as u32);
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The nearest point of a triangle.
struct Foot {
    point: Point3<f64>,
    squared_m2: f64,
    /// Whether it lies off the triangle's border.
    is_inside: bool,
}

impl Triangle {
    /// Finds the nearest point by regions (Ericson, Real-Time Collision Detection, 5.1.5).
    #[inline]
    fn foot(&self, point: &Point3<f64>) -> Foot {
        let (s, t, is_inside) = self.coordinates(point);
        let foot = self.a + self.ab * s + self.ac * t;
        Foot {
            point: foot,
            squared_m2: (point - foot).norm_squared(),
            is_inside,
        }
    }

    #[inline]
    fn coordinates(&self, point: &Point3<f64>) -> (f64, f64, bool) {
        let from_a = point - self.a;
        let (d1, d2) = (self.ab.dot(&from_a), self.ac.dot(&from_a));
        if d1 <= 0.0 && d2 <= 0.0 {
            return (0.0, 0.0, false);
        }
        let from_b = from_a - self.ab;
        let (d3, d4) = (self.ab.dot(&from_b), self.ac.dot(&from_b));
        if d3 >= 0.0 && d4 <= d3 {
            return (1.0, 0.0, false);
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return (d1 / (d1 - d3), 0.0, false);
        }
        let from_c = from_a - self.ac;
        let (d5, d6) = (self.ab.dot(&from_c), self.ac.dot(&from_c));
        if d6 >= 0.0 && d5 <= d6 {
            return (0.0, 1.0, false);
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return (0.0, d2 / (d2 - d6), false);
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            let share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return (1.0 - share, share, false);
        }
        let scale = 1.0 / (va + vb + vc);
        (vb * scale, vc * scale, true)
    }
}
