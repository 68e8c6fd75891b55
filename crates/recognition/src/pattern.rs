//! Pattern search over poses.

use std::cell::LazyCell;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::object::LibraryObject;

/// How a pose is moved by a step, to both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Move {
    /// Shifted along x.
    X,
    /// Shifted along y.
    Y,
    /// Shifted along z.
    Z,
    /// Turned about the vertical through the object's centre, such that the object's border moves by the step.
    Turn,
}

/// What a search tries. The order matters: each move starts from the best pose so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pattern {
    /// The first step, in metres.
    pub(crate) first_step_m: f64,
    /// The moves in their order.
    pub(crate) moves: [Move; 3],
    /// How often all moves are tried with each step.
    pub(crate) sweeps: usize,
}

/// How many steps are tried, each half as long as the one before.
const STEPS: i32 = 3;

/// An object's border is taken to be at least this far from its centre, in metres.
const LEAST_ARM_M: f64 = 0.003;

impl Pattern {
    /// The pose near another at which a cost is least, with that cost; it starts from a pose with its cost.
    ///
    /// Each move that lowers the cost is kept at once, and the step is halved whether or not one did (Hooke and Jeeves
    /// 1961, without their extrapolation).
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

/// How far a posed object reaches from its centre, seen from above, in metres.
fn arm_m(object: &LibraryObject, pose: &Isometry3<f64>) -> f64 {
    let centre = pose * object.centre_m;
    let points = object.points.iter();
    let arms_m = points.map(|point| (pose * point.point - centre).xy().norm());
    arms_m.fold(LEAST_ARM_M, f64::max)
}

/// A pose turned about the vertical through the object's centre.
fn turned(object: &LibraryObject, pose: &Isometry3<f64>, yaw_rad: f64) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    Isometry3::rotation_wrt_point(turn, pose * object.centre_m) * pose
}
