//! A sensor's pose as it stands in configuration.

use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// How far the norm of a quaternion may be from 1.
const NORM_TOLERANCE: f64 = 1e-3;

/// A norm this close to 1 is that of a unit quaternion, rounded: it is kept bit for bit.
const ROUNDING: f64 = 1e-9;

/// The farthest a sensor may be, in metres.
const FARTHEST_M: f64 = 1000.0;

/// Where a sensor is and how it is turned, seen from the container: takes points of its frame to the container's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Extrinsics {
    /// Where the sensor's origin is in the container's frame, in metres.
    pub position_m: [f64; 3],
    /// How the sensor is turned in the container's frame: a unit quaternion, its real part last.
    pub orientation_xyzw: [f64; 4],
}

/// Numbers that are no pose.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExtrinsicsError {
    /// A position that is not finite or far away.
    #[error("the position {position_m:?} is not within {FARTHEST_M} m")]
    Position {
        /// The position, in metres.
        position_m: [f64; 3],
    },
    /// A quaternion whose norm is not 1.
    #[error("the orientation {orientation_xyzw:?} is no unit quaternion")]
    Orientation {
        /// The quaternion.
        orientation_xyzw: [f64; 4],
    },
}

impl Extrinsics {
    /// The pose, `container_from_sensor`.
    ///
    /// # Errors
    /// [`ExtrinsicsError`] where a number is not possible.
    pub fn pose(&self) -> Result<Isometry3<f64>, ExtrinsicsError> {
        let is_near = |side_m: &f64| side_m.abs() <= FARTHEST_M;
        if !self.position_m.iter().all(is_near) {
            return Err(ExtrinsicsError::Position {
                position_m: self.position_m,
            });
        }
        let quaternion = Quaternion::from(self.orientation_xyzw);
        let off = (quaternion.norm() - 1.0).abs();
        let rotation = match off {
            off if off <= ROUNDING => Unit::new_unchecked(quaternion),
            off if off <= NORM_TOLERANCE => UnitQuaternion::new_normalize(quaternion),
            _ => {
                return Err(ExtrinsicsError::Orientation {
                    orientation_xyzw: self.orientation_xyzw,
                });
            }
        };
        Ok(Isometry3::from_parts(
            Translation3::from(self.position_m),
            rotation,
        ))
    }
}

impl From<&Isometry3<f64>> for Extrinsics {
    fn from(container_from_sensor: &Isometry3<f64>) -> Self {
        Self {
            position_m: container_from_sensor.translation.vector.into(),
            orientation_xyzw: container_from_sensor.rotation.coords.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_come_back_bit_for_bit() {
        let pose = Isometry3::from_parts(
            Translation3::new(0.1, -0.2, 0.9),
            UnitQuaternion::from_euler_angles(3.0, 0.2, -0.4),
        );
        assert_eq!(Extrinsics::from(&pose).pose().unwrap(), pose);
    }

    #[test]
    fn a_quaternion_has_its_real_part_last() {
        let extrinsics = Extrinsics {
            position_m: [0.0; 3],
            orientation_xyzw: [1.0, 0.0, 0.0, 0.0],
        };
        let half_turn = extrinsics.pose().unwrap() * nalgebra::Point3::new(0.1, 0.2, 0.3);
        assert!((half_turn - nalgebra::Point3::new(0.1, -0.2, -0.3)).norm() < 1e-12);
    }

    #[test]
    fn impossible_numbers_are_refused() {
        let refused = |position_m: [f64; 3], orientation_xyzw: [f64; 4]| {
            let extrinsics = Extrinsics {
                position_m,
                orientation_xyzw,
            };
            extrinsics.pose().unwrap_err().to_string()
        };
        let upright = [0.0, 0.0, 0.0, 1.0];
        assert!(refused([f64::NAN, 0.0, 0.0], upright).contains("position"));
        assert!(refused([0.0, 1e9, 0.0], upright).contains("position"));
        assert!(refused([0.0; 3], [0.0; 4]).contains("orientation"));
        assert!(refused([0.0; 3], [f64::NAN; 4]).contains("orientation"));
        assert!(refused([0.0; 3], [0.0, 0.0, 0.0, 2.0]).contains("orientation"));
    }
}
