//! Points spread evenly over a mesh's surface.

use nalgebra::{Point3, Vector3};
use ppnpack_catalogue::mesh::Mesh;

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Where it is, in metres.
    pub point: Point3<f64>,
    /// The unit normal there.
    pub normal: Vector3<f64>,
}

/// `count` points of a mesh, each standing for the same area; none where it has no area.
///
/// Goes through the area in even steps; the place within a triangle follows a sequence of low discrepancy (the additive
/// recurrence of the plastic number), so that equal meshes give equal points.
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
