//! Convex hulls by the Quickhull algorithm (Barber, Dobkin and Huhdanpaa, 1996), in `f64`.
//!
//! Written here, as that of parry 0.31 works in `f32` and fails on sound input (its issues 311 and
//! 347, open).

#![allow(
    clippy::indexing_slicing,
    reason = "points and faces are numbered by the slices that hold them"
)]

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use super::sides;
use crate::mesh::{Bounds, Mesh};

/// Points within this share of their size of a plane count as level with it: well above rounding.
const LEVEL_SHARE: f64 = 1e-10;

/// A point becomes a corner only where it lies farther outside than this share of the points' size:
/// above the noise of coordinates in `f32`, which would make a corner of every point on a flat
/// side.
const ABOVE_SHARE: f64 = 1e-6;

/// Points whose hull is thinner than this share of their size have none.
const FLAT_SHARE: f64 = 1e-6;

/// No point lies farther outside its hull than this share of the points' size.
const OUTSIDE_SHARE: f64 = 1e-5;

/// How far points are shifted, as a share of their size, when rounding defeats the way before.
const JOGGLES: [f64; 5] = [0.0, 1e-6, 2e-6, 3e-6, 5e-6];

/// The convex hull of points, as a mesh whose vertices are some of them; `None` where they lie in a
/// plane, or a coordinate is not finite.
///
/// No point lies outside the hull by more than 1e-5 of the points' size.
pub(crate) fn hull(points: &[Point3<f64>]) -> Option<Mesh> {
    let size_m = Bounds::of(points)?.extents_m().max();
    if !points
        .iter()
        .all(|point| point.iter().all(|at| at.is_finite()))
        || size_m <= 0.0
    {
        return None;
    }
    let points = &distinct(points);
    // Shifted points are never level, so that this is asked of them as they are.
    simplex(points, FLAT_SHARE * size_m)?;
    JOGGLES.iter().find_map(|joggle| {
        if *joggle == 0.0 {
            hull_of(points, points, size_m)
        } else {
            hull_of(points, &joggled(points, joggle * size_m), size_m)
        }
    })
}

/// The points in order, each once: the surface's corners come with every triangle around them.
fn distinct(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let mut distinct = points.to_vec();
    distinct.sort_unstable_by(|a, b| {
        a.x.total_cmp(&b.x)
            .then(a.y.total_cmp(&b.y))
            .then(a.z.total_cmp(&b.z))
    });
    distinct.dedup();
    distinct
}

/// Points shifted so that no four are level but by chance; the same for the same points.
fn joggled(points: &[Point3<f64>], by_m: f64) -> Vec<Point3<f64>> {
    let shifted = |(index, point): (usize, &Point3<f64>)| {
        // Multiples of irrational numbers are spread evenly over the unit interval.
        let shift = |factor: f64| ((index + 1) as f64 * factor).fract() - 0.5;
        let shifts = [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9].map(shift);
        point + Vector3::from(shifts) * by_m
    };
    points.iter().enumerate().map(shifted).collect()
}

/// The hull of `places`, whose vertices are those of `points` with the same numbers.
fn hull_of(points: &[Point3<f64>], places: &[Point3<f64>], size_m: f64) -> Option<Mesh> {
    let first = simplex(places, 0.0)?;
    let mut builder = Builder {
        points: places,
        above_m: ABOVE_SHARE * size_m,
        level_m: LEVEL_SHARE * size_m,
        faces: Vec::new(),
        of_edge: HashMap::new(),
    };
    builder.start(first);
    // New faces are appended, so that one pass meets them all.
    let mut at = 0;
    while at < builder.faces.len() {
        while let Some(point) = builder.farthest(at) {
            builder.add(at, point);
        }
        at += 1;
    }
    let outside_m = OUTSIDE_SHARE * size_m;
    if builder.encloses_all(outside_m) {
        builder.finish(points)
    } else {
        None
    }
}

/// Four points far apart, the fourth below the plane of the others seen counter-clockwise.
fn simplex(points: &[Point3<f64>], flat_m: f64) -> Option<[usize; 4]> {
    let most = |measure: &dyn Fn(&Point3<f64>) -> f64| {
        let measured = points.iter().map(measure).enumerate();
        measured.max_by(|(_, a), (_, b)| a.total_cmp(b))
    };
    let bounds = Bounds::of(points)?;
    let (a, _) = most(&|point| -point[bounds.extents_m().imax()])?;
    let (b, _) = most(&|point| (point - points[a]).norm_squared())?;
    let along = (points[b] - points[a]).try_normalize(0.0)?;
    let (c, height_m) = most(&|point| along.cross(&(point - points[a])).norm())?;
    if height_m < flat_m {
        return None;
    }
    let normal = along.cross(&(points[c] - points[a])).try_normalize(0.0)?;
    let (d, depth_m) = most(&|point| normal.dot(&(point - points[a])).abs())?;
    if depth_m < flat_m {
        return None;
    }
    let below = normal.dot(&(points[d] - points[a])) < 0.0;
    Some(if below { [a, b, c, d] } else { [a, c, b, d] })
}

struct Face {
    corners: [usize; 3],
    normal: Vector3<f64>,
    offset: f64,
    /// Points above the face and none before it.
    outside: Vec<usize>,
    alive: bool,
}

impl Face {
    fn height_m(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }

    fn edges(&self) -> [(usize, usize); 3] {
        sides(self.corners)
    }
}

struct Builder<'a> {
    points: &'a [Point3<f64>],
    above_m: f64,
    level_m: f64,
    faces: Vec<Face>,
    /// The face that passes an edge in its direction.
    of_edge: HashMap<(usize, usize), usize>,
}

impl Builder<'_> {
    fn start(&mut self, [a, b, c, d]: [usize; 4]) {
        for corners in [[a, b, c], [a, d, b], [b, d, c], [c, d, a]] {
            self.push(corners);
        }
        self.assign(0, 0..self.points.len());
    }

    fn push(&mut self, corners: [usize; 3]) {
        let [a, b, c] = corners.map(|corner| self.points[corner]);
        let normal = (b - a)
            .cross(&(c - a))
            .try_normalize(0.0)
            .unwrap_or_else(Vector3::zeros);
        let offset = normal.dot(&a.coords);
        let face = Face {
            corners,
            normal,
            offset,
            outside: Vec::new(),
            alive: true,
        };
        for edge in face.edges() {
            self.of_edge.insert(edge, self.faces.len());
        }
        self.faces.push(face);
    }

    /// Hands points to the first face from `start` on that each is above; others are inside.
    fn assign(&mut self, start: usize, points: impl Iterator<Item = usize>) {
        for index in points {
            let point = &self.points[index];
            let above_m = self.above_m;
            let mut faces = self.faces[start..].iter_mut();
            if let Some(face) = faces.find(|face| face.height_m(point) > above_m) {
                face.outside.push(index);
            }
        }
    }

    /// Takes the point farthest above a face from it.
    fn farthest(&mut self, face: usize) -> Option<usize> {
        let face = &mut self.faces[face];
        let height_m = |index: &usize| face.height_m(&self.points[*index]);
        let heights = face.outside.iter().map(height_m).enumerate();
        let (place, _) = heights.max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        Some(face.outside.swap_remove(place))
    }

    /// Replaces the faces that a point is above, or level with, by those between it and their
    /// border.
    ///
    /// Faces level with the point go too, so that no new one is without area.
    fn add(&mut self, seen: usize, point: usize) {
        let mut visible = vec![seen];
        let mut border = Vec::new();
        self.faces[seen].alive = false;
        let mut next = 0;
        while let Some(face) = visible.get(next).copied() {
            next += 1;
            for (from, to) in self.faces[face].edges() {
                let Some(neighbour) = self.of_edge.get(&(to, from)).copied() else {
                    continue;
                };
                if !self.faces[neighbour].alive {
                    continue;
                }
                if self.faces[neighbour].height_m(&self.points[point]) > -self.level_m {
                    self.faces[neighbour].alive = false;
                    visible.push(neighbour);
                } else {
                    border.push((from, to));
                }
            }
        }
        // A neighbour found visible later leaves edges behind that are inside by now.
        border.retain(|(from, to)| {
            self.of_edge
                .get(&(*to, *from))
                .is_some_and(|neighbour| self.faces[*neighbour].alive)
        });
        if !is_loop(&border) {
            // Rounding has made the border cross itself. Whether the point matters is seen at the
            // end.
            visible
                .iter()
                .for_each(|face| self.faces[*face].alive = true);
            return;
        }
        let mut orphans = Vec::new();
        for face in &visible {
            orphans.append(&mut self.faces[*face].outside);
            for edge in self.faces[*face].edges() {
                self.of_edge.remove(&edge);
            }
        }
        let start = self.faces.len();
        for (from, to) in border {
            self.push([from, to, point]);
        }
        self.assign(start, orphans.into_iter());
    }

    /// Whether no point is above a face by more than a tolerance.
    ///
    /// Asked here, since the planes of the faces are not known from the vertices of `points` where
    /// a face is narrow and its points were shifted.
    fn encloses_all(&self, tolerance_m: f64) -> bool {
        let mut faces = self.faces.iter().filter(|face| face.alive);
        faces.all(|face| {
            self.points
                .iter()
                .all(|point| face.height_m(point) <= tolerance_m)
        })
    }

    fn finish(self, points: &[Point3<f64>]) -> Option<Mesh> {
        let mut mesh = Mesh::default();
        let mut vertex = HashMap::new();
        for face in self.faces.iter().filter(|face| face.alive) {
            let corners = face.corners.map(|corner| {
                *vertex.entry(corner).or_insert_with(|| {
                    mesh.vertices.push(points[corner]);
                    mesh.vertices.len() as u32 - 1
                })
            });
            mesh.triangles.push(corners);
        }
        (mesh.signed_volume_m3() > 0.0).then_some(mesh)
    }
}

/// Whether edges form one closed loop.
fn is_loop(edges: &[(usize, usize)]) -> bool {
    let next: HashMap<usize, usize> = edges.iter().copied().collect();
    let Some((start, _)) = edges.first() else {
        return false;
    };
    let mut at = *start;
    for _ in 1..edges.len() {
        match next.get(&at) {
            Some(to) if to != start => at = *to,
            _ => return false,
        }
    }
    next.len() == edges.len() && next.get(&at) == Some(start)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn checked(points: &[Point3<f64>]) -> Mesh {
        let made = hull(points).unwrap();
        assert_eq!(
            made.triangles.len(),
            2 * made.vertices.len() - 4,
            "not a closed ball"
        );
        for index in 0..200 {
            let turn = 2.399_963 * f64::from(index);
            let z = 1.0 - (2.0 * f64::from(index) + 1.0) / 200.0;
            let direction = Vector3::new(turn.cos(), turn.sin(), z / (1.0 - z * z).sqrt());
            let most = |points: &[Point3<f64>]| {
                let along = points
                    .iter()
                    .map(|point| point.coords.dot(&direction.normalize()));
                along.fold(f64::NEG_INFINITY, f64::max)
            };
            assert!(
                most(points) - most(&made.vertices) < 2e-6,
                "a point is outside"
            );
        }
        made
    }

    #[test]
    fn points_in_a_plane_have_no_hull() {
        let grid = |index: i32| Point3::new(f64::from(index % 3), f64::from(index / 3), 0.5);
        assert!(hull(&(0..9).map(grid).collect::<Vec<_>>()).is_none());
        assert!(hull(&[]).is_none());
        assert!(hull(&[Point3::origin(); 5]).is_none());
        assert!(hull(&[Point3::new(f64::NAN, 0.0, 0.0); 5]).is_none());
    }

    #[test]
    fn a_grid_of_points_has_the_hull_of_its_corners() {
        let grid = (0..1000).map(|index| {
            Point3::new(
                f64::from(index % 10),
                f64::from(index / 10 % 10),
                f64::from(index / 100),
            )
        });
        let made = checked(&grid.map(|point| point * 0.01).collect::<Vec<_>>());
        assert!((made.signed_volume_m3() - 0.09_f64.powi(3)).abs() < 1e-9);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(600))]

        #[test]
        fn a_hull_encloses_its_points(
            points in prop::collection::vec(prop::array::uniform3(-0.1..0.1_f64), 4..60),
        ) {
            checked(&points.into_iter().map(Point3::from).collect::<Vec<_>>());
        }

        #[test]
        fn so_it_does_where_many_are_level(
            points in prop::collection::vec(prop::array::uniform3(-3_i8..4), 40..200),
            noise in 0.0..2e-8_f64,
        ) {
            let points = points.into_iter().enumerate().map(|(index, point)| {
                Point3::from(point.map(f64::from)) * 0.02 * (1.0 + noise * (index % 7) as f64)
            });
            checked(&points.collect::<Vec<_>>());
        }
    }
}
