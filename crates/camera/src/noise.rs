//! What a real sensor adds to a perfect depth image.

use ppnpack_numbers::{gaussian, require};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use crate::error::CameraError;

/// The noise of a depth sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NoiseModel {
    /// Standard deviation along the ray, in metres.
    pub deviation_m: f64,
    /// What the deviation grows by with the squared depth, in m per m^2: the noise of stereo and structured light.
    pub deviation_per_m2: f64,
    /// The share of pixels that measure nothing.
    pub dropout: f64,
    /// Surfaces whose normal is further than this from the ray are not measured, in radians.
    pub grazing_limit_rad: f64,
    /// What happens where the depth jumps.
    pub edges: DepthEdges,
    /// Depths are rounded to multiples of this, in metres; 0 leaves them as they are.
    pub quantisation_m: f64,
}

/// What happens at pixels beside a jump of the depth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DepthEdges {
    /// Neighbours whose depths differ by more than this are a jump, in metres.
    pub jump_m: f64,
    /// The share of pixels beside a jump that measure nothing.
    pub dropout: f64,
    /// The share of pixels beside a jump that measure any depth between both sides.
    pub flying_pixels: f64,
}

impl Default for DepthEdges {
    fn default() -> Self {
        Self {
            jump_m: 0.01,
            dropout: 0.0,
            flying_pixels: 0.0,
        }
    }
}

impl Default for NoiseModel {
    /// 1 mm and 5 % dropouts, nothing else.
    fn default() -> Self {
        Self {
            deviation_m: 0.001,
            dropout: 0.05,
            ..Self::none()
        }
    }
}

/// What the noise at a pixel depends on; depths are NaN where nothing is seen.
pub(crate) struct Neighbourhood {
    pub(crate) depth_m: f64,
    pub(crate) neighbours_m: [f64; 4],
    /// The length of the ray to one metre of depth.
    pub(crate) ray_length: f64,
    /// Cosine of the angle between the ray and the surface's normal.
    pub(crate) incidence: f64,
}

impl NoiseModel {
    /// A perfect sensor.
    pub fn none() -> Self {
        Self {
            deviation_m: 0.0,
            deviation_per_m2: 0.0,
            dropout: 0.0,
            grazing_limit_rad: std::f64::consts::FRAC_PI_2,
            edges: DepthEdges::default(),
            quantisation_m: 0.0,
        }
    }

    /// Checks that every number is possible.
    ///
    /// # Errors
    /// [`CameraError::Setting`] names the first that is not.
    pub fn validate(&self) -> Result<(), CameraError> {
        let is_length = |value: f64| (0.0..=1.0).contains(&value);
        let lengths = [
            ("deviation_m", self.deviation_m),
            ("deviation_per_m2", self.deviation_per_m2),
            ("edges.jump_m", self.edges.jump_m),
            ("quantisation_m", self.quantisation_m),
        ];
        for (name, value) in lengths {
            require(name, value, "0 to 1 m", is_length)?;
        }
        let shares = [
            ("dropout", self.dropout),
            ("edges.dropout", self.edges.dropout),
            ("edges.flying_pixels", self.edges.flying_pixels),
        ];
        for (name, value) in shares {
            require(name, value, "0 to 1", is_length)?;
        }
        let is_angle = |angle: f64| (0.0..=std::f64::consts::FRAC_PI_2).contains(&angle);
        let limit_rad = self.grazing_limit_rad;
        require("grazing_limit_rad", limit_rad, "0 to pi / 2", is_angle)?;
        Ok(())
    }

    /// The depth that is measured at a pixel, in metres; NaN where nothing is.
    ///
    /// Takes the same count of random numbers for every pixel, so that each pixel's noise depends on the seed alone.
    pub(crate) fn measure(&self, pixel: &Neighbourhood, random: &mut impl Rng) -> f64 {
        let [chance, edge_chance, share, first, second]: [f32; 5] = random.random();
        let depth_m = pixel.depth_m;
        let is_grazing = pixel.incidence < self.grazing_limit_rad.cos() - 1e-9;
        if depth_m.is_nan() || f64::from(chance) < self.dropout || is_grazing {
            return f64::NAN;
        }
        let beyond_m = self.far_side(pixel);
        let edge_chance = f64::from(edge_chance);
        let mut measured_m = depth_m;
        if let Some(beyond_m) = beyond_m {
            if edge_chance < self.edges.dropout {
                return f64::NAN;
            }
            if edge_chance < self.edges.dropout + self.edges.flying_pixels {
                measured_m += (beyond_m - depth_m) * f64::from(share);
            }
        }
        let deviation_m = self.deviation_m + self.deviation_per_m2 * depth_m * depth_m;
        let along_ray_m = deviation_m * gaussian(f64::from(first), f64::from(second));
        measured_m += along_ray_m / pixel.ray_length;
        if self.quantisation_m > 0.0 {
            measured_m = (measured_m / self.quantisation_m).round() * self.quantisation_m;
        }
        if measured_m > 0.0 {
            measured_m
        } else {
            f64::NAN
        }
    }

    /// The neighbouring depth beyond the greatest jump, in metres; `None` without one.
    fn far_side(&self, pixel: &Neighbourhood) -> Option<f64> {
        let jump_m = |other_m: &f64| (other_m - pixel.depth_m).abs();
        pixel
            .neighbours_m
            .iter()
            .copied()
            .filter(|other_m| jump_m(other_m) > self.edges.jump_m)
            .max_by(|a, b| jump_m(a).total_cmp(&jump_m(b)))
    }
}
