//! The last fractions of a millimetre: a pose that fits the outline, too.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::expected::{Observation, Sketch};
use crate::library::LibraryObject;
use crate::segmentation::Cluster;

/// The first step at the object's border, in metres; each level halves it.
const FIRST_STEP_M: f64 = 0.0012;

/// How often the step is halved.
const LEVELS: u32 = 3;

/// How often all directions are tried with one step.
const SWEEPS: usize = 1;

/// Points of the cluster that are compared.
const POINTS: usize = 1500;

/// With more points than this, alignment alone is exact enough, and a search would take long.
const MOST_POINTS: usize = 4000;

/// A search for the shift and yaw at which the expected view fits best.
///
/// Alignment pulls a surface to the points but does not push it away from where the camera saw none. On small items that
/// leaves some degrees of yaw; the outline holds them.
pub(crate) struct Polish {
    observation: Observation,
    sketch: Sketch,
}

impl Polish {
    /// Prepares a search; `None` where it would not help.
    pub(crate) fn new(cluster: &Cluster, pixel_m: f64) -> Option<Self> {
        let observation = Observation::new(cluster, 0.5 * pixel_m, POINTS)?;
        (observation.points() <= MOST_POINTS).then(|| Self {
            observation,
            sketch: Sketch::default(),
        })
    }

    /// A pose near another that fits better, by pattern search.
    pub(crate) fn polished(
        &mut self,
        object: &LibraryObject,
        support_from_item: &Isometry3<f64>,
    ) -> Isometry3<f64> {
        let mut best = *support_from_item;
        let mut least = self
            .observation
            .strict_cost(object, &best, &mut self.sketch);
        let centre = best * object.centre_m;
        let arm_m = object
            .points
            .iter()
            .map(|point| (best * point.point - centre).xy().norm())
            .fold(0.003, f64::max);
        for level in 0..LEVELS {
            let step_m = FIRST_STEP_M / f64::from(1 << level);
            for _ in 0..SWEEPS {
                let mut has_moved = false;
                for step in steps(step_m, step_m / arm_m) {
                    let centre = best * object.centre_m;
                    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), step.yaw_rad);
                    let moved = Translation3::new(step.x_m, step.y_m, 0.0)
                        * Isometry3::rotation_wrt_point(turn, centre)
                        * best;
                    let cost = self
                        .observation
                        .strict_cost(object, &moved, &mut self.sketch);
                    if cost < least {
                        (best, least, has_moved) = (moved, cost, true);
                    }
                }
                if !has_moved {
                    break;
                }
            }
        }
        best
    }
}

struct Step {
    x_m: f64,
    y_m: f64,
    yaw_rad: f64,
}

fn steps(length_m: f64, angle_rad: f64) -> [Step; 6] {
    let step = |x_m, y_m, yaw_rad| Step { x_m, y_m, yaw_rad };
    [
        step(0.0, 0.0, angle_rad),
        step(0.0, 0.0, -angle_rad),
        step(length_m, 0.0, 0.0),
        step(-length_m, 0.0, 0.0),
        step(0.0, length_m, 0.0),
        step(0.0, -length_m, 0.0),
    ]
}
