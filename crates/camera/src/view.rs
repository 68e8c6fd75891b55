//! What a perfect sensor sees.

use nalgebra::{Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::buffer::DepthBuffer;
use crate::error::CameraError;
use crate::intrinsics::Intrinsics;
use crate::noise::NoiseModel;
use crate::points::{PointImage, hole};

/// A perfect depth image.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    intrinsics: Intrinsics,
    depths_m: Vec<f32>,
}

impl View {
    /// Nothing farther than `far_m` is seen.
    pub(crate) fn new(intrinsics: Intrinsics, far_m: f64, buffer: &DepthBuffer) -> Self {
        let depth_m = |pixel| {
            buffer
                .depth_m(pixel)
                .filter(|depth_m| *depth_m <= far_m as f32)
        };
        let depths_m = (0..intrinsics.pixels()).map(|pixel| depth_m(pixel).unwrap_or(f32::NAN));
        Self {
            intrinsics,
            depths_m: depths_m.collect(),
        }
    }

    /// The depths along the camera's z axis in metres, row by row; NaN where nothing is seen.
    pub fn depths_m(&self) -> &[f32] {
        &self.depths_m
    }

    /// Points without noise.
    pub fn points(&self) -> PointImage {
        self.points_of(|_, depth_m| depth_m)
    }

    /// Points as a real sensor would give them; equal seeds give equal noise.
    ///
    /// # Errors
    /// [`CameraError::Setting`] where the noise is impossible.
    pub fn noisy_points(&self, noise: &NoiseModel, seed: u64) -> Result<PointImage, CameraError> {
        noise.validate()?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        Ok(self.points_of(|ray, depth_m| noise.measure(depth_m, ray.norm(), &mut random)))
    }

    /// The points of all pixels, from each one's ray and depth.
    fn points_of(&self, mut measured_m: impl FnMut(&Vector3<f64>, f64) -> f64) -> PointImage {
        let width = self.intrinsics.width;
        let points = self.depths_m.iter().enumerate().map(|(pixel, depth_m)| {
            let ray = self
                .intrinsics
                .ray((pixel % width) as f64, (pixel / width) as f64);
            let depth_m = measured_m(&ray, f64::from(*depth_m));
            match depth_m.is_nan() {
                true => hole(),
                false => Point3::from(ray * depth_m).cast(),
            }
        });
        PointImage::new(width, points.collect())
    }
}
