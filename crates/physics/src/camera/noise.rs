//! What a real sensor adds to an ideal depth image.

use ppnpack_numbers::{gaussian, require};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use crate::error::PhysicsError;

/// Noise of a depth sensor; the default is none.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DepthNoise {
    /// Standard deviation of the depth, in metres.
    pub sigma_m: f64,
    /// The share of pixels that see nothing.
    pub dropout: f64,
    /// Depths are rounded to a multiple of this, in metres; 0 leaves them as they are.
    pub step_m: f64,
}

impl DepthNoise {
    /// Checks that every number is possible.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] for the first that is not.
    pub fn validate(&self) -> Result<(), PhysicsError> {
        let is_length = |value: f64| (0.0..=1.0).contains(&value);
        require(
            "the depth noise",
            self.sigma_m,
            "between 0 and 1 m",
            is_length,
        )?;
        require("the dropout", self.dropout, "between 0 and 1", is_length)?;
        Ok(require(
            "the depth step",
            self.step_m,
            "between 0 and 1 m",
            is_length,
        )?)
    }

    /// A depth as the sensor would report it, in metres; NaN where it sees nothing.
    ///
    /// Takes the same count of random numbers for every depth, so that each pixel's noise depends on the seed alone.
    pub(super) fn apply(&self, depth_m: f32, random: &mut impl Rng) -> f32 {
        let [chance, first, second]: [f64; 3] = random.random();
        if chance < self.dropout {
            return f32::NAN;
        }
        let mut noisy_m = f64::from(depth_m) + self.sigma_m * gaussian(first, second);
        if self.step_m > 0.0 {
            noisy_m = (noisy_m / self.step_m).round() * self.step_m;
        }
        if noisy_m > 0.0 {
            noisy_m as f32
        } else {
            f32::NAN
        }
    }
}
