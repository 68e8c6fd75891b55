//! What a perfect sensor sees, and the truth about it.

use nalgebra::{Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::buffer::DepthBuffer;
use crate::error::CameraError;
use crate::intrinsics::Intrinsics;
use crate::noise::{Neighbourhood, NoiseModel};
use crate::points::{PointImage, hole};

/// Stands for no body.
const NOTHING: u32 = u32::MAX;

/// A perfect depth image with the body seen at each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    intrinsics: Intrinsics,
    depths_m: Vec<f32>,
    bodies: Vec<u32>,
    /// Cosine of the angle between the ray and the surface's normal; 0 where nothing is seen.
    incidence: Vec<f32>,
}

impl View {
    /// Nothing farther than `far_m` is seen; `normals` per facet in the camera frame; `first_facets` per body, ascending.
    pub(crate) fn new(
        intrinsics: Intrinsics,
        far_m: f64,
        buffer: &DepthBuffer,
        normals: &[Vector3<f32>],
        first_facets: &[u32],
    ) -> Self {
        let mut view = Self {
            intrinsics,
            depths_m: Vec::with_capacity(intrinsics.pixels()),
            bodies: Vec::with_capacity(intrinsics.pixels()),
            incidence: Vec::with_capacity(intrinsics.pixels()),
        };
        for pixel in 0..intrinsics.pixels() {
            let facet = buffer.facet(pixel);
            let depth_m = buffer.depth_m(pixel).unwrap_or(f32::NAN);
            let (Some(facet), true) = (facet, depth_m <= far_m as f32) else {
                view.depths_m.push(f32::NAN);
                view.bodies.push(NOTHING);
                view.incidence.push(0.0);
                continue;
            };
            let (u, v) = (pixel % intrinsics.width, pixel / intrinsics.width);
            let ray = intrinsics.ray(u as f64, v as f64).cast::<f32>();
            let normal = normals.get(facet as usize).copied().unwrap_or_default();
            let body = first_facets.partition_point(|first| *first <= facet);
            view.depths_m.push(depth_m);
            view.bodies.push(body.saturating_sub(1) as u32);
            view.incidence.push(normal.dot(&ray).abs() / ray.norm());
        }
        view
    }

    /// How points become pixels.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// The depths along the camera's z axis in metres, row by row; NaN where nothing is seen.
    pub fn depths_m(&self) -> &[f32] {
        &self.depths_m
    }

    /// The index of the body seen at column `u` of row `v`; `None` where nothing is seen and outside the image.
    pub fn body_at(&self, u: usize, v: usize) -> Option<usize> {
        if u >= self.intrinsics.width {
            return None;
        }
        self.body(v.checked_mul(self.intrinsics.width)?.checked_add(u)?)
    }

    /// The index of the body seen per pixel, row by row; `None` where nothing is seen.
    pub fn bodies(&self) -> impl Iterator<Item = Option<usize>> + '_ {
        (0..self.bodies.len()).map(|pixel| self.body(pixel))
    }

    /// Points without noise.
    pub fn points(&self) -> PointImage {
        let pixels = self.depths_m.iter().enumerate();
        let points = pixels.map(|(pixel, depth_m)| self.unproject(pixel, f64::from(*depth_m)));
        PointImage::new(self.intrinsics.width, points.collect())
    }

    /// Points as a real sensor would give them; equal seeds give equal noise.
    ///
    /// # Errors
    /// [`CameraError::Setting`] where the noise is impossible.
    pub fn noisy_points(&self, noise: &NoiseModel, seed: u64) -> Result<PointImage, CameraError> {
        noise.validate()?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let points = (0..self.depths_m.len()).map(|pixel| {
            let depth_m = noise.measure(&self.neighbourhood(pixel), &mut random);
            self.unproject(pixel, depth_m)
        });
        Ok(PointImage::new(self.intrinsics.width, points.collect()))
    }

    fn body(&self, pixel: usize) -> Option<usize> {
        let body = *self.bodies.get(pixel)?;
        (body != NOTHING).then_some(body as usize)
    }

    /// What the noise at a pixel depends on.
    fn neighbourhood(&self, pixel: usize) -> Neighbourhood {
        let width = self.intrinsics.width;
        let depth = |pixel: Option<usize>| {
            let depth_m = pixel.and_then(|pixel| self.depths_m.get(pixel).copied());
            f64::from(depth_m.unwrap_or(f32::NAN))
        };
        let column = pixel % width;
        let left = (column > 0).then(|| pixel - 1);
        let right = (column + 1 < width).then_some(pixel + 1);
        let ray = self.ray(pixel);
        Neighbourhood {
            depth_m: depth(Some(pixel)),
            neighbours_m: [left, right, pixel.checked_sub(width), Some(pixel + width)].map(depth),
            ray_length: ray.norm(),
            incidence: self.incidence.get(pixel).copied().map_or(0.0, f64::from),
        }
    }

    fn ray(&self, pixel: usize) -> Vector3<f64> {
        let (u, v) = (pixel % self.intrinsics.width, pixel / self.intrinsics.width);
        self.intrinsics.ray(u as f64, v as f64)
    }

    fn unproject(&self, pixel: usize, depth_m: f64) -> Point3<f32> {
        if depth_m.is_nan() {
            return hole();
        }
        Point3::from(self.ray(pixel) * depth_m).cast()
    }
}
