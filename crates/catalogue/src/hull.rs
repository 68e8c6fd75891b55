//! Convex hulls, and hulls of fewer vertices.

mod quickhull;

use nalgebra::{Point3, Vector3};

pub(crate) use self::quickhull::hull;
use crate::mesh::Mesh;

/// The hull of at most `most` of a hull's vertices, as few as leave none farther outside than
/// `tolerance_m`.
///
/// Starts from the extremes along axes and diagonals, and adds the vertex farthest outside until
/// all are near. The result lies inside the hull it is made from.
pub(crate) fn simplified(hull_mesh: Mesh, most: usize, tolerance_m: f64) -> Mesh {
    if hull_mesh.vertices.len() <= 8 {
        return hull_mesh;
    }
    let mut chosen = extremes(&hull_mesh.vertices);
    let Some(mut inner) = hull(&chosen) else {
        return hull_mesh;
    };
    loop {
        let planes = planes(&inner);
        let outside = |vertex: &Point3<f64>| {
            planes
                .iter()
                .map(|(normal, offset)| normal.dot(&vertex.coords) - offset)
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let farthest = hull_mesh
            .vertices
            .iter()
            .map(|vertex| (outside(vertex), vertex))
            .max_by(|(a, _), (b, _)| a.total_cmp(b));
        match farthest {
            Some((distance_m, vertex)) if distance_m > tolerance_m && chosen.len() < most => {
                chosen.push(*vertex);
            }
            _ => return inner,
        }
        match hull(&chosen) {
            Some(next) => inner = next,
            None => return inner,
        }
    }
}

/// The vertices that lie farthest along the axes and the diagonals, each once.
fn extremes(vertices: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let mut chosen = Vec::new();
    for direction in directions() {
        let along = |vertex: &Point3<f64>| vertex.coords.dot(&direction);
        let extreme = vertices.iter().max_by(|a, b| along(a).total_cmp(&along(b)));
        if let Some(extreme) = extreme
            && !chosen.contains(extreme)
        {
            chosen.push(*extreme);
        }
    }
    chosen
}

/// The axes (6) and the diagonals of the cube (8).
fn directions() -> impl Iterator<Item = Vector3<f64>> {
    let all = (0..27_i32).map(|index| [index / 9 - 1, index / 3 % 3 - 1, index % 3 - 1]);
    all.filter(|steps| matches!(steps.iter().map(|step| step.abs()).sum(), 1 | 3))
        .map(|steps| Vector3::from(steps.map(f64::from)))
}

/// A triangle's sides, in the order in which it passes them.
pub(crate) fn sides<T: Copy>([a, b, c]: [T; 3]) -> [(T, T); 3] {
    [(a, b), (b, c), (c, a)]
}

/// Triangles lower than this share of their longest side have no plane of their own.
const NARROW_SHARE: f64 = 1e-4;

/// The outward unit normal and the offset of the plane of each triangle; narrow ones are left out.
pub(crate) fn planes(mesh: &Mesh) -> Vec<(Vector3<f64>, f64)> {
    mesh.corners()
        .filter_map(|[a, b, c]| {
            let longest = [b - a, c - b, a - c].map(|side| side.norm_squared());
            let least = NARROW_SHARE * longest.into_iter().fold(0.0, f64::max);
            let normal = (b - a).cross(&(c - a)).try_normalize(least)?;
            Some((normal, normal.dot(&a.coords)))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere(count: usize, radius_m: f64) -> Vec<Point3<f64>> {
        // A spiral of Fibonacci.
        (0..count)
            .map(|index| {
                let z = 1.0 - (2.0 * index as f64 + 1.0) / count as f64;
                let around = 2.399_963 * index as f64;
                let ring = (1.0 - z * z).sqrt();
                Point3::new(ring * around.cos(), ring * around.sin(), z) * radius_m
            })
            .collect()
    }

    #[test]
    fn a_simplified_sphere_stays_within_tolerance() {
        let whole = hull(&sphere(600, 0.05)).unwrap();
        let volume_m3 = whole.signed_volume_m3();
        let simple = simplified(whole, 48, 0.0);
        assert_eq!(simple.vertices.len(), 48);
        assert!(simple.signed_volume_m3() > 0.85 * volume_m3);
        assert!(simple.signed_volume_m3() < volume_m3);
    }
}
