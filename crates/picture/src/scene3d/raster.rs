//! Which triangle is nearest at each pixel: the part that cameras and lights share.
//!
//! The crate `camera` has the other z-buffer. That one measures: `f64`, clipped at a near limit, for pinholes alone, with a
//! triangle's number per pixel. This one draws: `f32`, for the parallel rays of lights too, and what a pixel keeps is up to
//! who shades it.
#![allow(
    clippy::indexing_slicing,
    reason = "pixel indices stay below width x height, as each loop clamps its range; vertex indices are valid in every Geometry"
)]

use nalgebra::{Point2, Point3, Vector3};

use super::camera::Camera;
use super::geometry::Geometry;
use crate::image::Size;

/// Nothing closer to the eye than this, in metres, is drawn.
const NEAREST_M: f32 = 1e-3;

/// The extent of nothing: see [`ShadowMap::extent`].
const NO_EXTENT: [f32; 4] = [
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::INFINITY,
    f32::NEG_INFINITY,
];

/// A vertex in a picture: pixels from the top left, and a measure that grows towards the viewer and is linear across
/// the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projected {
    pub(super) x: f32,
    pub(super) y: f32,
    /// Not positive where the vertex cannot be drawn.
    pub(super) nearness: f32,
}

/// Calls `visit(pixel index, nearness)` for every pixel whose centre lies in the triangle.
#[inline]
pub(super) fn fill_triangle(
    [a, b, c]: [Projected; 3],
    width: usize,
    height: usize,
    mut visit: impl FnMut(usize, f32),
) {
    // Most triangles are about as small as a pixel, so that what covers no pixel's centre goes first. The casts
    // saturate: a range beyond the picture becomes empty or ends at its border.
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
    pub(super) eye: Point3<f32>,
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

    /// From the eye through a pixel's centre, as long as one metre of depth.
    #[inline]
    pub(super) fn ray(&self, column: usize, row: usize) -> Vector3<f32> {
        let x = (column as f32 + 0.5 - self.centre.x) / self.focal;
        let y = (self.centre.y - row as f32 - 0.5) / self.focal;
        self.forward + self.right * x + self.up * y
    }
}

/// What a camera sees: per pixel the nearest triangle.
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

    /// The triangle seen at a pixel, and its depth in metres.
    #[inline]
    pub(super) fn at(&self, pixel: usize) -> Option<(usize, f32)> {
        let nearness = self.nearness[pixel];
        (nearness > 0.0).then(|| (self.triangle[pixel] as usize, 1.0 / nearness))
    }
}

/// What a distant light sees: how far towards it the nearest surface is, over a square around the focus.
pub(super) struct ShadowMap {
    side: usize,
    texels_per_m: f32,
    focus: Point3<f32>,
    /// Along the map's columns and rows (in texels per metre) and towards the light (of unit length).
    axes: [Vector3<f32>; 3],
    /// The texels that anything can be drawn on: least and greatest column, least and greatest row.
    extent: [f32; 4],
    nearness: Vec<f32>,
    projected: Vec<Projected>,
}

impl ShadowMap {
    /// A map of `side` x `side` texels.
    pub(super) fn new(side: usize) -> Self {
        Self {
            side,
            texels_per_m: 1.0,
            focus: Point3::origin(),
            axes: [Vector3::zeros(); 3],
            extent: NO_EXTENT,
            nearness: vec![f32::NEG_INFINITY; side * side],
            projected: Vec::new(),
        }
    }

    /// Draws what casts shadows as seen from a light in the direction `towards_light`, which has unit length.
    pub(super) fn draw(&mut self, geometry: &Geometry, towards_light: &Vector3<f32>) {
        let (focus, radius) = geometry.focus;
        self.focus = focus;
        self.texels_per_m = self.side as f32 / (2.0 * radius);
        let right = towards_light
            .cross(&Vector3::z())
            .try_normalize(1e-3)
            .unwrap_or_else(Vector3::x);
        let down = right.cross(towards_light);
        self.axes = [
            right * self.texels_per_m,
            down * self.texels_per_m,
            *towards_light,
        ];

        self.nearness.fill(f32::NEG_INFINITY);
        let mut projected = std::mem::take(&mut self.projected);
        projected.clear();
        let casters = geometry.vertices.iter().take(geometry.caster_vertices);
        projected.extend(casters.map(|vertex| self.project(vertex)));
        self.extent = projected
            .iter()
            .fold(NO_EXTENT, |[low_x, high_x, low_y, high_y], at| {
                [
                    low_x.min(at.x),
                    high_x.max(at.x),
                    low_y.min(at.y),
                    high_y.max(at.y),
                ]
            });
        for triangle in geometry.triangles.iter().take(geometry.caster_triangles) {
            let corners = triangle.map(|corner| projected[corner as usize]);
            fill_triangle(corners, self.side, self.side, |texel, nearness| {
                let nearest = &mut self.nearness[texel];
                if nearness > *nearest {
                    *nearest = nearness;
                }
            });
        }
        self.projected = projected;
    }

    #[inline]
    fn project(&self, point: &Point3<f32>) -> Projected {
        let [right, down, towards_light] = &self.axes;
        let offset = point - self.focus;
        let half = self.side as f32 / 2.0;
        Projected {
            x: half + offset.dot(right),
            y: half + offset.dot(down),
            nearness: offset.dot(towards_light),
        }
    }

    /// The share of the light that reaches a point, from two looks around it: `spin` (cosine and sine) turns
    /// them, `radius_m` is how far they reach. Points outside the map are lit.
    #[inline]
    pub(super) fn visibility(
        &self,
        point: &Point3<f32>,
        normal: &Vector3<f32>,
        spin: [f32; 2],
        radius_m: f32,
    ) -> f32 {
        // One near and one far, on opposite sides; the passes turn them all around.
        const NEAR: f32 = 0.45;
        const FAR: f32 = -0.90;
        let texel_m = 1.0 / self.texels_per_m;
        // Looking from a little above the surface keeps it from shading itself.
        let lifted = self.project(&(point + normal * (1.5 * texel_m + 0.25 * radius_m)));
        let radius = radius_m * self.texels_per_m;
        let [low_x, high_x, low_y, high_y] = self.extent;
        let reached = lifted.x > low_x - radius
            && lifted.x < high_x + radius
            && lifted.y > low_y - radius
            && lifted.y < high_y + radius;
        if !reached {
            return 1.0;
        }
        let least = lifted.nearness + 0.5 * texel_m;
        let side = self.side as f32;
        let lit = |distance: f32| {
            let column = lifted.x + distance * radius * spin[0];
            let row = lifted.y + distance * radius * spin[1];
            let inside = column >= 0.0 && row >= 0.0 && column < side && row < side;
            !inside || self.nearness[row as usize * self.side + column as usize] <= least
        };
        0.5 * f32::from(u8::from(lit(NEAR)) + u8::from(lit(FAR)))
    }
}
