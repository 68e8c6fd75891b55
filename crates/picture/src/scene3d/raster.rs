//! The nearest triangle at each pixel.
//!
//! The crate `camera` has the other z-buffer. That one measures: `f64`, clipped at a near limit.
//! This one draws, in `f32`.
#![allow(
    clippy::indexing_slicing,
    reason = "pixel indices stay below width x height, as each loop clamps its range; vertex indices are valid in every Geometry"
)]

use nalgebra::{Point2, Point3, Vector3};

use super::camera::Camera;
use super::geometry::Geometry;
use crate::image::Size;

/// Minimum distance from the eye at which something is drawn, in metres.
const NEAREST_M: f32 = 1e-3;

/// A vertex in a picture: pixels from the top left, and a measure that grows towards the viewer and
/// is linear across the picture.
#[derive(Debug, Clone, Copy)]
struct Projected {
    x: f32,
    y: f32,
    /// Not positive where the vertex cannot be drawn.
    nearness: f32,
}

/// Calls `visit(pixel index, nearness)` for every pixel whose centre lies in the triangle.
#[inline]
fn fill_triangle(
    [a, b, c]: [Projected; 3],
    width: usize,
    height: usize,
    mut visit: impl FnMut(usize, f32),
) {
    // Most triangles are about as small as a pixel, so that what covers no pixel's centre goes
    // first. The casts saturate: a range beyond the picture becomes empty or ends at its border.
    let first_column = (a.x.min(b.x).min(c.x) + 0.5).max(0.0) as usize;
    let first_row = (a.y.min(b.y).min(c.y) + 0.5).max(0.0) as usize;
    let end_column = ((a.x.max(b.x).max(c.x) + 0.5).max(0.0) as usize).min(width);
    let end_row = ((a.y.max(b.y).max(c.y) + 0.5).max(0.0) as usize).min(height);
    if first_column >= end_column || first_row >= end_row {
        return;
    }
    let doubled_area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if doubled_area.is_nan() || doubled_area.abs() <= 1e-12 {
        return;
    }
    // Shares of b and c at the first pixel's centre, and their steps per pixel.
    let scale = 1.0 / doubled_area;
    let (x, y) = (
        first_column as f32 + 0.5 - a.x,
        first_row as f32 + 0.5 - a.y,
    );
    let (b_per_x, b_per_y) = ((c.y - a.y) * scale, -(c.x - a.x) * scale);
    let (c_per_x, c_per_y) = (-(b.y - a.y) * scale, (b.x - a.x) * scale);
    let mut b_row = x * b_per_x + y * b_per_y;
    let mut c_row = x * c_per_x + y * c_per_y;
    let (from_b, from_c) = (b.nearness - a.nearness, c.nearness - a.nearness);
    for row in first_row..end_row {
        let (mut b_share, mut c_share) = (b_row, c_row);
        for column in first_column..end_column {
            // One branch instead of three, as none of them is predictable.
            if (b_share >= 0.0) & (c_share >= 0.0) & (b_share + c_share <= 1.0) {
                visit(
                    row * width + column,
                    a.nearness + b_share * from_b + c_share * from_c,
                );
            }
            b_share += b_per_x;
            c_share += c_per_x;
        }
        b_row += b_per_y;
        c_row += c_per_y;
    }
}

/// A camera aimed at a picture of a given size.
#[derive(Debug, Clone)]
pub(super) struct Lens {
    eye: Point3<f32>,
    forward: Vector3<f32>,
    right: Vector3<f32>,
    up: Vector3<f32>,
    /// Pixels per unit of slope.
    focal: f32,
    centre: Point2<f32>,
}

impl Lens {
    /// `offset` moves the picture by a part of a pixel.
    pub(super) fn new(camera: &Camera, size: Size, offset: [f32; 2]) -> Self {
        let forward = (camera.target - camera.eye)
            .try_normalize(1e-12)
            .unwrap_or_else(|| -Vector3::z())
            .map(|value| value as f32);
        let right = forward
            .cross(&Vector3::z())
            .try_normalize(1e-6)
            .unwrap_or_else(Vector3::x);
        let (width, height) = (size.width() as f32, size.height() as f32);
        let slope = (camera.field_of_view_rad / 2.0).tan() as f32;
        Self {
            eye: camera.eye.map(|value| value as f32),
            forward,
            right,
            up: right.cross(&forward),
            focal: width.min(height) / 2.0 / slope.max(1e-3),
            centre: Point2::new(width / 2.0 + offset[0], height / 2.0 + offset[1]),
        }
    }

    fn project(&self, point: &Point3<f32>) -> Projected {
        let offset = point - self.eye;
        let depth = offset.dot(&self.forward);
        if depth.is_nan() || depth < NEAREST_M {
            return Projected {
                x: 0.0,
                y: 0.0,
                nearness: 0.0,
            };
        }
        let scale = self.focal / depth;
        Projected {
            x: self.centre.x + scale * offset.dot(&self.right),
            y: self.centre.y - scale * offset.dot(&self.up),
            nearness: 1.0 / depth,
        }
    }
}

/// The view of a camera: per pixel the nearest triangle.
pub(super) struct View {
    width: usize,
    height: usize,
    nearness: Vec<f32>,
    triangle: Vec<u32>,
    projected: Vec<Projected>,
}

impl View {
    pub(super) fn new(size: Size) -> Self {
        Self {
            width: size.width() as usize,
            height: size.height() as usize,
            nearness: vec![0.0; size.pixels()],
            triangle: vec![0; size.pixels()],
            projected: Vec::new(),
        }
    }

    /// Triangles that reach behind the eye are left out.
    pub(super) fn draw(&mut self, geometry: &Geometry, lens: &Lens) {
        self.nearness.fill(0.0);
        self.projected.clear();
        self.projected
            .extend(geometry.vertices.iter().map(|vertex| lens.project(vertex)));
        for (number, triangle) in (0..).zip(&geometry.triangles) {
            let corners = triangle.map(|corner| self.projected[corner as usize]);
            if corners.iter().all(|corner| corner.nearness > 0.0) {
                fill_triangle(corners, self.width, self.height, |pixel, nearness| {
                    if nearness > self.nearness[pixel] {
                        self.nearness[pixel] = nearness;
                        self.triangle[pixel] = number;
                    }
                });
            }
        }
    }

    /// The triangle seen at a pixel.
    #[inline]
    pub(super) fn at(&self, pixel: usize) -> Option<usize> {
        let nearness = self.nearness.get(pixel)?;
        (*nearness > 0.0).then(|| self.triangle[pixel] as usize)
    }
}
