//! Depth to which convex solids reach into each other: the separating axis test over all faces and
//! pairs of edges, in double precision.
//!
//! The engine's own penetration depths are fast and single-precision; these check what comes of
//! them.

use nalgebra::Vector3;
use rapier3d::geometry::{Collider, Shape, TypedShape};
use rapier3d::math::Pose;

use crate::convert::point_m;

/// Minimum sine of the angle between two edges that are not parallel.
const PARALLEL: f64 = 1e-6;

/// The deepest that one of some solids and one of some others reach into each other, in metres.
pub(crate) fn deepest_m(some: &[Solid], others: &[Solid]) -> f64 {
    let pairs = some
        .iter()
        .flat_map(|solid| others.iter().map(|other| solid.overlap_m(other)));
    pairs.fold(0.0, f64::max)
}

/// A convex solid in the container frame.
pub(crate) struct Solid {
    vertices_m: Vec<Vector3<f64>>,
    normals: Vec<Vector3<f64>>,
    edges: Vec<Vector3<f64>>,
}

impl Solid {
    /// The solids that a collider consists of, but those that are neither boxes nor hulls.
    pub(crate) fn all_of(collider: &Collider) -> Vec<Self> {
        let pose = collider.position();
        let Some(compound) = collider.shape().as_compound() else {
            return Self::new(pose, collider.shape()).into_iter().collect();
        };
        let pieces = compound.shapes().iter();
        pieces
            .filter_map(|(in_body, piece)| Self::new(&(pose * in_body), &**piece))
            .collect()
    }

    fn new(pose: &Pose, shape: &dyn Shape) -> Option<Self> {
        let (vertices, triangles) = match shape.as_typed_shape() {
            TypedShape::Cuboid(cuboid) => cuboid.to_trimesh(),
            TypedShape::ConvexPolyhedron(hull) => hull.to_trimesh(),
            _ => return None,
        };
        let vertices_m: Vec<Vector3<f64>> = vertices
            .into_iter()
            .map(|vertex| point_m(pose.transform_point(vertex)).coords)
            .collect();
        let (mut normals, mut edges) = (Vec::new(), Vec::new());
        for [a, b, c] in triangles {
            let vertex = |index: u32| vertices_m.get(index as usize).copied();
            let (a, b, c) = (vertex(a)?, vertex(b)?, vertex(c)?);
            normals.extend((b - a).cross(&(c - a)).try_normalize(0.0));
            let sides = [b - a, c - b, a - c];
            edges.extend(sides.iter().filter_map(|edge| edge.try_normalize(0.0)));
        }
        Some(Self {
            vertices_m,
            normals,
            edges,
        })
    }

    /// The shortest way that separates two solids, in metres; 0 where they are apart.
    pub(crate) fn overlap_m(&self, other: &Self) -> f64 {
        let faces = self.normals.iter().chain(&other.normals).copied();
        let crossed = self.edges.iter().flat_map(|edge| {
            let others = other.edges.iter();
            others.filter_map(|across| edge.cross(across).try_normalize(PARALLEL))
        });
        let mut least_m = f64::INFINITY;
        for axis in faces.chain(crossed) {
            let (low, high) = self.range(&axis);
            let (other_low, other_high) = other.range(&axis);
            least_m = least_m.min(high - other_low).min(other_high - low);
            if least_m <= 0.0 {
                return 0.0;
            }
        }
        least_m
    }

    fn range(&self, axis: &Vector3<f64>) -> (f64, f64) {
        let along = self.vertices_m.iter().map(|vertex| vertex.dot(axis));
        along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::geometry::ColliderBuilder;
    use rapier3d::math::Vector;

    #[test]
    fn the_overlap_is_the_shortest_way_out() {
        // The engine's unit is the decimetre.
        let solid = |x, roll| {
            let cube = ColliderBuilder::cuboid(0.5, 0.5, 0.5)
                .translation(Vector::new(x, 0.0, 0.0))
                .rotation(Vector::new(0.0, roll, 0.0));
            Solid::all_of(&cube.build())
        };
        let overlap_m = |x, roll| deepest_m(&solid(0.0, 0.0), &solid(x, roll));
        assert!((overlap_m(0.9, 0.0) - 0.01).abs() < 1e-8);
        assert_eq!(overlap_m(1.1, 0.0), 0.0);
        let corner_m = f64::from(0.5 + 0.5_f32.sqrt() - 0.9) * 0.1;
        let turned = overlap_m(0.9, std::f32::consts::FRAC_PI_4);
        assert!((turned - corner_m).abs() < 1e-8, "{turned}");
    }
}
