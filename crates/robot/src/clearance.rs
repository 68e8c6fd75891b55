//! Collision check of a path of the arm, between the waypoints too.
//!
//! Adaptive dynamic collision checking (Schwarzer, Saha and Latombe, 2005): where the distances at
//! two waypoints together exceed what a body can travel between them, it touches nothing in
//! between; and a distance at one waypoint that exceeds the travel over several stretches saves
//! looking at the waypoints in between.

use nalgebra::{Isometry3, Point3, Vector3};

use crate::arm::{Arm, LinkCapsule};
use crate::columns::Columns;
use crate::gripper::GripperPart;
use crate::kinematics::LINKS;
use crate::path::JointPath;
use crate::refusal::{Body, Obstacle, Refusal};
use crate::shapes::{AxisBox, Capsule, UprightCylinder};
use crate::surroundings::{FAR_M, Nearest, Surroundings};

/// Minimum distance in the chain of links that are checked against each other: nearer ones overlap
/// at their joints.
const LEAST_LINKS_APART: usize = 3;

/// The link that the gripper is mounted next to; only lower ones are checked against it.
const WRIST: usize = 5;

/// The item that hangs below the cup, seen from the middle of its lip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Held {
    /// An item that keeps its yaw.
    Box(AxisBox),
    /// An item at any yaw.
    Cylinder(UprightCylinder),
}

/// A path of the arm with the place of the cup's lip at each waypoint.
pub(crate) struct Sweep<'a> {
    pub(crate) arm: &'a Arm,
    pub(crate) lips: &'a [Point3<f64>],
    pub(crate) surroundings: &'a Surroundings,
    pub(crate) columns: &'a Columns,
    pub(crate) held: Option<Held>,
    pub(crate) clearance_m: f64,
}

/// Bounds, per stretch, the distance of any point from the straight line between its places at the
/// waypoints, in metres. The held item reaches `beyond_m` from the cup's lip.
pub(crate) fn deviations_m(arm: &Arm, path: &JointPath, beyond_m: f64) -> Vec<f64> {
    let reaches_m = arm.reaches_m().map(|reach_m| reach_m + beyond_m);
    let stretches = 0..path.stretches();
    stretches
        .map(|at| path.deviation_m(at, &reaches_m))
        .collect()
}

/// A link's capsule along a path.
struct MovingLink {
    link: usize,
    /// The capsule at each waypoint.
    shapes: Vec<Capsule>,
    /// A bound of how far its ends move per stretch, in metres, if they move straight.
    moved_m: Vec<f64>,
}

impl MovingLink {
    fn new(capsule: &LinkCapsule, frames: &[[Isometry3<f64>; LINKS]]) -> Self {
        let shapes: Vec<_> = frames.iter().map(|frames| place(capsule, frames)).collect();
        let stretches = shapes.iter().zip(shapes.iter().skip(1));
        let moved_m = stretches.map(|(a, b)| (b.from - a.from).norm().max((b.to - a.to).norm()));
        Self {
            link: capsule.link,
            moved_m: moved_m.collect(),
            shapes,
        }
    }
}

impl Sweep<'_> {
    /// Checks the links against the surroundings, the gripper, the held item and one another.
    pub(crate) fn links(&self, path: &JointPath, deviations_m: &[f64]) -> Result<(), Refusal> {
        let waypoints = path.waypoints().iter();
        let frames = waypoints.map(|joints| self.arm.container_from_links(joints));
        let frames: Vec<_> = frames.collect();
        let capsules = self.arm.capsules().iter();
        let links = capsules.map(|capsule| MovingLink::new(capsule, &frames));
        let links: Vec<_> = links.collect();
        let lips_m = self.lip_travel_m(deviations_m);
        for (index, moving) in links.iter().enumerate() {
            let travel_m = moving.moved_m.iter().zip(deviations_m);
            let travel_m = travel_m.map(|(moved_m, deviation_m)| moved_m + 2.0 * deviation_m);
            let travel_m: Vec<f64> = travel_m.collect();
            let link = moving.link;
            if link > 0 {
                self.keep_clear(Body::Link(link), &travel_m, |at| {
                    let shape = moving.shapes.get(at)?;
                    Some(self.surroundings.nearest_to_link(self.columns, link, shape))
                })?;
            }
            let both_m = travel_m.iter().zip(&lips_m).map(|(a, b)| a + b);
            self.against_gripper(moving, &both_m.collect::<Vec<_>>())?;
            for other in links.iter().skip(index + 1) {
                if other.link.abs_diff(link) < LEAST_LINKS_APART {
                    continue;
                }
                // The nearer link to the base moves the further one along, but by no more than that
                // one moves itself.
                let both_m = travel_m.iter().zip(&other.moved_m).zip(deviations_m);
                let both_m = both_m.map(|((own_m, moved_m), off_m)| own_m + moved_m + 2.0 * off_m);
                let both_m: Vec<f64> = both_m.collect();
                self.keep_clear(Body::Link(link), &both_m, |at| {
                    let (a, b) = (moving.shapes.get(at)?, other.shapes.get(at)?);
                    let itself = Obstacle::Itself(Body::Link(other.link));
                    Some((a.distance_to_capsule_m(b), Some(itself)))
                })?;
            }
        }
        Ok(())
    }

    /// Checks a link against the gripper and the held item, which move with the lip.
    fn against_gripper(&self, moving: &MovingLink, travel_m: &[f64]) -> Result<(), Refusal> {
        let link = moving.link;
        let check = |body: Body, distance_m: &dyn Fn(&Capsule, &Vector3<f64>) -> f64| {
            self.keep_clear(Body::Link(link), travel_m, |at| {
                let (lip, shape) = (self.lips.get(at)?, moving.shapes.get(at)?);
                let distance_m = distance_m(shape, &lip.coords);
                Some((distance_m, Some(Obstacle::Itself(body))))
            })
        };
        if link < WRIST {
            for (part, shape) in self.arm.gripper().parts() {
                check(Body::Gripper(part), &|capsule, lip| {
                    capsule.distance_m(&shape.moved(lip))
                })?;
            }
        }
        match self.held {
            Some(held) if link <= WRIST => check(Body::HeldItem, &|capsule, lip| match held {
                Held::Box(shape) => capsule.distance_m(&shape.moved(lip)),
                Held::Cylinder(shape) => capsule.distance_m(&shape.moved(lip)),
            }),
            _ => Ok(()),
        }
    }

    /// Checks the gripper and the held item against the surroundings.
    pub(crate) fn gripper(&self, deviations_m: &[f64]) -> Result<(), Refusal> {
        let travel_m = self.lip_travel_m(deviations_m);
        let parts = self.arm.gripper().parts().into_iter();
        let parts = parts.map(|(part, shape)| (Body::Gripper(part), shape));
        let held = self.held.map(|held| match held {
            Held::Cylinder(shape) => (Body::HeldItem, shape),
            Held::Box(shape) => (Body::HeldItem, shape.around_axis()),
        });
        for (body, shape) in parts.chain(held) {
            self.keep_clear(body, &travel_m, |at| {
                let placed = shape.moved(&self.lips.get(at)?.coords);
                Some(self.surroundings.nearest_to_cylinder(self.columns, &placed))
            })?;
        }
        Ok(())
    }

    /// Refuses a body that may come nearer to something than the clearance. `nearest` tells what is
    /// nearest to it at a waypoint.
    fn keep_clear(
        &self,
        body: Body,
        travel_m: &[f64],
        nearest: impl Fn(usize) -> Option<Nearest>,
    ) -> Result<(), Refusal> {
        let distance_m = |at| nearest(at).map_or(FAR_M, |(distance_m, _)| distance_m);
        let Some(at) = walk(travel_m, self.clearance_m, distance_m) else {
            return Ok(());
        };
        let obstacle = nearest(at).and_then(|(_, obstacle)| obstacle);
        let obstacle = obstacle.unwrap_or(Obstacle::Content);
        Err(Refusal::Collision { body, obstacle })
    }

    fn lip_travel_m(&self, deviations_m: &[f64]) -> Vec<f64> {
        let stretches = self.lips.iter().zip(self.lips.iter().skip(1));
        let travel_m = stretches.zip(deviations_m);
        let travel_m = travel_m.map(|((a, b), off_m)| (b - a).norm() + 2.0 * off_m);
        travel_m.collect()
    }
}

/// Gives the space that the gripper's parts sweep as the lip moves straight up to `top_m`.
pub(crate) fn extruded(
    arm: &Arm,
    lip: &Point3<f64>,
    top_m: f64,
) -> [(GripperPart, UprightCylinder); 3] {
    arm.gripper().parts().map(|(part, shape)| {
        let mut swept = shape.moved(&lip.coords);
        swept.highest_m += (top_m - lip.z).max(0.0);
        (part, swept)
    })
}

fn place(capsule: &LinkCapsule, frames: &[Isometry3<f64>; LINKS]) -> Capsule {
    let Capsule { from, to, radius_m } = capsule.shape;
    frames
        .get(capsule.link)
        .map_or(capsule.shape, |frame| Capsule {
            from: frame * from,
            to: frame * to,
            radius_m,
        })
}

/// Walks along waypoints to the first at which, or before which, a body may come nearer than
/// `clearance_m`.
///
/// `travel_m` bounds how far the body moves per stretch; `distance_m` is a lower bound of its
/// distance at a waypoint.
fn walk(travel_m: &[f64], clearance_m: f64, distance_m: impl Fn(usize) -> f64) -> Option<usize> {
    let last = travel_m.len();
    let (mut at, mut gap_m) = (0, distance_m(0) - clearance_m);
    if gap_m < 0.0 {
        return Some(0);
    }
    while at < last {
        let mut next = at + 1;
        let mut run_m = travel_m.get(at).copied().unwrap_or(0.0);
        while let Some(further_m) = travel_m.get(next) {
            if run_m + further_m > gap_m {
                break;
            }
            run_m += further_m;
            next += 1;
        }
        let next_gap_m = distance_m(next) - clearance_m;
        if next_gap_m < 0.0 || gap_m + next_gap_m < run_m {
            return Some(next);
        }
        (at, gap_m) = (next, next_gap_m);
    }
    None
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::arms;
    use crate::joints::JointAngles;

    /// The distance from a point to the segment between two others.
    fn beside_m(at: &Point3<f64>, from: &Point3<f64>, to: &Point3<f64>) -> f64 {
        let way = to - from;
        let share = (at - from).dot(&way) / way.norm_squared().max(1e-12);
        (at - (from + way * share.clamp(0.0, 1.0))).norm()
    }

    proptest! {
        /// The lip, what hangs below it and the ends of all capsules stay as near to their chords
        /// as is claimed.
        #[test]
        fn no_point_leaves_its_straight_line_by_more_than_the_bound(
            start in prop::array::uniform6(-1.5..1.5_f64),
            steps in prop::collection::vec(prop::array::uniform6(-0.15..0.15_f64), 2..5),
        ) {
            let mut joints = vec![JointAngles::new(start)];
            for step in &steps {
                let mut angles = *joints[joints.len() - 1].as_array();
                angles.iter_mut().zip(step).for_each(|(angle, step)| *angle += step);
                joints.push(JointAngles::new(angles));
            }
            for name in arms::names() {
                let arm = arms::arm(name).unwrap();
                let path = JointPath::new(joints.clone());
                let beyond_m = 0.2;
                let bounds_m = deviations_m(&arm, &path, beyond_m);
                let length_m = arm.gripper().length_m();
                let points = |joints: &JointAngles| {
                    let frames = arm.container_from_links(joints);
                    let mut points = vec![
                        frames[6] * Point3::new(0.0, 0.0, length_m),
                        frames[6] * Point3::new(0.12, 0.1, length_m + 0.1),
                    ];
                    for capsule in arm.capsules() {
                        let placed = place(capsule, &frames);
                        points.extend([placed.from, placed.to]);
                    }
                    points
                };
                for (at, bound_m) in bounds_m.iter().enumerate() {
                    let (from, to) = (points(&joints[at]), points(&joints[at + 1]));
                    for sample in 1..10 {
                        let here = points(&path.at(at as f64 + f64::from(sample) / 10.0).unwrap());
                        for (here, (from, to)) in here.iter().zip(from.iter().zip(&to)) {
                            let beside_m = beside_m(here, from, to);
                            prop_assert!(beside_m <= bound_m + 1e-9, "{beside_m} {bound_m}");
                        }
                    }
                }
            }
        }

        /// A point moves along a line among obstacles on it; what the walk accepts is clear
        /// everywhere.
        #[test]
        fn what_is_accepted_is_clear_between_waypoints(
            steps in prop::collection::vec(0.0..0.2_f64, 1..20),
            obstacles in prop::collection::vec(-0.5..3.0_f64, 0..4),
            aside in 0.0..0.2_f64,
        ) {
            let mut places = vec![0.0];
            for step in &steps {
                places.push(places[places.len() - 1] + step);
            }
            let gap = |at: f64| {
                let gaps = obstacles.iter().map(|obstacle| (at - obstacle).hypot(aside));
                gaps.fold(1.0, f64::min)
            };
            if walk(&steps, 0.05, |at| gap(places[at])).is_none() {
                for sample in 0..=1000 {
                    let at = places[places.len() - 1] * f64::from(sample) / 1000.0;
                    prop_assert!(gap(at) >= 0.05 - 1e-12);
                }
            } else {
                // With stretches of up to 0.2, half of one decides.
                let nearest = (0..=1000).map(|sample| gap(places[places.len() - 1] * f64::from(sample) / 1000.0));
                prop_assert!(nearest.fold(1.0, f64::min) < 0.05 + 0.11);
            }
        }
    }
}
