//! A depth buffer: the nearest triangle at each pixel.

use nalgebra::{Isometry3, Point3};

use crate::intrinsics::Intrinsics;

/// Maximum distance of a pixel's centre from a triangle that it still shows, in pixels: neighbours
/// leave no gap along their edge.
const EDGE_SLACK: f64 = 1e-6;

/// Number that stands for no triangle.
const NOTHING: u32 = u32::MAX;

/// A depth image in the making: per pixel the nearest surface and the triangle it belongs to.
///
/// Keeps its memory between images.
#[derive(Debug, Clone, Default)]
pub struct DepthBuffer {
    width: usize,
    height: usize,
    /// One over the depth, which is linear across the image; 0 where nothing was drawn.
    nearness: Vec<f32>,
    facets: Vec<u32>,
    vertices: Vec<Point3<f64>>,
    corners: Vec<Corner>,
}

/// A vertex on the image.
#[derive(Debug, Clone, Copy, Default)]
struct Corner {
    u: f64,
    v: f64,
    /// One over its depth; 0 where the vertex is nearer than the near limit.
    nearness: f64,
}

impl DepthBuffer {
    /// Clears the image and gives it the size of a camera's.
    pub fn clear(&mut self, intrinsics: &Intrinsics) {
        (self.width, self.height) = (intrinsics.width, intrinsics.height);
        self.nearness.clear();
        self.nearness.resize(intrinsics.pixels(), 0.0);
        self.facets.clear();
        self.facets.resize(intrinsics.pixels(), NOTHING);
    }

    /// Draws triangles of a frame of their own, from both sides, where they are not nearer than
    /// `near_m`; facets are the triangles' numbers. Triangles with a missing vertex or a coordinate
    /// that is not finite are left out.
    pub fn draw(
        &mut self,
        intrinsics: &Intrinsics,
        near_m: f64,
        camera_from_body: &Isometry3<f64>,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
    ) {
        let rotation = camera_from_body.rotation.to_rotation_matrix();
        let translation = camera_from_body.translation.vector;
        self.vertices.clear();
        let moved = vertices.iter().map(|point| rotation * point + translation);
        self.vertices.extend(moved);
        self.corners.clear();
        let vertices = self.vertices.iter();
        self.corners
            .extend(vertices.map(|point| match point.z >= near_m {
                true => corner(intrinsics, point),
                false => Corner::default(),
            }));
        for (facet, triangle) in (0..).zip(triangles) {
            let [a, b, c] = triangle.map(|index| self.corners.get(index as usize).copied());
            let (Some(a), Some(b), Some(c)) = (a, b, c) else {
                continue;
            };
            if a.nearness > 0.0 && b.nearness > 0.0 && c.nearness > 0.0 {
                self.fill([a, b, c], facet);
            } else if a.nearness > 0.0 || b.nearness > 0.0 || c.nearness > 0.0 {
                self.fill_clipped(intrinsics, near_m, triangle, facet);
            }
        }
    }

    /// Gives the depth at a pixel (numbered row by row) in metres; `None` where nothing was drawn.
    pub fn depth_m(&self, pixel: usize) -> Option<f32> {
        let nearness = *self.nearness.get(pixel)?;
        (nearness > 0.0).then(|| 1.0 / nearness)
    }

    /// Gives one over the depth per pixel, row by row, in 1/m; 0 where nothing was drawn.
    pub fn nearness_per_m(&self) -> &[f32] {
        &self.nearness
    }

    /// Gives the facet at a pixel; `None` where nothing was drawn.
    pub fn facet(&self, pixel: usize) -> Option<u32> {
        let facet = *self.facets.get(pixel)?;
        (facet != NOTHING).then_some(facet)
    }

    /// Draws the part of a triangle beyond the near limit.
    fn fill_clipped(
        &mut self,
        intrinsics: &Intrinsics,
        near_m: f64,
        triangle: &[u32; 3],
        facet: u32,
    ) {
        let [a, b, c] = triangle.map(|index| self.vertices.get(index as usize).copied());
        let (Some(a), Some(b), Some(c)) = (a, b, c) else {
            return;
        };
        let mut polygon = Vec::with_capacity(4);
        for (start, end) in [(a, b), (b, c), (c, a)] {
            if start.z >= near_m {
                polygon.push(corner(intrinsics, &start));
            }
            if (start.z >= near_m) != (end.z >= near_m) {
                let share = (near_m - start.z) / (end.z - start.z);
                polygon.push(corner(intrinsics, &(start + (end - start) * share)));
            }
        }
        if let Some((first, rest)) = polygon.split_first() {
            for (second, third) in rest.iter().zip(rest.iter().skip(1)) {
                self.fill([*first, *second, *third], facet);
            }
        }
    }

    /// Draws one triangle: per row the pixels between its edges.
    fn fill(&mut self, [a, b, c]: [Corner; 3], facet: u32) {
        let first_row = pixel_from(a.v.min(b.v).min(c.v));
        let end_row = pixel_to(a.v.max(b.v).max(c.v)).min(self.height);
        let first_column = pixel_from(a.u.min(b.u).min(c.u));
        let end_column = pixel_to(a.u.max(b.u).max(c.u)).min(self.width);
        // Most triangles are about as small as a pixel, so that what covers no pixel's centre goes
        // first.
        if first_row >= end_row || first_column >= end_column {
            return;
        }
        let doubled_area = (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
        if !doubled_area.is_finite() || doubled_area.abs() < 1e-12 {
            return;
        }
        let (b, c) = if doubled_area > 0.0 { (b, c) } else { (c, b) };
        let doubled_area = doubled_area.abs();
        let edges = [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)];
        let from_b = (b.nearness - a.nearness) / doubled_area;
        let from_c = (c.nearness - a.nearness) / doubled_area;
        // The plane of nearness over the image.
        let per_u = from_b * (c.v - a.v) - from_c * (b.v - a.v);
        let per_v = from_c * (b.u - a.u) - from_b * (c.u - a.u);
        for row in first_row..end_row {
            let v = row as f64;
            let (mut start, mut end) = (first_column, end_column);
            for edge in &edges {
                edge.clip(v, &mut start, &mut end);
            }
            if start >= end {
                continue;
            }
            let range = row * self.width + start..row * self.width + end;
            let nearness = self.nearness.get_mut(range.clone());
            let (Some(nearness), Some(facets)) = (nearness, self.facets.get_mut(range)) else {
                continue;
            };
            let mut here = a.nearness + (start as f64 - a.u) * per_u + (v - a.v) * per_v;
            for (nearness, seen) in nearness.iter_mut().zip(facets) {
                if here as f32 > *nearness {
                    *nearness = here as f32;
                    *seen = facet;
                }
                here += per_u;
            }
        }
    }
}

/// An edge as a function of the image that is positive inside its triangle.
struct Edge {
    per_u: f64,
    per_v: f64,
    constant: f64,
    slack: f64,
}

impl Edge {
    fn new(from: Corner, to: Corner) -> Self {
        let (per_u, per_v) = (from.v - to.v, to.u - from.u);
        Self {
            per_u,
            per_v,
            constant: -(per_u * from.u + per_v * from.v),
            slack: EDGE_SLACK * (per_u.abs() + per_v.abs()),
        }
    }

    /// Narrows a range of columns to those inside the edge on a row.
    fn clip(&self, v: f64, start: &mut usize, end: &mut usize) {
        let at_zero = self.per_v * v + self.constant + self.slack;
        if self.per_u > 0.0 {
            *start = (*start).max((-at_zero / self.per_u).ceil().max(0.0) as usize);
        } else if self.per_u < 0.0 {
            let last = (-at_zero / self.per_u).floor();
            // Casts saturate: what is left of the image becomes an empty range.
            *end = (*end).min((last + 1.0).max(0.0) as usize);
        } else if at_zero < 0.0 {
            *end = *start;
        }
    }
}

fn corner(intrinsics: &Intrinsics, point: &Point3<f64>) -> Corner {
    let nearness = 1.0 / point.z;
    Corner {
        u: intrinsics.fx * point.x * nearness + intrinsics.cx,
        v: intrinsics.fy * point.y * nearness + intrinsics.cy,
        nearness,
    }
}

/// Gives the first pixel whose centre is not before a coordinate. Casts saturate: NaN and what is
/// negative become 0.
fn pixel_from(coordinate: f64) -> usize {
    (coordinate - EDGE_SLACK).ceil() as usize
}

/// Gives one past the last pixel whose centre is not beyond a coordinate.
fn pixel_to(coordinate: f64) -> usize {
    ((coordinate + EDGE_SLACK).floor() + 1.0) as usize
}
