//! Pattern search over poses.

use std::cell::LazyCell;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::object::LibraryObject;

/// A move of a pose by a step, to both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Move {
    /// A shift along x.
    X,
    /// A shift along y.
    Y,
    /// A shift along z.
    Z,
    /// A turn about the vertical through the object's centre, such that the object's border moves
    /// by the step.
    Turn,
}

/// Moves that a search tries. The order matters: each starts from the best pose so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pattern {
    /// The first step, in metres.
    pub(crate) first_step_m: f64,
    /// The moves in their order.
    pub(crate) moves: [Move; 3],
    /// Number of times that all moves are tried with each step.
    pub(crate) sweeps: usize,
}

/// Number of steps that are tried, each half as long as the one before.
const STEPS: i32 = 3;

/// Minimum distance of an object's border from its centre, in metres.
const LEAST_ARM_M: f64 = 0.003;

impl Pattern {
    /// Finds the pose near another at which a cost is least, with that cost; it starts from a pose
    /// with its cost.
    ///
    /// Each move that lowers the cost is kept at once, and the step is halved whether or not one
    /// did (Hooke and Jeeves 1961, without their extrapolation).
    pub(crate) fn least(
        &self,
        object: &LibraryObject,
        start: (f64, Isometry3<f64>),
        mut cost: impl FnMut(&Isometry3<f64>) -> f64,
    ) -> (f64, Isometry3<f64>) {
        let (mut least, mut best) = start;
        let arm_m = LazyCell::new(|| arm_m(object, &start.1));
        for halvings in 0..STEPS {
            let step_m = self.first_step_m / f64::from(1 << halvings);
            for _ in 0..self.sweeps {
                let sides = |step| [(step, step_m), (step, -step_m)];
                for (step, by_m) in self.moves.into_iter().flat_map(sides) {
                    let moved = match step {
                        Move::X => Translation3::new(by_m, 0.0, 0.0) * best,
                        Move::Y => Translation3::new(0.0, by_m, 0.0) * best,
                        Move::Z => Translation3::new(0.0, 0.0, by_m) * best,
                        Move::Turn => turned(object, &best, by_m / *arm_m),
                    };
                    let cost = cost(&moved);
                    if cost < least {
                        (least, best) = (cost, moved);
                    }
                }
            }
        }
        (least, best)
    }
}

/// Gives the reach of a posed object from its centre, seen from above, in metres.
fn arm_m(object: &LibraryObject, pose: &Isometry3<f64>) -> f64 {
    let centre = pose * object.centre_m;
    let points = object.points.iter();
    let arms_m = points.map(|point| (pose * point.point - centre).xy().norm());
    arms_m.fold(LEAST_ARM_M, f64::max)
}

/// Turns a pose about the vertical through the object's centre.
fn turned(object: &LibraryObject, pose: &Isometry3<f64>, yaw_rad: f64) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    Isometry3::rotation_wrt_point(turn, pose * object.centre_m) * pose
}
