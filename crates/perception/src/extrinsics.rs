//! A sensor's pose as it stands in configuration.

use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// Maximum distance of a quaternion's norm from 1.
const NORM_TOLERANCE: f64 = 1e-3;

/// Maximum distance from 1 of the norm of a unit quaternion that was rounded: it is kept bit for
/// bit.
const ROUNDING: f64 = 1e-9;

/// Maximum distance of a sensor, in metres.
const FARTHEST_M: f64 = 1000.0;

/// The pose of a sensor, which takes points of its frame to the container's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Extrinsics {
    /// The sensor's origin in the container's frame, in metres.
    pub position_m: [f64; 3],
    /// The sensor's orientation in the container's frame: a unit quaternion, its real part last.
    pub orientation_xyzw: [f64; 4],
}

/// Numbers that are no pose, for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ExtrinsicsError(String);

impl Extrinsics {
    /// Gives the pose, `container_from_sensor`.
    pub fn pose(&self) -> Result<Isometry3<f64>, ExtrinsicsError> {
        let is_near = |side_m: &f64| side_m.abs() <= FARTHEST_M;
        if !self.position_m.iter().all(is_near) {
            return Err(ExtrinsicsError(format!(
                "the position {:?} is not within {FARTHEST_M} m",
                self.position_m
            )));
        }
        let quaternion = Quaternion::from(self.orientation_xyzw);
        let rotation = match (quaternion.norm() - 1.0).abs() {
            off if off <= ROUNDING => Unit::new_unchecked(quaternion),
            off if off <= NORM_TOLERANCE => UnitQuaternion::new_normalize(quaternion),
            _ => {
                let given = self.orientation_xyzw;
                return Err(ExtrinsicsError(format!(
                    "the orientation {given:?} is no unit quaternion"
                )));
            }
        };
        let position = Translation3::from(self.position_m);
        Ok(Isometry3::from_parts(position, rotation))
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
        let turn = UnitQuaternion::from_euler_angles(3.0, 0.2, -0.4);
        let pose = Translation3::new(0.1, -0.2, 0.9) * turn;
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
