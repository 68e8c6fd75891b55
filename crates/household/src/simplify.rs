//! Fewer triangles for nearly the same surface: edge collapse by quadric error (Garland and
//! Heckbert, 1997), restricted to collapses that keep a closed manifold a closed manifold.
//!
//! Passes over the triangles collapse the edges that cost less than a tolerance, which rises from
//! pass to pass: a sorted queue of all edges gives no fewer triangles and takes twice as long. No
//! vertex moves twice in a pass, which thins the mesh evenly.
//!
//! Written here, as libraries for it (`meshopt`) are C++ that would be compiled for this alone.
#![allow(
    clippy::indexing_slicing,
    reason = "vertex and triangle numbers are those of the solid, and its arrays keep their lengths"
)]

use nalgebra::{Matrix3, Point3, Vector3};

use super::solid::Solid;

/// The root of a collapse's summed squared plane distances, in millimetres: where it begins, how it
/// grows, and where it stops once there are few enough triangles.
const FIRST_TOLERANCE_MM: f64 = 0.02;
const TOLERANCE_GROWTH: f64 = 1.6;
const LAST_TOLERANCE_MM: f64 = 0.35;

/// While there are more triangles than this, the tolerance grows on, but not for ever: a shape may
/// have no edge left that can collapse without a fold.
const MOST_TRIANGLES: usize = 4_000;
const GREATEST_TOLERANCE_MM: f64 = 5.0;

/// Passes at one tolerance are repeated while they take away at least one triangle in so many.
const WORTHWHILE_SHARE: usize = 50;

/// A collapse must not turn a triangle by more than about 80 degrees.
const LEAST_NORMAL_COSINE: f64 = 0.2;

/// Pull towards an edge's middle, which settles where on a plane or a crease the new vertex lies.
const MIDPOINT_PULL: f64 = 1e-3;

/// Sum of squared distances to planes, as a function of the point.
#[derive(Debug, Clone, Copy, Default)]
struct Quadric {
    matrix: Matrix3<f64>,
    vector: Vector3<f64>,
    constant: f64,
}

impl Quadric {
    fn plane(normal: &Vector3<f64>, through: &Point3<f64>) -> Self {
        let offset = -normal.dot(&through.coords);
        Self {
            matrix: normal * normal.transpose(),
            vector: normal * offset,
            constant: offset * offset,
        }
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            matrix: self.matrix + other.matrix,
            vector: self.vector + other.vector,
            constant: self.constant + other.constant,
        }
    }

    fn at(&self, point: &Point3<f64>) -> f64 {
        let p = &point.coords;
        let error = p.dot(&(self.matrix * p)) + 2.0 * self.vector.dot(p) + self.constant;
        // Rounding can make an exact fit slightly negative.
        error.max(0.0)
    }

    /// The point of least error, all but ties decided by the error alone.
    fn minimiser(&self, middle: &Point3<f64>) -> Option<Point3<f64>> {
        let pulled = self.matrix + Matrix3::identity() * MIDPOINT_PULL;
        let target = middle.coords * MIDPOINT_PULL - self.vector;
        Some(Point3::from(pulled.cholesky()?.solve(&target)))
    }
}

struct Collapser {
    positions: Vec<Point3<f64>>,
    quadrics: Vec<Quadric>,
    /// Triangle numbers around each vertex.
    around: Vec<Vec<u32>>,
    /// `None` once collapsed away.
    triangles: Vec<Option<[u32; 3]>>,
    /// How many are left.
    left: usize,
    /// Vertices that have moved in this pass.
    moved: Vec<bool>,
    /// Marks the vertices that the latest walk around a vertex has met.
    stamps: Vec<u64>,
    stamp: u64,
}

/// Collapses edges up to the tolerance and until few enough triangles are left. Vertices on the
/// ground z = 0 stay on it.
pub(crate) fn simplify(solid: Solid) -> Solid {
    let mut collapser = Collapser::new(solid);
    let mut tolerance_mm = FIRST_TOLERANCE_MM;
    while tolerance_mm <= LAST_TOLERANCE_MM
        || collapser.left > MOST_TRIANGLES && tolerance_mm <= GREATEST_TOLERANCE_MM
    {
        loop {
            let before = collapser.left;
            collapser.pass(tolerance_mm * tolerance_mm);
            if (before - collapser.left) * WORTHWHILE_SHARE < before {
                break;
            }
        }
        tolerance_mm *= TOLERANCE_GROWTH;
    }
    collapser.finish()
}

impl Collapser {
    fn new(solid: Solid) -> Self {
        let count = solid.vertices_mm.len();
        let mut collapser = Self {
            positions: solid.vertices_mm,
            quadrics: vec![Quadric::default(); count],
            around: vec![Vec::with_capacity(8); count],
            triangles: solid.triangles.iter().copied().map(Some).collect(),
            left: solid.triangles.len(),
            moved: vec![false; count],
            stamps: vec![0; count],
            stamp: 0,
        };
        for (number, corners) in (0..).zip(&solid.triangles) {
            let [a, b, c] = corners.map(|corner| collapser.positions[corner as usize]);
            let normal = (b - a).cross(&(c - a)).try_normalize(f64::MIN_POSITIVE);
            let plane = normal.map_or_else(Quadric::default, |n| Quadric::plane(&n, &a));
            for corner in corners.map(|corner| corner as usize) {
                collapser.quadrics[corner] = collapser.quadrics[corner].plus(&plane);
                collapser.around[corner].push(number);
            }
        }
        collapser
    }

    /// Collapses each edge that costs no more, in square millimetres, and whose ends have not moved
    /// yet.
    fn pass(&mut self, most_cost: f64) {
        self.moved.fill(false);
        for number in 0..self.triangles.len() {
            let Some([a, b, c]) = self.triangles[number] else {
                continue;
            };
            for [from, to] in [[a, b], [b, c], [c, a]] {
                // The opposite direction is another triangle's.
                let is_due = from < to && !self.moved[from as usize] && !self.moved[to as usize];
                if is_due && self.collapse(from, to, most_cost) {
                    self.left -= 2;
                    break;
                }
            }
        }
    }

    fn merged(&self, a: u32, b: u32) -> Option<(Point3<f64>, Quadric)> {
        let [from, to] = [a, b].map(|vertex| self.positions[vertex as usize]);
        let quadric = self.quadrics[a as usize].plus(&self.quadrics[b as usize]);
        let mut point = quadric.minimiser(&nalgebra::center(&from, &to))?;
        if from.z == 0.0 || to.z == 0.0 {
            point.z = 0.0;
        }
        Some((point, quadric))
    }

    /// The vertices that share a triangle with this one; they and itself are stamped.
    fn neighbours(&mut self, vertex: u32) -> Vec<u32> {
        self.stamp += 1;
        self.stamps[vertex as usize] = self.stamp;
        let mut found = Vec::with_capacity(self.around[vertex as usize].len());
        for &number in &self.around[vertex as usize] {
            for corner in self.triangles[number as usize].into_iter().flatten() {
                let stamp = &mut self.stamps[corner as usize];
                if *stamp != self.stamp {
                    *stamp = self.stamp;
                    found.push(corner);
                }
            }
        }
        found
    }

    /// Moves both ends of an edge to one point, unless that costs too much or would pinch or fold
    /// the surface.
    fn collapse(&mut self, a: u32, b: u32, most_cost: f64) -> bool {
        let Some((point, quadric)) = self.merged(a, b) else {
            return false;
        };
        if quadric.at(&point) > most_cost {
            return false;
        }
        let beside_a = self.neighbours(a);
        let beside_b = self.neighbours(b);
        let is_shared = |&v: &u32| v != b && self.stamps[v as usize] == self.stamp;
        let shared = beside_a.into_iter().filter(is_shared).count();
        // The link condition: on a closed manifold, exactly the two triangles' far corners are
        // shared. A tetrahedron passes it too, but must not become two triangles back to back.
        if shared != 2 || beside_b.len() < 4 && self.around[a as usize].len() < 4 {
            return false;
        }
        if self.folds(a, b, &point) || self.folds(b, a, &point) {
            return false;
        }
        let moved = std::mem::take(&mut self.around[b as usize]);
        for number in moved {
            let Some(corners) = self.triangles[number as usize] else {
                continue;
            };
            if corners.contains(&a) {
                self.triangles[number as usize] = None;
                for corner in corners.into_iter().filter(|&corner| corner != b) {
                    self.around[corner as usize].retain(|&other| other != number);
                }
            } else {
                self.triangles[number as usize] =
                    Some(corners.map(|corner| if corner == b { a } else { corner }));
                self.around[a as usize].push(number);
            }
        }
        self.positions[a as usize] = point;
        self.quadrics[a as usize] = quadric;
        self.moved[a as usize] = true;
        true
    }

    /// Whether moving `vertex` to `point` turns a triangle over that the edge to `other` will not
    /// take away.
    fn folds(&self, vertex: u32, other: u32, point: &Point3<f64>) -> bool {
        self.around[vertex as usize]
            .iter()
            .filter_map(|&number| self.triangles[number as usize])
            .filter(|corners| !corners.contains(&other))
            .any(|corners| {
                let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
                let [d, e, f] = corners.map(|corner| {
                    if corner == vertex {
                        *point
                    } else {
                        self.positions[corner as usize]
                    }
                });
                let before = (b - a).cross(&(c - a));
                let after = (e - d).cross(&(f - d));
                before.dot(&after) <= LEAST_NORMAL_COSINE * before.norm() * after.norm()
            })
    }

    fn finish(self) -> Solid {
        let mut renumbered = vec![None; self.positions.len()];
        let mut solid = Solid::default();
        for corners in self.triangles.into_iter().flatten() {
            let triangle = corners.map(|corner| {
                *renumbered[corner as usize].get_or_insert_with(|| {
                    solid.vertices_mm.push(self.positions[corner as usize]);
                    solid.vertices_mm.len() as u32 - 1
                })
            });
            solid.triangles.push(triangle);
        }
        solid
    }
}
