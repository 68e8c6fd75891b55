//! Points spread evenly over a mesh's surface, directions over the sphere, angles over a turn, and
//! some of many points.

use nalgebra::{Point3, Vector3};
use ppnpack_catalogue::mesh::Mesh;

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Its place, in metres.
    pub point: Point3<f64>,
    /// The unit normal there.
    pub normal: Vector3<f64>,
}

/// Gives `count` points of a mesh, each standing for the same area; none where it has no area.
///
/// Goes through the area in even steps; the place within a triangle follows a sequence of low
/// discrepancy (the additive recurrence of the plastic number), so that equal meshes give equal
/// points.
pub fn surface_points(mesh: &Mesh, count: usize) -> Vec<SurfacePoint> {
    let triangles: Vec<_> = mesh.corners().collect();
    let area = |[a, b, c]: &[Point3<f64>; 3]| (b - a).cross(&(c - a)).norm() / 2.0;
    let total_m2: f64 = triangles.iter().map(area).sum();
    if !(total_m2 > 0.0 && total_m2.is_finite()) {
        return Vec::new();
    }
    let step_m2 = total_m2 / count.max(1) as f64;
    let mut points = Vec::with_capacity(count);
    let mut passed_m2 = 0.0;
    for corners in &triangles {
        passed_m2 += area(corners);
        let [a, b, c] = corners;
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else {
            continue;
        };
        while points.len() < count && (points.len() as f64 + 0.5) * step_m2 <= passed_m2 {
            let number = points.len() as f64;
            let (mut s, mut t) = (
                (0.5 + number * 0.754_877_666_246_693).fract(),
                (0.5 + number * 0.569_840_290_998_053).fract(),
            );
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            points.push(SurfacePoint {
                point: a + (b - a) * s + (c - a) * t,
                normal,
            });
        }
    }
    points
}

/// Gives one of `count` directions spread evenly over the sphere along a spiral.
pub(crate) fn direction(number: usize, count: usize) -> Vector3<f64> {
    let z = 1.0 - 2.0 * (number as f64 + 0.5) / count as f64;
    let turn_rad = number as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vector3::new(radius * turn_rad.cos(), radius * turn_rad.sin(), z)
}

/// Gives `count` angles spread evenly over a full turn, from 0, in radians.
pub(crate) fn yaws_rad(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |step| std::f64::consts::TAU * step as f64 / count as f64)
}

/// Gives some of the points, evenly spaced in their order.
pub(crate) fn spread<T: Copy>(points: &[T], count: usize) -> Vec<T> {
    if points.len() <= count {
        return points.to_vec();
    }
    let step = points.len() as f64 / count as f64;
    let places = (0..count).map(|number| (number as f64 * step) as usize);
    places
        .filter_map(|place| points.get(place).copied())
        .collect()
}
