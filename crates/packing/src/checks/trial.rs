//! Placements tried in a simulation before they are made: what is asked of a try, and what it says.

use std::f64::consts::FRAC_PI_2;

use ppnpack_numbers::{SettingError, settings, within};
use serde::{Deserialize, Serialize};

/// Tolerance above the rim, in metres: bodies of a simulation are not quite where they touch.
pub const RIM_TOLERANCE_M: f64 = 0.001;

settings! {
    /// Settings of tries. The check itself is the simulation's
    /// ([`Cost::Simulation`](crate::checks::check::Cost)).
    #[derive(Copy)]
    pub struct TrialSettings {
        /// Limits that a tried placement has to keep.
        pub limits: TrialLimits = TrialLimits::default(),
        /// Tries of an item in a step, after which it is left out. With 0 nothing is tried.
        pub tries_per_item: usize = 40,
        /// How far a placement must be from one of the same item and yaw that was refused in the
        /// step, to be tried too, in metres: nearer ones are refused unasked.
        pub neighbour_m: f64 = 0.005,
        /// How far above the rim an item may reach as it is placed, in metres: many sink by some
        /// millimetres as they come to rest. One that sticks out when it has been tried is refused.
        pub above_rim_m: f64 = 0.02,
    }
}

settings! {
    /// Limits that a tried placement has to keep. The defaults are a little less than what counts
    /// as steady once an item is placed: 30 degrees and 2 cm.
    #[derive(Copy)]
    pub struct TrialLimits {
        /// The most that the item may tilt, in radians.
        pub tilt_rad: f64 = 25.0_f64.to_radians(),
        /// Maximum tilt of an item that rolls on a floor, in radians: it seldom stops where a try
        /// says. A step in which nothing else can be placed allows it as much as any other.
        pub rolling_tilt_rad: f64 = 18.0_f64.to_radians(),
        /// The most that its centre of mass may move sideways, in metres.
        pub slide_m: f64 = 0.018,
        /// The most that any other item may move, in metres.
        pub disturbance_m: f64 = 0.02,
    }
}

impl TrialLimits {
    /// Tightens them to those of an item that rolls.
    #[must_use]
    pub fn of_rolling(&self) -> Self {
        Self {
            tilt_rad: self.tilt_rad.min(self.rolling_tilt_rad),
            ..*self
        }
    }
}

impl TrialSettings {
    /// Nothing is tried.
    pub fn off() -> Self {
        Self {
            tries_per_item: 0,
            ..Self::default()
        }
    }

    /// Whether placements are tried at all.
    pub fn is_on(&self) -> bool {
        self.tries_per_item > 0
    }

    /// Checks that every number is possible.
    pub fn validate(&self) -> Result<(), SettingError> {
        let tries = within("between 0 and 10000", 0.0..=1e4);
        tries("the trial's tries per item", self.tries_per_item as f64)?;
        let tilt = within("between 0 and a right angle", 0.0..=FRAC_PI_2);
        tilt("the trial's tilt limit, in radians,", self.limits.tilt_rad)?;
        let rolling = "the trial's tilt limit of what rolls, in radians,";
        tilt(rolling, self.limits.rolling_tilt_rad)?;
        let length = within("between 0 and 1 m", 0.0..=1.0);
        length("the trial's slide limit", self.limits.slide_m)?;
        length("the trial's disturbance limit", self.limits.disturbance_m)?;
        length("the distance of the trial's neighbours", self.neighbour_m)?;
        length("the trial's reach above the rim", self.above_rim_m)
    }
}

/// Outcome of a placement that was tried.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settling {
    /// The angle between the item's upward axis as planned and at the end, in radians.
    pub tilt_rad: f64,
    /// Horizontal distance of its centre of mass from where it was planned, in metres.
    pub slide_m: f64,
    /// How far the other item that moved most moved, in metres.
    pub disturbance_m: f64,
    /// How far it, or an item that it has lifted, may stick out above the rim, in metres.
    pub above_rim_m: f64,
    /// Whether the item was at rest at the end.
    pub is_still: bool,
}

impl Settling {
    /// Names the limit that it exceeds, in words; `None` where it is within all.
    pub fn beyond(&self, limits: &TrialLimits) -> Option<&'static str> {
        if self.tilt_rad > limits.tilt_rad {
            Some("it would topple")
        } else if self.slide_m > limits.slide_m {
            Some("it would slide")
        } else if self.disturbance_m > limits.disturbance_m {
            Some("it would move what lies there")
        } else if !self.is_still {
            Some("it would not come to rest")
        } else if self.above_rim_m > RIM_TOLERANCE_M {
            Some("it would stick out above the rim")
        } else {
            None
        }
    }

    /// The worse of two in every respect.
    #[must_use]
    pub fn worse(&self, other: &Self) -> Self {
        Self {
            tilt_rad: self.tilt_rad.max(other.tilt_rad),
            slide_m: self.slide_m.max(other.slide_m),
            disturbance_m: self.disturbance_m.max(other.disturbance_m),
            above_rim_m: self.above_rim_m.max(other.above_rim_m),
            is_still: self.is_still && other.is_still,
        }
    }

    /// How far it goes towards the limits: the greatest share of one, above 1 beyond.
    pub fn severity(&self, limits: &TrialLimits) -> f64 {
        let share = |value: f64, limit: f64| if value > 0.0 { value / limit } else { 0.0 };
        share(self.tilt_rad, limits.tilt_rad)
            .max(share(self.slide_m, limits.slide_m))
            .max(share(self.disturbance_m, limits.disturbance_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: TrialLimits = TrialLimits {
        tilt_rad: 0.4,
        rolling_tilt_rad: 0.1,
        slide_m: 0.02,
        disturbance_m: 0.03,
    };

    fn settling(tilt_rad: f64, slide_m: f64, disturbance_m: f64) -> Settling {
        Settling {
            tilt_rad,
            slide_m,
            disturbance_m,
            above_rim_m: 0.0,
            is_still: true,
        }
    }

    #[test]
    fn what_reaches_its_limits_is_within_them_and_what_exceeds_one_is_not() {
        let next = f64::next_up;
        let (tilt, slide, moved) = (LIMITS.tilt_rad, LIMITS.slide_m, LIMITS.disturbance_m);
        let at = settling(tilt, slide, moved);
        for (settling, beyond) in [
            (at, None),
            (settling(next(tilt), slide, moved), Some("it would topple")),
            (settling(tilt, next(slide), moved), Some("it would slide")),
            (
                settling(tilt, slide, next(moved)),
                Some("it would move what lies there"),
            ),
        ] {
            assert_eq!(settling.beyond(&LIMITS), beyond);
            assert_eq!(settling.severity(&LIMITS) > 1.0, beyond.is_some());
        }
        let is_still = false;
        let moving = Settling { is_still, ..at };
        assert_eq!(moving.beyond(&LIMITS), Some("it would not come to rest"));
        let high = |above_rim_m| Settling { above_rim_m, ..at }.beyond(&LIMITS);
        assert_eq!(high(RIM_TOLERANCE_M), None);
        assert_eq!(high(0.0011), Some("it would stick out above the rim"));
    }

    #[test]
    fn the_severity_is_the_greatest_share_of_a_limit() {
        // Of no slide at all, any is too much, and none is not.
        let rigid = TrialLimits {
            slide_m: 0.0,
            ..LIMITS
        };
        for (settling, limits, expected) in [
            (settling(0.0, 0.0, 0.0), LIMITS, 0.0),
            (settling(0.2, 0.0, 0.0), LIMITS, 0.5),
            (settling(0.2, 0.04, 0.03), LIMITS, 2.0),
            (settling(0.2, 0.0, 0.0), rigid, 0.5),
            (settling(0.2, 1e-9, 0.0), rigid, f64::INFINITY),
        ] {
            assert_eq!(settling.severity(&limits), expected);
        }
    }

    #[test]
    fn the_worse_of_two_is_the_worse_in_every_respect() {
        let above = |settling| Settling {
            is_still: false,
            above_rim_m: 0.002,
            ..settling
        };
        let (one, other) = (settling(0.1, 0.02, 0.0), above(settling(0.05, 0.03, 0.01)));
        let worse = above(settling(0.1, 0.03, 0.01));
        assert_eq!([one.worse(&other), other.worse(&one)], [worse; 2]);
        assert_eq!(one.worse(&one), one);
    }

    #[test]
    fn impossible_settings_are_named() {
        assert!(TrialSettings::default().is_on() && !TrialSettings::off().is_on());
        TrialSettings::default().validate().unwrap();
        TrialSettings::off().validate().unwrap();
        let refused = |change: fn(&mut TrialSettings)| {
            let mut settings = TrialSettings::default();
            change(&mut settings);
            settings.validate().unwrap_err().to_string()
        };
        assert!(refused(|s| s.tries_per_item = 10_001).contains("tries per item"));
        assert!(refused(|s| s.limits.tilt_rad = 1.6).contains("tilt"));
        assert!(refused(|s| s.limits.tilt_rad = f64::NAN).contains("tilt"));
        assert!(refused(|s| s.limits.rolling_tilt_rad = -0.1).contains("rolls"));
        assert!(refused(|s| s.limits.slide_m = -0.001).contains("slide"));
        assert!(refused(|s| s.limits.disturbance_m = f64::INFINITY).contains("disturbance"));
        assert!(refused(|s| s.neighbour_m = 1.5).contains("neighbours"));
        assert!(refused(|s| s.above_rim_m = -0.01).contains("above the rim"));
    }
}
