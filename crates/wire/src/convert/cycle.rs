//! Cycles: an arm's motions that carry out a decision.

use std::f64::consts::TAU;

use ppnpack_packing::checks::motion::{Cycle, JOINTS, JointPoint, Leg, LegKind, MAX_POINTS};

use super::{pairs, pose};
use crate::error::{WireError, needed};
use crate::limits::{checked, count, name};
use crate::v1::{self, ArmLegKind};

const MAX_LEGS: usize = 16;

const MAX_CYCLE_S: f64 = 86_400.0;

/// Maximum wait for the cup, in seconds.
const MAX_WAIT_S: f64 = 60.0;

/// Maximum angle in either direction, in radians.
const MAX_ANGLE_RAD: f64 = 2.0 * TAU;

const KINDS: [(ArmLegKind, LegKind); 6] = [
    (ArmLegKind::Descend, LegKind::Descend),
    (ArmLegKind::Lift, LegKind::Lift),
    (ArmLegKind::Transfer, LegKind::Transfer),
    (ArmLegKind::Insert, LegKind::Insert),
    (ArmLegKind::Retreat, LegKind::Retreat),
    (ArmLegKind::Return, LegKind::Return),
];

/// Reads a cycle.
///
/// # Errors
/// [`WireError`] where something is missing, or a number is not possible.
pub fn read(message: &v1::ArmCycle) -> Result<Cycle, WireError> {
    count("cycle.legs", message.legs.len(), 1..=MAX_LEGS)?;
    let field = "cycle.container_from_item_at_pick";
    let at_pick = message.container_from_item_at_pick.as_ref();
    let legs = message.legs.iter().map(read_leg);
    Ok(Cycle {
        arm: name("cycle.arm", &message.arm)?.to_owned(),
        cycle_s: span_s("cycle.cycle_s", message.cycle_s, MAX_CYCLE_S)?,
        container_from_item_at_pick: pose::read_required(field, at_pick)?,
        grasp_yaw_rad: angle_rad("cycle.grasp_yaw_rad", message.grasp_yaw_rad)?,
        grip_s: span_s("cycle.grip_s", message.grip_s, MAX_WAIT_S)?,
        release_s: span_s("cycle.release_s", message.release_s, MAX_WAIT_S)?,
        legs: legs.collect::<Result<_, _>>()?,
    })
}

fn read_leg(message: &v1::ArmLeg) -> Result<Leg, WireError> {
    let kind = pairs::read(&KINDS, &message.kind()).ok_or_else(|| {
        let reason = format_args!("{} is no leg that is known", message.kind);
        WireError::invalid("cycle.legs.kind", reason)
    })?;
    let trajectory = needed("cycle.legs.trajectory", message.trajectory.as_ref())?;
    let points = read_trajectory(trajectory)?;
    Ok(Leg { kind, points })
}

fn read_trajectory(message: &v1::Trajectory) -> Result<Vec<JointPoint>, WireError> {
    let (time_s, position_rad) = (&message.time_s, &message.position_rad);
    count("trajectory.time_s", time_s.len(), 1..=MAX_POINTS)?;
    let angles = time_s.len() * JOINTS;
    let field = "trajectory.position_rad";
    count(field, position_rad.len(), angles..=angles)?;
    for angle in position_rad {
        angle_rad(field, *angle)?;
    }
    let mut before_s = None;
    let points = time_s.iter().zip(position_rad.as_chunks().0);
    points
        .map(|(time_s, position_rad)| {
            let time_s = span_s("trajectory.time_s", *time_s, MAX_CYCLE_S)?;
            let follows = match before_s {
                None => time_s == 0.0,
                Some(before_s) => time_s > before_s,
            };
            let possible = "times begin at 0 and increase";
            before_s = Some(checked("trajectory.time_s", time_s, follows, possible)?);
            Ok(JointPoint {
                time_s,
                position_rad: *position_rad,
            })
        })
        .collect()
}

/// Writes a cycle.
pub fn write(cycle: &Cycle) -> v1::ArmCycle {
    v1::ArmCycle {
        arm: cycle.arm.clone(),
        cycle_s: cycle.cycle_s,
        container_from_item_at_pick: Some(pose::write(&cycle.container_from_item_at_pick)),
        grasp_yaw_rad: cycle.grasp_yaw_rad,
        grip_s: cycle.grip_s,
        release_s: cycle.release_s,
        legs: cycle.legs.iter().map(write_leg).collect(),
    }
}

fn write_leg(leg: &Leg) -> v1::ArmLeg {
    let points = leg.points.iter();
    let angles = points.clone().flat_map(|point| point.position_rad);
    v1::ArmLeg {
        kind: pairs::write(&KINDS, &leg.kind).into(),
        trajectory: Some(v1::Trajectory {
            time_s: points.map(|point| point.time_s).collect(),
            position_rad: angles.collect(),
        }),
    }
}

fn span_s(field: &'static str, value: f64, most_s: f64) -> Result<f64, WireError> {
    let is_possible = (0.0..=most_s).contains(&value);
    let possible = format_args!("seconds from 0 to {most_s} are possible");
    checked(field, value, is_possible, possible)
}

fn angle_rad(field: &'static str, value: f64) -> Result<f64, WireError> {
    let possible = "radians within two turns are possible";
    checked(field, value, value.abs() <= MAX_ANGLE_RAD, possible)
}
