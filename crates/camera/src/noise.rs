//! The noise that a real sensor adds to a perfect depth image.

use ppnpack_numbers::{gaussian, settings, within};
use rand::{Rng, RngExt};

settings! {
    /// The noise of a depth sensor.
    ///
    /// 1 mm and 5 % dropouts.
    #[derive(Copy)]
    pub struct NoiseModel with validate as "noise." {
        /// Standard deviation along the ray, in metres.
        pub sigma_m: f64 = 0.001 => within("0 to 1 m", 0.0..=1.0),
        /// The share of pixels that measure nothing.
        pub dropout: f64 = 0.05 => within("0 to 1", 0.0..=1.0),
        /// Depths are rounded to a multiple of this, in metres; 0 leaves them as they are.
        pub step_m: f64 = 0.0 => within("0 to 1 m", 0.0..=1.0),
    }
}

impl NoiseModel {
    /// Gives a perfect sensor.
    pub fn none() -> Self {
        Self {
            sigma_m: 0.0,
            dropout: 0.0,
            step_m: 0.0,
        }
    }

    /// Measures the depth at a pixel, in metres; NaN where nothing is measured. A ray has
    /// `ray_length` for each metre of depth.
    ///
    /// Takes the same count of random numbers for every pixel, so that each pixel's noise depends
    /// on the seed alone. Two of them are not used: recorded figures were made with that many.
    pub(crate) fn measure(&self, depth_m: f64, ray_length: f64, random: &mut impl Rng) -> f64 {
        let [chance, _, _, first, second]: [f32; 5] = random.random();
        if depth_m.is_nan() || f64::from(chance) < self.dropout {
            return f64::NAN;
        }
        let along_ray_m = self.sigma_m * gaussian(f64::from(first), f64::from(second));
        let mut measured_m = depth_m + along_ray_m / ray_length;
        if self.step_m > 0.0 {
            measured_m = (measured_m / self.step_m).round() * self.step_m;
        }
        if measured_m > 0.0 {
            measured_m
        } else {
            f64::NAN
        }
    }
}
