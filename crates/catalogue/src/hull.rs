//! Convex hulls in `f64`, on parry's in `f32`.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};
use parry3d::math::Vector;
use parry3d::transformation::try_convex_hull;

use crate::guard::guarded;
use crate::mesh::{Bounds, Mesh};

/// Points brought to a size near one around the origin, where parry's tolerances are meant.
pub(crate) struct Normalised {
    centre: Point3<f64>,
    size_m: f64,
}

impl Normalised {
    /// The scaling that suits points within `bounds`; `None` where these have no extent.
    pub(crate) fn new(bounds: &Bounds) -> Option<Self> {
        let size_m = bounds.extents_m().max();
        let centre = nalgebra::center(&bounds.lowest, &bounds.highest);
        (size_m.is_finite() && size_m > 0.0).then_some(Self { centre, size_m })
    }

    /// A point as parry takes it. Adding zero makes -0 equal to 0 in bits.
    pub(crate) fn scaled(&self, point: &Point3<f64>) -> Vector {
        let scaled = (point - self.centre) / self.size_m;
        Vector::new(
            scaled.x as f32 + 0.0,
            scaled.y as f32 + 0.0,
            scaled.z as f32 + 0.0,
        )
    }

    /// A point as parry gives it.
    pub(crate) fn point(&self, point: &Vector) -> Point3<f64> {
        let scaled = Vector3::new(point.x, point.y, point.z).map(f64::from);
        self.centre + scaled * self.size_m
    }
}

/// The convex hull of points, as a mesh whose vertices are some of them; `None` where they lie in a plane.
pub(crate) fn hull(points: &[Point3<f64>]) -> Option<Mesh> {
    let scale = Normalised::new(&Bounds::of(points)?)?;
    let bits = |point: &Vector| [point.x.to_bits(), point.y.to_bits(), point.z.to_bits()];
    let mut originals = HashMap::with_capacity(points.len());
    let mut distinct = Vec::with_capacity(points.len());
    for point in points {
        let scaled = scale.scaled(point);
        originals.entry(bits(&scaled)).or_insert_with(|| {
            distinct.push(scaled);
            *point
        });
    }
    let (vertices, triangles) = guarded(|| try_convex_hull(&distinct))?.ok()?;
    let vertices = vertices
        .iter()
        .map(|vertex| originals.get(&bits(vertex)).copied());
    let mesh = Mesh {
        vertices: vertices.collect::<Option<_>>()?,
        triangles,
    };
    (mesh.signed_volume_m3() > 0.0).then_some(mesh)
}

/// The hull of at most `most` of a hull's vertices, as few as leave none farther outside than `tolerance_m`.
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
    for (x, y, z) in (0_i32..27).map(|index| (index / 9 - 1, index / 3 % 3 - 1, index % 3 - 1)) {
        let direction = Vector3::new(f64::from(x), f64::from(y), f64::from(z));
        // Axes (6) and diagonals of the cube (8); not those of its faces.
        if !matches!(x.abs() + y.abs() + z.abs(), 1 | 3) {
            continue;
        }
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

/// The outward unit normal and the offset of the plane of each triangle; those without area are left out.
pub(crate) fn planes(mesh: &Mesh) -> Vec<(Vector3<f64>, f64)> {
    mesh.corners()
        .filter_map(|[a, b, c]| {
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
            Some((normal, normal.dot(&a.coords)))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

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
    fn points_in_a_plane_have_no_hull() {
        let flat: Vec<_> = (0..9)
            .map(|index| Point3::new(f64::from(index % 3), f64::from(index / 3), 0.5))
            .collect();
        assert!(hull(&flat).is_none());
        assert!(hull(&[]).is_none());
        assert!(hull(&[Point3::origin(); 5]).is_none());
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

    proptest! {
        #[test]
        fn a_hull_encloses_its_points(
            points in prop::collection::vec(prop::array::uniform3(-0.1..0.1_f64), 4..60),
        ) {
            let points: Vec<_> = points.into_iter().map(Point3::from).collect();
            let made = hull(&points).unwrap();
            for (normal, offset) in planes(&made) {
                for point in &points {
                    prop_assert!(normal.dot(&point.coords) - offset < 1e-6);
                }
            }
        }
    }
}
