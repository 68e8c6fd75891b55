//! Faces of any number of corners, which become triangles.

use nalgebra::{Point2, Point3, Vector3};

use crate::mesh::Mesh;

/// Faces that are not convex have at most so many corners.
const MAX_CONCAVE_CORNERS: usize = 10_000;

/// Faces over common vertices.
#[derive(Debug, Default)]
pub(super) struct Polygons {
    /// Vertices, in the file's unit.
    pub(super) vertices: Vec<Point3<f64>>,
    /// Corners of all faces, one face after the other.
    corners: Vec<u32>,
    /// End of each face in `corners`.
    ends: Vec<usize>,
}

impl Polygons {
    /// Adds a face by the numbers of its corners, from 0.
    pub(super) fn push(&mut self, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }

    /// Cuts faces into triangles: convex ones into a fan around the first corner, others by
    /// clipping ears. Vertices stay, also those that no face names.
    pub(super) fn triangulated(self) -> Result<Mesh, String> {
        let mut triangles = Vec::with_capacity(self.ends.len());
        let mut start = 0;
        for end in self.ends.iter().copied() {
            let face = self.corners.get(start..end).unwrap_or_default();
            start = end;
            match self.concave(face) {
                Some(plan) if plan.len() > MAX_CONCAVE_CORNERS => {
                    return Err(format!(
                        "a face of {} corners is not convex: export triangles",
                        plan.len()
                    ));
                }
                Some(plan) => triangles.extend(ears(&plan).iter().filter_map(|ear| {
                    let [a, b, c] = ear.map(|at| face.get(at).copied());
                    Some([a?, b?, c?])
                })),
                None => triangles.extend(fan(face)),
            }
        }
        Ok(Mesh {
            vertices: self.vertices,
            triangles,
        })
    }

    /// Gives the corners of a face that is not convex in its plane, counter-clockwise; `None` for
    /// others and for those that name a missing vertex.
    fn concave(&self, face: &[u32]) -> Option<Vec<Point2<f64>>> {
        if face.len() <= 3 {
            return None;
        }
        let vertices = face
            .iter()
            .map(|corner| self.vertices.get(*corner as usize));
        let points: Vec<Point3<f64>> = vertices.map(Option::<&_>::copied).collect::<Option<_>>()?;
        let first = points.first()?;
        let arms: Vec<Vector3<f64>> = points.iter().map(|point| point - first).collect();
        let pairs = arms.iter().zip(arms.iter().skip(1));
        let normal: Vector3<f64> = pairs.map(|(a, b)| a.cross(b)).sum();
        let axis = normal.iamax();
        // The two other axes, in the order in which the face is seen counter-clockwise.
        let (mut right, mut up) = ((axis + 1) % 3, (axis + 2) % 3);
        if *normal.get(axis)? < 0.0 {
            (right, up) = (up, right);
        }
        let flat = arms
            .iter()
            .map(|arm| Some([*arm.get(right)?, *arm.get(up)?]));
        let plan: Vec<Point2<f64>> = flat.map(|at| at.map(Point2::from)).collect::<Option<_>>()?;
        // A last bit is no notch.
        let least = -1e-9 * normal.norm();
        let next = |by: usize| plan.iter().cycle().skip(by);
        let mut corners = plan.iter().zip(next(1)).zip(next(2));
        corners
            .any(|((a, b), c)| turn(a, b, c) < least)
            .then_some(plan)
    }
}

/// Gives the triangles of a polygon as a fan around its first corner.
pub(super) fn fan(polygon: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let sides = polygon.iter().zip(polygon.iter().skip(1)).skip(1);
    let first = polygon.first();
    sides.filter_map(move |(from, to)| Some([*first?, *from, *to]))
}

/// Gives the triangles of a strip: each further corner makes one with the two before it. A corner
/// of `u32::MAX` begins another strip.
pub(super) fn strip(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let strips = corners.split(|corner| *corner == u32::MAX);
    strips.flat_map(|strip| {
        strip
            .windows(3)
            .enumerate()
            .filter_map(|(index, corners)| match *corners {
                [a, b, c] if index % 2 == 0 => Some([a, b, c]),
                [a, b, c] => Some([b, a, c]),
                _ => None,
            })
    })
}

/// Gives twice the area of a triangle; negative where it turns clockwise.
fn turn(a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

/// Cuts a polygon that runs counter-clockwise into triangles by clipping ears.
///
/// Every corner stays one, also those on a straight side, so that faces meet their neighbours.
#[allow(
    clippy::indexing_slicing,
    reason = "all indices are below the number of points"
)]
fn ears(points: &[Point2<f64>]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::with_capacity(points.len());
    let (mut at, mut tried) = (0, 0);
    while left.len() >= 3 {
        let count = left.len();
        at %= count;
        let ear = [
            left[(at + count - 1) % count],
            left[at],
            left[(at + 1) % count],
        ];
        let [a, b, c] = ear.map(|corner| &points[corner]);
        let is_inside = |point: &Point2<f64>| {
            let turns = [turn(a, b, point), turn(b, c, point), turn(c, a, point)];
            turns.iter().all(|turn| *turn >= 0.0) && ![a, b, c].contains(&point)
        };
        let is_ear = turn(a, b, c) > 0.0 && !left.iter().any(|corner| is_inside(&points[*corner]));
        // Of a polygon that crosses itself any corner is as good.
        if is_ear || tried >= count {
            triangles.push(ear);
            left.remove(at);
            tried = 0;
        } else {
            tried += 1;
        }
        at += 1;
    }
    triangles
}
