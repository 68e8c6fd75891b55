//! A z-buffer for triangles.

use nalgebra::{Isometry3, Point3};
use ppnpack_catalogue::mesh::Mesh;

use super::{DepthCamera, Lens};

/// A pixel centre counts as inside a triangle when it is outside by less than this share of the triangle: two
/// triangles that share an edge then leave no gap.
const EDGE_SLACK: f64 = 1e-9;

/// A depth image in the making.
pub(super) struct Canvas<'camera> {
    camera: &'camera DepthCamera,
    /// Row-major; infinite where nothing was drawn.
    depths_m: Vec<f32>,
}

/// A corner on the image: where, and the quantity that is linear across the image: depth for parallel rays, its
/// reciprocal for rays through a point.
#[derive(Clone, Copy)]
struct Corner {
    u: f64,
    v: f64,
    linear: f64,
}

impl<'camera> Canvas<'camera> {
    pub(super) fn new(camera: &'camera DepthCamera) -> Self {
        Self {
            camera,
            depths_m: vec![f32::INFINITY; camera.width_px * camera.height_px],
        }
    }

    /// Draws a mesh. Both sides of its triangles are seen.
    pub(super) fn draw(&mut self, mesh: &Mesh, camera_from_mesh: &Isometry3<f64>) {
        let vertices: Vec<Point3<f64>> = mesh
            .vertices
            .iter()
            .map(|vertex| camera_from_mesh * vertex)
            .collect();
        let vertex = |index: &u32| vertices.get(*index as usize).copied();
        for [a, b, c] in &mesh.triangles {
            let (Some(a), Some(b), Some(c)) = (vertex(a), vertex(b), vertex(c)) else {
                continue;
            };
            let polygon = beyond(&[a, b, c], self.camera.near_m);
            let corners: Vec<Corner> = polygon.iter().map(|point| self.corner(point)).collect();
            let (Some(first), Some(rest)) = (corners.first(), corners.get(1..)) else {
                continue;
            };
            for (second, third) in rest.iter().zip(rest.iter().skip(1)) {
                self.fill([*first, *second, *third]);
            }
        }
    }

    /// The depths in metres, row-major; NaN where nothing is seen.
    pub(super) fn into_depths_m(self) -> Vec<f32> {
        let far_m = self.camera.far_m as f32;
        let seen = |depth_m: f32| if depth_m <= far_m { depth_m } else { f32::NAN };
        self.depths_m.into_iter().map(seen).collect()
    }

    fn corner(&self, point: &Point3<f64>) -> Corner {
        let [u, v] = self.camera.project(point);
        let linear = match self.camera.lens {
            Lens::Parallel { .. } => point.z,
            Lens::Pinhole { .. } => 1.0 / point.z,
        };
        Corner { u, v, linear }
    }

    fn fill(&mut self, [a, b, c]: [Corner; 3]) {
        let area = cross(a, b, c.u, c.v);
        if !area.is_finite() || area == 0.0 {
            return;
        }
        let is_pinhole = matches!(self.camera.lens, Lens::Pinhole { .. });
        let columns = pixels([a.u, b.u, c.u], self.camera.width_px);
        let rows = pixels([a.v, b.v, c.v], self.camera.height_px);
        let image = self
            .depths_m
            .chunks_exact_mut(self.camera.width_px)
            .enumerate();
        for (v, row) in image.skip(rows.start).take(rows.len()) {
            for (u, pixel) in row
                .iter_mut()
                .enumerate()
                .skip(columns.start)
                .take(columns.len())
            {
                let (u, v) = (u as f64, v as f64);
                let weight_a = cross(b, c, u, v) / area;
                let weight_b = cross(c, a, u, v) / area;
                let weight_c = 1.0 - weight_a - weight_b;
                if weight_a.min(weight_b).min(weight_c) < -EDGE_SLACK {
                    continue;
                }
                let linear = weight_a * a.linear + weight_b * b.linear + weight_c * c.linear;
                let depth_m = if is_pinhole { 1.0 / linear } else { linear };
                *pixel = pixel.min(depth_m as f32);
            }
        }
    }
}

/// Twice the signed area of the triangle from two corners to a point of the image.
fn cross(from: Corner, to: Corner, u: f64, v: f64) -> f64 {
    (to.u - from.u) * (v - from.v) - (to.v - from.v) * (u - from.u)
}

/// The pixels whose centres lie between the least and the greatest coordinate.
fn pixels(coordinates: [f64; 3], count: usize) -> std::ops::Range<usize> {
    let low = coordinates.iter().copied().fold(f64::INFINITY, f64::min);
    let high = coordinates
        .iter()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    // Casts saturate: what is left of the image becomes 0.
    let start = ((low - EDGE_SLACK).ceil() as usize).min(count);
    let end = if high < 0.0 {
        0
    } else {
        ((high + EDGE_SLACK).floor() as usize).saturating_add(1)
    };
    start..end.clamp(start, count)
}

/// The part of a triangle with `z >= near_m`: no corner, or three or four.
fn beyond(triangle: &[Point3<f64>; 3], near_m: f64) -> Vec<Point3<f64>> {
    let ends = triangle.iter().cycle().skip(1);
    let mut kept = Vec::with_capacity(4);
    for (start, end) in triangle.iter().zip(ends) {
        if start.z >= near_m {
            kept.push(*start);
        }
        if (start.z >= near_m) != (end.z >= near_m) {
            kept.push(start + (end - start) * ((near_m - start.z) / (end.z - start.z)));
        }
    }
    kept
}
