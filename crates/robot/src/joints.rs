//! Joint angles and the limits of joints.

use std::f64::consts::{PI, TAU};

use crate::parameters::JointParameters;

pub use ppnpack_packing::checks::motion::JOINTS;

/// A joint, counted from the base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Joint {
    /// Turns the whole arm.
    J1,
    /// The shoulder.
    J2,
    /// The elbow.
    J3,
    /// Turns the forearm.
    J4,
    /// Bends the wrist.
    J5,
    /// Turns the flange.
    J6,
}

impl Joint {
    /// All joints, from the base.
    pub const ALL: [Self; JOINTS] = [Self::J1, Self::J2, Self::J3, Self::J4, Self::J5, Self::J6];
}

/// The angles of J1 to J6 in the coordinates of the arm's controller, in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointAngles([f64; JOINTS]);

impl JointAngles {
    /// Takes angles in radians.
    pub const fn new(angles_rad: [f64; JOINTS]) -> Self {
        Self(angles_rad)
    }

    /// Gives the angles in radians, J1 first.
    pub const fn as_array(&self) -> &[f64; JOINTS] {
        &self.0
    }

    /// Turns J6 further.
    #[must_use]
    pub(crate) fn with_flange_turned(mut self, by_rad: f64) -> Self {
        let [.., flange] = &mut self.0;
        *flange += by_rad;
        self
    }

    /// Brings each angle within half a turn of another's, for the same pose.
    #[must_use]
    pub(crate) fn unwrapped_near(mut self, other: &Self) -> Self {
        for (angle, near) in self.0.iter_mut().zip(&other.0) {
            *angle = near + wrapped(*angle - near);
        }
        self
    }

    /// Finds the joint whose angle differs most, and by how much.
    pub(crate) fn greatest_step(&self, other: &Self) -> (Joint, f64) {
        let steps = self.0.iter().zip(&other.0).map(|(a, b)| (a - b).abs());
        let greater = |most: (Joint, f64), step: (Joint, f64)| {
            if step.1 > most.1 { step } else { most }
        };
        Joint::ALL
            .into_iter()
            .zip(steps)
            .fold((Joint::J1, 0.0), greater)
    }
}

/// Gives the angle in `[-pi, pi)` that stands for the same direction.
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

/// The limits of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimits {
    /// The least angle, in radians.
    pub lowest_rad: f64,
    /// The greatest angle, in radians.
    pub highest_rad: f64,
    /// The greatest speed, in radians per second.
    pub speed_rad_per_s: f64,
    /// The greatest acceleration, in radians per second squared.
    pub acceleration_rad_per_s2: f64,
}

impl JointLimits {
    pub(crate) fn new(parameters: &JointParameters) -> Self {
        Self {
            lowest_rad: parameters.lowest_deg.to_radians(),
            highest_rad: parameters.highest_deg.to_radians(),
            speed_rad_per_s: parameters.speed_deg_per_s.to_radians(),
            acceleration_rad_per_s2: parameters.acceleration_deg_per_s2.to_radians(),
        }
    }

    /// Says whether an angle is allowed.
    pub fn contains(&self, angle_rad: f64) -> bool {
        (self.lowest_rad..=self.highest_rad).contains(&angle_rad)
    }

    /// Gives the whole turns to add so that a range of angles is allowed and its middle lies
    /// nearest to `near_rad`.
    pub(crate) fn turns_into(&self, range_rad: (f64, f64), near_rad: f64) -> Option<f64> {
        let (lowest, highest) = range_rad;
        let first = ((self.lowest_rad - lowest) / TAU).ceil();
        let last = ((self.highest_rad - highest) / TAU).floor();
        if first > last {
            return None;
        }
        let wanted = ((near_rad - 0.5 * (lowest + highest)) / TAU).round();
        Some(wanted.clamp(first, last) * TAU)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_turned_into_the_limits_nearest_to_where_it_is_wanted() {
        let limits = JointLimits {
            lowest_rad: -TAU,
            highest_rad: TAU,
            speed_rad_per_s: 1.0,
            acceleration_rad_per_s2: 1.0,
        };
        assert_eq!(limits.turns_into((3.0, 3.1), 0.0), Some(0.0));
        assert_eq!(limits.turns_into((3.0, 3.1), -6.0), Some(-TAU));
        assert_eq!(limits.turns_into((3.0, 3.1), 9.0), Some(0.0));
        assert_eq!(limits.turns_into((7.0, 8.0), 9.0), Some(-TAU));
        assert_eq!(limits.turns_into((-7.0, 7.0), 0.0), None);
    }

    #[test]
    fn angles_wrap_to_half_a_turn_of_zero() {
        assert!((wrapped(3.5 * PI) + 0.5 * PI).abs() < 1e-12);
        assert!((wrapped(-PI) + PI).abs() < 1e-12);
        let near = JointAngles::new([6.0; JOINTS]);
        let angle = JointAngles::new([0.0; JOINTS]).unwrapped_near(&near);
        assert!((angle.0[5] - TAU).abs() < 1e-12);
    }
}
