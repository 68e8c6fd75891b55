//! A smooth path of the joints through waypoints, and a bound of its distance from straight lines
//! between them.
//!
//! Each joint follows the monotone cubic through its waypoints (Fritsch and Carlson, *Monotone
//! Piecewise Cubic Interpolation*, 1980, with harmonic means as slopes). Its parameter counts
//! waypoints. Between two waypoints no angle leaves the range between their angles, so what is
//! known of both ends bounds everything between.

use crate::joints::{JOINTS, JointAngles};

/// Maximum difference of a cubic Hermite curve from its chord, per unit of slope error at one end.
const HERMITE_SHARE: f64 = 4.0 / 27.0;

/// A path of the joints with continuous speed.
#[derive(Debug, Clone, PartialEq)]
pub struct JointPath {
    waypoints: Vec<JointAngles>,
    /// Change of each angle per waypoint, in radians.
    slopes: Vec<[f64; JOINTS]>,
}

impl JointPath {
    /// Makes the path through waypoints.
    pub fn new(waypoints: Vec<JointAngles>) -> Self {
        let at = 0..waypoints.len();
        let slopes = at.map(|at| slopes(&waypoints, at)).collect();
        Self { waypoints, slopes }
    }

    /// Reverses the path.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self::new(self.waypoints.iter().rev().copied().collect())
    }

    /// Gives the waypoints.
    pub fn waypoints(&self) -> &[JointAngles] {
        &self.waypoints
    }

    /// Counts the stretches between two waypoints.
    pub fn stretches(&self) -> usize {
        self.waypoints.len().saturating_sub(1)
    }

    /// Gives the cubics of a stretch, one per joint; `None` beyond the last.
    pub(crate) fn stretch(&self, at: usize) -> Option<[Cubic; JOINTS]> {
        let from = self.waypoints.get(at)?.as_array();
        let to = self.waypoints.get(at + 1)?.as_array();
        let (slopes_from, slopes_to) = (self.slopes.get(at)?, self.slopes.get(at + 1)?);
        let ends = from.iter().zip(to).zip(slopes_from.iter().zip(slopes_to));
        let mut cubics = [Cubic::default(); JOINTS];
        for (cubic, ((from, to), (slope_from, slope_to))) in cubics.iter_mut().zip(ends) {
            *cubic = Cubic {
                from: *from,
                to: *to,
                slope_from: *slope_from,
                slope_to: *slope_to,
            };
        }
        Some(cubics)
    }

    /// Gives the joints at a parameter, which is cut to the path.
    pub fn at(&self, parameter: f64) -> Option<JointAngles> {
        let parameter = parameter.clamp(0.0, self.stretches() as f64);
        let at = (parameter.floor() as usize).min(self.stretches().checked_sub(1)?);
        let share = parameter - at as f64;
        let cubics = self.stretch(at)?;
        Some(JointAngles::new(cubics.map(|cubic| cubic.value(share))))
    }

    /// Bounds how far, between two waypoints, any point of the arm is from where it would be if it
    /// moved straight from the one to the other, in metres.
    ///
    /// `reaches_m` bounds each joint's distance to what it moves. Two parts: a chord in joint space
    /// is not straight for a point of the arm; its second derivative is at most `(sum |d|) (sum |d|
    /// R)`, and a curve differs from its chord by an eighth of that. And the joints do not advance
    /// evenly: each differs from the one that moves the arm most by what the cubics' slopes differ.
    pub fn deviation_m(&self, at: usize, reaches_m: &[f64; JOINTS]) -> f64 {
        let Some(cubics) = self.stretch(at) else {
            return 0.0;
        };
        let (mut turn, mut sweep_m, mut leading_m, mut leader) = (0.0, 0.0, 0.0, (1.0, 1.0));
        for (cubic, reach_m) in cubics.iter().zip(reaches_m) {
            let change = (cubic.to - cubic.from).abs();
            turn += change;
            sweep_m += change * reach_m;
            if change * reach_m > leading_m {
                leading_m = change * reach_m;
                leader = cubic.relative_slopes();
            }
        }
        let uneven_m = cubics.iter().zip(reaches_m).map(|(cubic, reach_m)| {
            let slopes = cubic.relative_slopes();
            let differ = (slopes.0 - leader.0).abs() + (slopes.1 - leader.1).abs();
            (cubic.to - cubic.from).abs() * reach_m * HERMITE_SHARE * differ
        });
        turn * sweep_m / 8.0 + uneven_m.sum::<f64>()
    }
}

/// A cubic over `[0, 1]` given by its ends.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Cubic {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) slope_from: f64,
    pub(crate) slope_to: f64,
}

impl Cubic {
    /// Gives the angle at a share of the stretch.
    pub(crate) fn value(&self, share: f64) -> f64 {
        let rest = 1.0 - share;
        let ends = self.from * (1.0 + 2.0 * share) * rest * rest
            + self.to * (3.0 - 2.0 * share) * share * share;
        ends + self.slope_from * share * rest * rest - self.slope_to * share * share * rest
    }

    /// Gives the greatest speed over the stretch: of the parabola that the derivative is, at an end
    /// or its vertex.
    pub(crate) fn greatest_slope(&self) -> f64 {
        let (low, high) = self.curvatures();
        let mut greatest = self.slope_from.abs().max(self.slope_to.abs());
        let share = low / (low - high);
        if share.is_finite() && (0.0..=1.0).contains(&share) {
            let at_vertex = self.slope_from + 0.5 * low * share;
            greatest = greatest.max(at_vertex.abs());
        }
        greatest
    }

    /// Gives the second derivative at both ends, between which it is linear.
    pub(crate) fn curvatures(&self) -> (f64, f64) {
        let chord = self.to - self.from;
        (
            6.0 * chord - 4.0 * self.slope_from - 2.0 * self.slope_to,
            2.0 * self.slope_from + 4.0 * self.slope_to - 6.0 * chord,
        )
    }

    /// Gives the slopes at both ends over the chord's; 1 for a joint that stands still.
    fn relative_slopes(&self) -> (f64, f64) {
        let chord = self.to - self.from;
        if chord == 0.0 {
            return (1.0, 1.0);
        }
        (self.slope_from / chord, self.slope_to / chord)
    }
}

fn slopes(waypoints: &[JointAngles], at: usize) -> [f64; JOINTS] {
    let angles = |index: usize| waypoints.get(index).map(JointAngles::as_array);
    let previous = at.checked_sub(1).and_then(angles);
    let (here, next) = (angles(at), angles(at + 1));
    let mut slopes = [0.0; JOINTS];
    for (joint, slope) in slopes.iter_mut().enumerate() {
        let angle = |angles: Option<&[f64; JOINTS]>| angles.and_then(|all| all.get(joint)).copied();
        let before = angle(here).zip(angle(previous)).map(|(to, from)| to - from);
        let after = angle(next).zip(angle(here)).map(|(to, from)| to - from);
        *slope = match (before, after) {
            (Some(before), Some(after)) if before * after > 0.0 => {
                2.0 * before * after / (before + after)
            }
            (Some(_), Some(_)) | (None, None) => 0.0,
            (Some(only), None) | (None, Some(only)) => only,
        };
    }
    slopes
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn no_angle_leaves_the_range_between_two_waypoints(
            angles in prop::collection::vec(prop::array::uniform6(-3.0..3.0_f64), 2..8),
        ) {
            let path = JointPath::new(angles.iter().copied().map(JointAngles::new).collect());
            for (at, pair) in angles.windows(2).enumerate() {
                for step in 0..=20 {
                    let joints = path.at(at as f64 + f64::from(step) / 20.0).unwrap();
                    for (joint, angle) in joints.as_array().iter().enumerate() {
                        let (low, high) = (pair[0][joint].min(pair[1][joint]), pair[0][joint].max(pair[1][joint]));
                        prop_assert!((low - 1e-9..=high + 1e-9).contains(angle));
                    }
                }
            }
        }

        #[test]
        fn slopes_and_curvatures_bound_those_of_the_cubic(
            (from, to) in (-1.0..1.0_f64, -1.0..1.0_f64),
            (slope_from, slope_to) in (-3.0..3.0_f64, -3.0..3.0_f64),
        ) {
            let cubic = Cubic { from, to, slope_from, slope_to };
            let (low, high) = cubic.curvatures();
            let h = 1e-3;
            for step in 1..999 {
                let at = f64::from(step) * h;
                let (before, here, after) = (cubic.value(at - h), cubic.value(at), cubic.value(at + h));
                prop_assert!((after - before).abs() / (2.0 * h) <= cubic.greatest_slope() + 1e-4);
                let curvature = (after - 2.0 * here + before) / (h * h);
                prop_assert!(curvature.abs() <= low.abs().max(high.abs()) + 1e-4);
            }
        }
    }
}
