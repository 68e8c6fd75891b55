//! Timing of a path of the joints within speed and acceleration limits, from rest to rest.
//!
//! Time-scaling in the phase plane of the path's parameter `u` (after Bobrow, Dubowsky and Gibson,
//! *Time-Optimal Control of Robotic Manipulators Along Specified Paths*, 1985), with joint limits
//! only. Each stretch between waypoints is cut into parts of constant `u''`. With `x = u'^2`, and
//! with bounds `S` and `C` of a joint's first and second derivative by `u` on a stretch, the
//! joint's speed is at most `S sqrt(x)` and its acceleration at most `S |u''| + C x`. A pass
//! forwards and one backwards find the greatest `x` that keep both limits. On straight lines of one
//! joint this is the trapezoidal profile.

use crate::joints::{JOINTS, JointAngles, JointLimits};
use crate::path::JointPath;

/// Parts of constant `u''` per stretch.
const PARTS: usize = 4;

/// Minimum derivative of a joint that moves.
const STILL: f64 = 1e-12;

/// A timed path of the joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    path: JointPath,
    knots: Vec<Knot>,
}

/// An end of a part: its time, and the speed of `u`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Knot {
    time_s: f64,
    rate_per_s: f64,
}

/// Bounds of one joint's first and second derivative on a stretch, with its limits.
#[derive(Debug, Clone, Copy)]
struct Bound {
    slope: f64,
    curvature: f64,
    limits: JointLimits,
}

impl Bound {
    /// Gives the greatest `u'^2` that keeps the speed, and the acceleration at constant `u'`.
    fn cap(&self) -> f64 {
        let by_speed = (self.limits.speed_rad_per_s / self.slope.max(STILL)).powi(2);
        by_speed.min(self.limits.acceleration_rad_per_s2 / self.curvature.max(STILL))
    }

    /// Gives the greatest `u'^2` at one end of a part for that at the other end.
    fn reachable(&self, other: f64) -> f64 {
        let gain = 0.5 * self.slope * PARTS as f64;
        (self.limits.acceleration_rad_per_s2 + gain * other) / (self.curvature + gain).max(STILL)
    }
}

impl Trajectory {
    /// Times a path within limits.
    pub fn new(path: JointPath, limits: &[JointLimits; JOINTS]) -> Self {
        let stretches = 0..path.stretches();
        let bounds: Vec<Vec<Bound>> = stretches.map(|at| bounds(&path, at, limits)).collect();
        let parts = bounds.len() * PARTS;
        let at_part = |part: usize| bounds.get(part / PARTS).map_or(&[][..], Vec::as_slice);
        let least = |part: usize, value: &dyn Fn(&Bound) -> f64| {
            at_part(part).iter().map(value).fold(f64::MAX, f64::min)
        };
        let mut squares = vec![0.0; parts + 1];
        let mut reached = 0.0;
        for (part, square) in squares.iter_mut().skip(1).enumerate() {
            let cap = least(part, &Bound::cap).min(least(part + 1, &Bound::cap));
            reached = least(part, &|bound| bound.reachable(reached)).min(cap);
            *square = reached;
        }
        reached = 0.0;
        for (part, square) in squares.iter_mut().enumerate().rev() {
            if part < parts {
                reached = least(part, &|bound| bound.reachable(reached)).min(*square);
            }
            *square = reached;
        }
        Self {
            knots: knots(&squares),
            path,
        }
    }

    /// Gives its duration, in seconds.
    pub fn duration_s(&self) -> f64 {
        self.knots.last().map_or(0.0, |knot| knot.time_s)
    }

    /// Gives the path that is followed.
    pub fn path(&self) -> &JointPath {
        &self.path
    }

    /// Gives the joints at a time, which is cut to the duration; `None` for a path without a
    /// stretch.
    pub fn at(&self, time_s: f64) -> Option<JointAngles> {
        let time_s = time_s.clamp(0.0, self.duration_s());
        let next = self.knots.partition_point(|knot| knot.time_s <= time_s);
        let next = next.clamp(1, self.knots.len().checked_sub(1)?.max(1));
        let (from, to) = (self.knots.get(next - 1)?, self.knots.get(next)?);
        let (since_s, part_s) = (time_s - from.time_s, to.time_s - from.time_s);
        let change = (to.rate_per_s - from.rate_per_s) / part_s;
        let within = from.rate_per_s * since_s + 0.5 * change * since_s * since_s;
        self.path.at((next - 1) as f64 / PARTS as f64 + within)
    }

    /// Gives the joints every `period_s` seconds, and at the end.
    pub fn samples(&self, period_s: f64) -> impl Iterator<Item = (f64, JointAngles)> + '_ {
        let count = (self.duration_s() / period_s.max(1e-6)).ceil() as usize;
        (0..=count).filter_map(move |step| {
            let time_s = (step as f64 * period_s).min(self.duration_s());
            Some((time_s, self.at(time_s)?))
        })
    }
}

fn bounds(path: &JointPath, at: usize, limits: &[JointLimits; JOINTS]) -> Vec<Bound> {
    let cubics = path.stretch(at).unwrap_or_default();
    let joints = cubics.iter().zip(limits);
    let joints = joints.map(|(cubic, limits)| {
        let (from, to) = cubic.curvatures();
        Bound {
            slope: cubic.greatest_slope(),
            curvature: from.abs().max(to.abs()),
            limits: *limits,
        }
    });
    // A joint that stands still limits nothing.
    let moving = joints.filter(|bound| bound.slope > STILL);
    let bounds: Vec<_> = moving.collect();
    if bounds.is_empty() {
        return vec![STANDING];
    }
    bounds
}

/// Bound of a stretch between waypoints at one place, which is passed in no time that matters.
const STANDING: Bound = Bound {
    slope: STILL,
    curvature: STILL,
    limits: JointLimits {
        lowest_rad: 0.0,
        highest_rad: 0.0,
        speed_rad_per_s: 1e-6,
        acceleration_rad_per_s2: 1e-3,
    },
};

/// Times the ends of parts of constant `u''`.
fn knots(squares: &[f64]) -> Vec<Knot> {
    let mut time_s = 0.0;
    let mut previous: Option<f64> = None;
    let knots = squares.iter().map(|square| {
        let rate_per_s = square.max(0.0).sqrt();
        if let Some(previous) = previous {
            time_s += 2.0 / PARTS as f64 / (previous + rate_per_s).max(STILL);
        }
        previous = Some(rate_per_s);
        Knot { time_s, rate_per_s }
    });
    knots.collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn limits() -> [JointLimits; JOINTS] {
        [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|scale| JointLimits {
            lowest_rad: -10.0,
            highest_rad: 10.0,
            speed_rad_per_s: scale,
            acceleration_rad_per_s2: 4.0 * scale,
        })
    }

    fn straight(change_rad: f64, stretches: usize) -> JointPath {
        let waypoint = |step: usize| {
            let angle = change_rad * step as f64 / stretches as f64;
            JointAngles::new([angle, 0.0, 0.0, 0.0, 0.0, 0.0])
        };
        JointPath::new((0..=stretches).map(waypoint).collect())
    }

    #[test]
    fn a_straight_line_of_one_joint_takes_the_time_of_the_trapezoidal_profile() {
        // 1 rad/s and 4 rad/s^2: 0.25 s to full speed.
        for (change_rad, expected_s) in [(1.0, 1.25), (3.0, 3.25), (0.16, 0.4)] {
            let trajectory = Trajectory::new(straight(change_rad, 64), &limits());
            let found_s = trajectory.duration_s();
            let is_expected = (expected_s - 1e-9..expected_s + 0.03).contains(&found_s);
            assert!(is_expected, "{change_rad}: {found_s}");
        }
    }

    #[test]
    fn a_path_that_stands_still_takes_no_time() {
        let still = JointPath::new(vec![JointAngles::new([1.0; JOINTS]); 3]);
        let duration_s = Trajectory::new(still, &limits()).duration_s();
        assert!(duration_s < 1e-3, "{duration_s}");
        let empty = Trajectory::new(JointPath::new(Vec::new()), &limits());
        assert!(empty.at(0.0).is_none() && empty.duration_s() == 0.0);
    }

    proptest! {
        #[test]
        fn limits_are_kept_and_both_ends_are_at_rest(
            angles in prop::collection::vec(prop::array::uniform6(-1.0..1.0_f64), 2..8),
        ) {
            let limits = limits();
            let path = JointPath::new(angles.iter().copied().map(JointAngles::new).collect());
            let trajectory = Trajectory::new(path, &limits);
            let end_s = trajectory.duration_s();
            prop_assert_eq!(trajectory.at(0.0).unwrap(), JointAngles::new(angles[0]));
            let last = trajectory.at(end_s).unwrap();
            let h = 1e-4;
            for (joint, limit) in limits.iter().enumerate() {
                prop_assert!((last.as_array()[joint] - angles[angles.len() - 1][joint]).abs() < 1e-9);
                let angle = |time_s: f64| trajectory.at(time_s).unwrap().as_array()[joint];
                let slack = limit.acceleration_rad_per_s2 * h;
                prop_assert!((angle(h) - angle(0.0)).abs() <= slack * h + 1e-12);
                prop_assert!((angle(end_s) - angle(end_s - h)).abs() <= slack * h + 1e-12);
                for step in 1..500 {
                    let at = end_s * f64::from(step) / 500.0;
                    if at < h || at > end_s - h {
                        continue;
                    }
                    let (before, here, after) = (angle(at - h), angle(at), angle(at + h));
                    let speed = (after - before).abs() / (2.0 * h);
                    prop_assert!(speed <= limit.speed_rad_per_s * (1.0 + 1e-6));
                    let acceleration = (after - 2.0 * here + before).abs() / (h * h);
                    prop_assert!(acceleration <= limit.acceleration_rad_per_s2 * (1.0 + 1e-3));
                }
            }
        }
    }
}
