//! Triangle meshes in metres.

use std::ops::Range;

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};

/// A triangle mesh in metres, right-handed, z up; counter-clockwise seen from outside.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Mesh {
    /// Vertex positions, in metres.
    pub vertices: Vec<Point3<f64>>,
    /// Vertex indices per triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// An axis-aligned box that encloses a mesh, in metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// The corner with the lowest coordinates.
    pub lowest: Point3<f64>,
    /// The corner with the greatest coordinates.
    pub highest: Point3<f64>,
}

impl Bounds {
    /// The box around points; `None` where there is none.
    pub fn of(points: &[Point3<f64>]) -> Option<Self> {
        let first = *points.first()?;
        let around = |(lowest, highest): (Point3<f64>, Point3<f64>), point: &Point3<f64>| {
            (lowest.inf(point), highest.sup(point))
        };
        let (lowest, highest) = points.iter().fold((first, first), around);
        Some(Self { lowest, highest })
    }

    /// The box's edges, in metres.
    pub fn extents_m(&self) -> Vector3<f64> {
        self.highest - self.lowest
    }

    /// Gives the squares of an edge in metres below the box, from the origin, along x and y.
    pub(crate) fn squares(&self, pitch_m: f64, [nx, ny]: [usize; 2]) -> [Range<usize>; 2] {
        let along = |axis: usize, count: usize| {
            // Casts saturate: what is outside becomes 0 or the count.
            let first = ((self.lowest[axis] / pitch_m).floor() as usize).min(count);
            let end = ((self.highest[axis] / pitch_m).ceil() as usize).min(count);
            first..end.max(first)
        };
        [along(0, nx), along(1, ny)]
    }

    /// The box's surface.
    pub fn mesh(&self) -> Mesh {
        /// Faces by corners, whose bits are x, y, z.
        const TRIANGLES: [[u32; 3]; 12] = [
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        let corner = |number: u8| {
            let side = |bit: u8, low, high| if number >> bit & 1 == 1 { high } else { low };
            Point3::new(
                side(0, self.lowest.x, self.highest.x),
                side(1, self.lowest.y, self.highest.y),
                side(2, self.lowest.z, self.highest.z),
            )
        };
        Mesh {
            vertices: (0..8).map(corner).collect(),
            triangles: TRIANGLES.to_vec(),
        }
    }
}

impl Mesh {
    /// A box along the axes by its lowest and its highest corner, in metres.
    pub fn cuboid(lowest: [f64; 3], highest: [f64; 3]) -> Self {
        let [lowest, highest] = [lowest, highest].map(Point3::from);
        Bounds { lowest, highest }.mesh()
    }

    /// The corners of each triangle. Triangles that name a missing vertex are left out.
    pub fn corners(&self) -> impl Iterator<Item = [Point3<f64>; 3]> + '_ {
        self.triangles.iter().filter_map(|[a, b, c]| {
            let vertex = |index: &u32| self.vertices.get(*index as usize).copied();
            Some([vertex(a)?, vertex(b)?, vertex(c)?])
        })
    }

    /// Adds another mesh beside this one.
    pub fn append(&mut self, other: &Self) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        let moved = |triangle: &[u32; 3]| triangle.map(|vertex| first + vertex);
        self.triangles.extend(other.triangles.iter().map(moved));
    }

    /// The box around all vertices; `None` for a mesh without any.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(&self.vertices)
    }

    /// The mesh moved by a rigid transform.
    #[must_use]
    pub fn transformed(&self, pose: &Isometry3<f64>) -> Self {
        Self {
            vertices: self.vertices.iter().map(|vertex| pose * vertex).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// The enclosed volume in cubic metres (divergence theorem); negative where wound inwards.
    pub fn signed_volume_m3(&self) -> f64 {
        self.corners()
            .map(|[a, b, c]| a.coords.dot(&b.coords.cross(&c.coords)) / 6.0)
            .sum()
    }
}
