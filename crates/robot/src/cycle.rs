//! A whole cycle: pick an item, carry it over, place it, and come back; with the time it takes.
//!
//! Between the pick and the place the cup moves at one height that clears the rim and the content,
//! on an arc around the arm's base, still facing down. The way back is the way there.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector2, Vector3};
use ppnpack_numbers::{SettingError, settings, within};
use ppnpack_packing::checks::motion::{Cycle, JointPoint, Leg, LegKind, MAX_POINTS};
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::ranking::candidate::Lying;

use crate::clearance::{Held, Sweep, deviations_m, extruded};
use crate::gripper::GripperPart;
use crate::joints::{Joint, JointAngles, wrapped};
use crate::motion::{PlacePlanner, Placing, Target, grasp_yaws_rad, line, steps_along, straight};
use crate::parameters::{point, turn};
use crate::path::JointPath;
use crate::pick::PickPoint;
use crate::refusal::{Body, Refusal};
use crate::surroundings::{Surroundings, keep_apart};
use crate::track::{first_possible, range};
use crate::trajectory::Trajectory;

/// Rounding of what touches, in metres.
const TOUCHING_M: f64 = 1e-6;

settings! {
    /// Settings that a cycle's time depends on beside the arm.
    #[derive(Copy)]
    pub struct CycleSettings with validate {
        /// Time in which the cup gets hold of an item, in seconds.
        pub grip_s: f64 = 0.2 => within("0 to 60 s", 0.0..=60.0),
        /// Time in which the cup lets go, in seconds.
        pub release_s: f64 = 0.15 => within("0 to 60 s", 0.0..=60.0),
        /// Share of the joints' speeds that is used.
        pub speed_share: f64 = 1.0 => within("0.001 to 1", 0.001..=1.0),
        /// Share of the joints' accelerations that is used.
        pub acceleration_share: f64 = 1.0 => within("0.001 to 1", 0.001..=1.0),
    }
}

settings! {
    /// Place to which a cell brings its items to be picked, one after another.
    ///
    /// On the table, 35 cm beside the container.
    #[derive(Copy)]
    pub struct PickPlace {
        /// The point that the cup's middle comes down on, in the container frame, in metres; its
        /// height is that of what items lie on.
        pub position_m: [f64; 3] = [0.10, -0.35, -0.01],
        /// Turn of items there about the vertical, seen from the yaw 0 of their placements, in
        /// degrees.
        pub yaw_deg: f64 = 0.0,
    }
}

impl PickPlace {
    /// Checks every value.
    ///
    /// # Errors
    /// [`SettingError`] names the first field that is not possible.
    pub fn validate(&self) -> Result<(), SettingError> {
        point("pick.position_m", &self.position_m)?;
        turn("pick.yaw_deg", self.yaw_deg)
    }

    /// Gives the pose there of an item that is held at a pick point: its frame in the container
    /// frame. `None` for an item without a yaw.
    pub fn pose(&self, item: &Item, pick: &PickPoint) -> Option<Isometry3<f64>> {
        let view = item.views().first()?;
        let [x_m, y_m, z_m] = self.position_m;
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.yaw_deg.to_radians());
        let held = turn * pick.in_item.coords;
        let origin_m = z_m + view.origin_from_corner_m().z;
        let at = Translation3::new(x_m - held.x, y_m - held.y, origin_m);
        Some(Isometry3::from_parts(at, turn))
    }
}

/// A cycle that the arm can make.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedCycle {
    /// The motions, in order.
    pub legs: Vec<(LegKind, Trajectory)>,
    /// The pose of the item when it is picked.
    pub container_from_item_at_pick: Isometry3<f64>,
    /// The flange's turn about the vertical seen from the item's.
    pub grasp_yaw_rad: f64,
    /// The time in which the cup gets hold of the item, after [`LegKind::Descend`], in seconds.
    pub grip_s: f64,
    /// The time in which the cup lets go, after [`LegKind::Insert`], in seconds.
    pub release_s: f64,
    /// The time from the start of the descent to the return above the pick, gripping and letting go
    /// included, in seconds.
    pub cycle_s: f64,
}

/// The distance of the points at which a cycle is sampled, in seconds. Long legs have
/// [`MAX_POINTS`] at most.
const PERIOD_S: f64 = 0.01;

/// Minimum distance of two points, in seconds: nothing moves far within it.
const LEAST_S: f64 = 1e-6;

impl PlannedCycle {
    /// Gives the cycle as it is carried out: joint angles over time, and the pose of the item's own
    /// frame when it is picked.
    pub fn sampled(&self, arm: &str, lying: &Lying) -> Cycle {
        let legs = self.legs.iter();
        let legs = legs.map(|(kind, trajectory)| (*kind, points(trajectory)));
        let legs = legs.map(|(kind, points)| Leg { kind, points });
        Cycle {
            arm: arm.to_owned(),
            cycle_s: self.cycle_s,
            container_from_item_at_pick: lying.own_frame(&self.container_from_item_at_pick),
            grasp_yaw_rad: self.grasp_yaw_rad,
            grip_s: self.grip_s,
            release_s: self.release_s,
            legs: legs.collect(),
        }
    }
}

/// Samples a trajectory, its end among the points.
fn points(trajectory: &Trajectory) -> Vec<JointPoint> {
    let end_s = trajectory.duration_s();
    let longest = (MAX_POINTS - 1) as f64;
    let period_s = PERIOD_S.max(end_s / (longest - 1.0));
    let mut points: Vec<JointPoint> = Vec::new();
    for (time_s, joints) in trajectory.samples(period_s) {
        let position_rad = *joints.as_array();
        match points.last_mut() {
            // The end may come a hair after the point before it: it takes that one's place.
            Some(before) if time_s < before.time_s + LEAST_S => before.position_rad = position_rad,
            _ => points.push(JointPoint {
                time_s,
                position_rad,
            }),
        }
    }
    points
}

/// Places of the cup's lip over lift, transfer and insert, with those at which the legs meet.
struct Route {
    lips: Vec<Point3<f64>>,
    lifted: usize,
    carried: usize,
}

impl AsRef<[Point3<f64>]> for Route {
    fn as_ref(&self) -> &[Point3<f64>] {
        &self.lips
    }
}

impl Route {
    /// Gives the waypoints of lift, transfer and insert.
    fn legs(&self) -> [RangeInclusive<usize>; 3] {
        let (lifted, carried) = (self.lifted, self.carried);
        [0..=lifted, lifted..=carried, carried..=self.lips.len() - 1]
    }

    /// Gives the share of the transfer's turn at a waypoint, from 0 to 1.
    fn turned(&self, at: usize) -> f64 {
        let steps = (self.carried - self.lifted).max(1);
        (at.saturating_sub(self.lifted) as f64 / steps as f64).min(1.0)
    }
}

/// The joint paths of a cycle's way there.
struct Carry {
    lift: JointPath,
    transfer: JointPath,
    insert: JointPath,
    grasp_yaw_rad: f64,
}

impl PlacePlanner {
    /// Plans a cycle that picks an item and places it, if there is one. At the pick the item lies
    /// as it will be placed, but for its yaw.
    ///
    /// # Errors
    /// [`Refusal`]: of several ways to move, why the one that came furthest is not possible.
    pub fn plan_cycle(
        &mut self,
        placing: &Placing<'_>,
        container_from_item_at_pick: &Isometry3<f64>,
        settings: &CycleSettings,
    ) -> Result<PlannedCycle, Refusal> {
        let (target, surroundings) = self.prepare(placing)?;
        let pick = container_from_item_at_pick * placing.pick.in_item;
        let safe_m = self.safe_height_m(&target, &pick, placing.grid.container().z_m);
        let top = Point3::new(target.release.x, target.release.y, safe_m);
        self.check_swept(&surroundings, &target, &top)?;
        self.check_lifted(&surroundings, &target, &pick, safe_m)?;
        let (_, _, pick_yaw_rad) = container_from_item_at_pick.rotation.euler_angles();
        let route = |step_m| self.route(&target, &pick, safe_m, step_m);
        let carry = first_possible(&self.arm, &self.cell, route, |branch, route| {
            let carry = self.turned_over(&branch, route, pick_yaw_rad, target.item_yaw_rad)?;
            self.check_carry(&surroundings, &target, route, &carry)?;
            Ok(carry)
        })?;
        Ok(self.timed(carry, *container_from_item_at_pick, settings))
    }

    /// Gives the lip's height at which the item clears rim, content and what it lay on.
    fn safe_height_m(&self, target: &Target, pick: &Point3<f64>, rim_m: f64) -> f64 {
        let hangs_m = target.release.z - target.item_box.lowest.z;
        let content_m = self.content.highest_m().max(target.item_box.lowest.z);
        (rim_m.max(content_m) + hangs_m).max(pick.z) + self.cell.approach_clearance_m
    }

    /// Routes the lip straight up, on an arc around the base, and straight down.
    fn route(&self, target: &Target, pick: &Point3<f64>, safe_m: f64, step_m: f64) -> Route {
        let above = |at: &Point3<f64>| Point3::new(at.x, at.y, safe_m);
        let mut lips = line(step_m, pick, &above(pick));
        let lifted = lips.len() - 1;
        let base = self.arm.container_from_base.translation.vector.xy();
        let (from, to) = (pick.xy().coords - base, target.release.xy().coords - base);
        let turn_rad = wrapped(to.y.atan2(to.x) - from.y.atan2(from.x));
        let (near_m, far_m) = (from.norm(), to.norm());
        let arc_m = (far_m - near_m).hypot(turn_rad * near_m.max(far_m));
        let steps = steps_along(arc_m, step_m);
        lips.extend((1..=steps).map(|step| {
            let share = step as f64 / steps as f64;
            let angle = from.y.atan2(from.x) + share * turn_rad;
            let radius = near_m + share * (far_m - near_m);
            let at = base + Vector2::new(angle.cos(), angle.sin()) * radius;
            Point3::new(at.x, at.y, safe_m)
        }));
        let carried = lips.len() - 1;
        let down = line(step_m, &above(&target.release), &target.release);
        lips.extend(down.into_iter().skip(1));
        Route {
            lips,
            lifted,
            carried,
        }
    }

    /// Checks the space that the gripper and the item sweep as they are lifted; the item touches
    /// what it lies on.
    fn check_lifted(
        &self,
        surroundings: &Surroundings,
        target: &Target,
        pick: &Point3<f64>,
        top_m: f64,
    ) -> Result<(), Refusal> {
        let apart_m = self.cell.clearance_m + self.cell.path_tolerance_m;
        let raise_m = apart_m + TOUCHING_M;
        let mut item = target.held().around_axis().moved(&pick.coords);
        item.highest_m = item.highest_m.max(item.lowest_m + raise_m) + (top_m - pick.z);
        item.lowest_m += raise_m;
        let parts = extruded(&self.arm, pick, top_m).map(|(part, mut shape)| {
            if part == GripperPart::Cup {
                shape.lowest_m += raise_m;
            }
            (Body::Gripper(part), shape)
        });
        let swept = parts.into_iter().chain([(Body::HeldItem, item)]);
        for (body, shape) in swept {
            let nearest = surroundings.nearest_to_cylinder(&self.content, &shape);
            keep_apart(body, nearest, apart_m)?;
        }
        Ok(())
    }

    /// Turns J6 along a branch for the item's yaws at both ends: of the yaws at which it may be
    /// picked and the ways round, by the one that turns J6 least.
    fn turned_over(
        &self,
        branch: &[JointAngles],
        route: &Route,
        pick_yaw_rad: f64,
        place_yaw_rad: f64,
    ) -> Result<Carry, Refusal> {
        let [.., limits] = self.arm.limits();
        let short_rad = wrapped(place_yaw_rad - pick_yaw_rad);
        let grasps = grasp_yaws_rad(&self.cell);
        let ways = grasps.flat_map(|yaw| [-TAU, 0.0, TAU].map(|round| (yaw, short_rad + round)));
        let mut least: Option<(f64, Vec<JointAngles>, f64)> = None;
        for (grasp_yaw_rad, over_rad) in ways {
            let start_rad = self.arm.flange_turn_rad(pick_yaw_rad + grasp_yaw_rad);
            let over_rad = self.arm.flange_turn_rad(over_rad);
            let turned = branch.iter().enumerate().map(|(at, joints)| {
                joints.with_flange_turned(start_rad + over_rad * route.turned(at))
            });
            let turned: Vec<_> = turned.collect();
            let (low, high) = range(&turned, Joint::J6 as usize);
            let Some(whole_rad) = limits.turns_into((low, high), 0.0) else {
                continue;
            };
            let most_rad = (low + whole_rad).abs().max((high + whole_rad).abs());
            let cost = (high - low) + 0.01 * most_rad;
            if least.as_ref().is_none_or(|least| cost < least.0) {
                let turned = turned.iter();
                let turned = turned.map(|joints| joints.with_flange_turned(whole_rad));
                least = Some((cost, turned.collect(), grasp_yaw_rad));
            }
        }
        let (_, turned, grasp_yaw_rad) = least.ok_or(Refusal::JointLimit { joint: Joint::J6 })?;
        let legs = route
            .legs()
            .map(|range| turned.get(range).unwrap_or_default().to_vec());
        let [lift, transfer, insert] = legs.map(JointPath::new);
        Ok(Carry {
            lift,
            transfer,
            insert,
            grasp_yaw_rad,
        })
    }

    fn check_carry(
        &self,
        surroundings: &Surroundings,
        target: &Target,
        route: &Route,
        carry: &Carry,
    ) -> Result<(), Refusal> {
        let [lift, transfer, insert] = route.legs();
        let legs = [
            (&carry.lift, lift, true),
            (&carry.transfer, transfer, false),
        ];
        for (path, range, is_line) in legs {
            let deviations_m = deviations_m(&self.arm, path, target.beyond_m());
            let sweep = Sweep {
                arm: &self.arm,
                lips: route.lips.get(range).unwrap_or(&[]),
                surroundings,
                columns: &self.content,
                held: Some(Held::Cylinder(target.held().around_axis())),
                clearance_m: self.cell.clearance_m,
            };
            if is_line {
                straight(&deviations_m, self.cell.path_tolerance_m)?;
            } else {
                sweep.gripper(&deviations_m)?;
            }
            sweep.links(path, &deviations_m)?;
        }
        let lips = route.lips.get(insert).unwrap_or(&[]);
        self.check_links(surroundings, target, lips, &carry.insert)
    }

    /// Times the legs there and back.
    fn timed(
        &self,
        carry: Carry,
        container_from_item_at_pick: Isometry3<f64>,
        settings: &CycleSettings,
    ) -> PlannedCycle {
        let mut limits = *self.arm.limits();
        for limit in &mut limits {
            limit.speed_rad_per_s *= settings.speed_share;
            limit.acceleration_rad_per_s2 *= settings.acceleration_share;
        }
        let back = [&carry.lift, &carry.insert, &carry.transfer].map(JointPath::reversed);
        let [descend, retreat, back] = back;
        let legs = [
            (LegKind::Descend, descend),
            (LegKind::Lift, carry.lift),
            (LegKind::Transfer, carry.transfer),
            (LegKind::Insert, carry.insert),
            (LegKind::Retreat, retreat),
            (LegKind::Return, back),
        ];
        let legs = legs.map(|(leg, path)| (leg, Trajectory::new(path, &limits)));
        let moving_s: f64 = legs.iter().map(|(_, leg)| leg.duration_s()).sum();
        PlannedCycle {
            legs: legs.into(),
            container_from_item_at_pick,
            grasp_yaw_rad: carry.grasp_yaw_rad,
            grip_s: settings.grip_s,
            release_s: settings.release_s,
            cycle_s: moving_s + settings.grip_s + settings.release_s,
        }
    }
}
