//! The projection of points to pixels.

use nalgebra::Vector3;
use ppnpack_numbers::require;
use serde::{Deserialize, Serialize};

use crate::error::CameraError;

/// Maximum of pixels along one side of an image.
const MAX_SIDE: f64 = 8192.0;

/// Share of the image that a framed rectangle fills, along the side that bounds it.
const FRAMING: f64 = 0.95;

/// The intrinsics of a pinhole camera without distortion, named as in camera drivers; in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Intrinsics {
    /// Columns of the image.
    pub width: usize,
    /// Rows of the image.
    pub height: usize,
    /// Focal length along x.
    pub fx: f64,
    /// Focal length along y.
    pub fy: f64,
    /// Column of the principal point; centres of pixels are whole numbers.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
}

impl Intrinsics {
    /// Gives a camera whose principal point is the middle of the image, with one focal length, in
    /// pixels.
    ///
    /// # Errors
    /// As [`validate`](Self::validate).
    pub fn centred(width: usize, height: usize, focal: f64) -> Result<Self, CameraError> {
        let intrinsics = Self {
            width,
            height,
            fx: focal,
            fy: focal,
            cx: (width as f64 - 1.0) / 2.0,
            cy: (height as f64 - 1.0) / 2.0,
        };
        intrinsics.validate()?;
        Ok(intrinsics)
    }

    /// Gives a camera that has all of a rectangle in the middle of its image, with a little room
    /// around it. The rectangle faces the camera: its sides run along the image's and are `sides_m`
    /// long, `distance_m` away.
    ///
    /// # Errors
    /// [`CameraError::Setting`] where there is no such image.
    pub fn framing(
        width: usize,
        height: usize,
        sides_m: [f64; 2],
        distance_m: f64,
    ) -> Result<Self, CameraError> {
        let [x_m, y_m] = sides_m;
        for side_m in sides_m {
            require("sides_m", side_m, "positive lengths", |side_m| side_m > 0.0)?;
        }
        let per_metre = (width as f64 / x_m).min(height as f64 / y_m);
        Self::centred(width, height, FRAMING * distance_m * per_metre)
    }

    /// Checks that every number is possible.
    ///
    /// # Errors
    /// [`CameraError::Setting`] names the first that is not.
    pub fn validate(&self) -> Result<(), CameraError> {
        let is_side = |side: f64| (1.0..=MAX_SIDE).contains(&side);
        require("width", self.width as f64, "1 to 8192", is_side)?;
        require("height", self.height as f64, "1 to 8192", is_side)?;
        require("fx", self.fx, "a positive number", |focal| focal > 0.0)?;
        require("fy", self.fy, "a positive number", |focal| focal > 0.0)?;
        require("cx", self.cx, "a finite number", |_| true)?;
        Ok(require("cy", self.cy, "a finite number", |_| true)?)
    }

    /// Counts the pixels of the image.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }

    /// Gives the ray through image coordinates, in the camera frame, as long as one metre of depth.
    pub fn ray(&self, u: f64, v: f64) -> Vector3<f64> {
        Vector3::new((u - self.cx) / self.fx, (v - self.cy) / self.fy, 1.0)
    }
}
