//! How an arm carries out a decision.

use std::f64::consts::TAU;

use ppnpack_packing::motion::{Cycle, JOINTS, JointPoint, Leg, LegKind, MAX_POINTS};

use super::{pairs, pose};
use crate::error::{WireError, needed};
use crate::limits::{checked, count, name};
use crate::v1::{self, ArmLegKind};

/// The most legs of a cycle.
const MAX_LEGS: usize = 16;

/// The longest cycle, in seconds.
const MAX_CYCLE_S: f64 = 86_400.0;

/// The longest wait for the cup, in seconds.
const MAX_WAIT_S: f64 = 60.0;

/// The greatest angle in either direction, in radians.
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

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;

    fn cycle() -> Cycle {
        let point = |time_s: f64| JointPoint {
            time_s,
            position_rad: [0.1, -0.2, time_s, 3.0, -6.0, 12.5],
        };
        let leg = |kind, count: u32| Leg {
            kind,
            points: (0..count)
                .map(|step| point(f64::from(step) * 0.01))
                .collect(),
        };
        Cycle {
            arm: "an arm".to_owned(),
            cycle_s: 2.5,
            container_from_item_at_pick: Isometry3::translation(0.1, -0.35, 0.02),
            grasp_yaw_rad: 0.75,
            grip_s: 0.2,
            release_s: 0.15,
            legs: vec![leg(LegKind::Descend, 3), leg(LegKind::Lift, 1)],
        }
    }

    type Change = fn(&mut v1::ArmCycle);

    /// What a changed message is refused for.
    fn refusal(change: impl FnOnce(&mut v1::ArmCycle)) -> String {
        let mut message = write(&cycle());
        change(&mut message);
        read(&message).unwrap_err().to_string()
    }

    fn trajectory(message: &mut v1::ArmCycle) -> &mut v1::Trajectory {
        message.legs[0].trajectory.as_mut().unwrap()
    }

    #[test]
    fn a_cycle_is_read_as_it_was_written() {
        assert_eq!(read(&write(&cycle())), Ok(cycle()));
    }

    #[test]
    fn what_is_not_possible_is_refused_by_name() {
        let cases: [(&str, Change); 14] = [
            ("cycle.arm", |cycle| cycle.arm.clear()),
            ("cycle.cycle_s", |cycle| cycle.cycle_s = f64::NAN),
            ("cycle.cycle_s", |cycle| cycle.cycle_s = -1.0),
            ("cycle.container_from_item_at_pick", |cycle| {
                cycle.container_from_item_at_pick = None;
            }),
            ("cycle.grasp_yaw_rad", |cycle| cycle.grasp_yaw_rad = 13.0),
            ("cycle.grip_s", |cycle| cycle.grip_s = 61.0),
            ("cycle.release_s", |cycle| cycle.release_s = f64::INFINITY),
            ("cycle.legs", |cycle| cycle.legs.clear()),
            ("cycle.legs", |cycle| {
                cycle.legs = vec![cycle.legs[0].clone(); 17];
            }),
            ("cycle.legs.kind", |cycle| cycle.legs[0].kind = 99),
            ("cycle.legs.trajectory", |cycle| {
                cycle.legs[1].trajectory = None;
            }),
            ("trajectory.position_rad", |cycle| {
                trajectory(cycle).position_rad.pop();
            }),
            ("trajectory.position_rad", |cycle| {
                trajectory(cycle).position_rad[7] = f64::NAN;
            }),
            ("trajectory.time_s", |cycle| {
                *trajectory(cycle) = v1::Trajectory {
                    time_s: (0..2_001).map(f64::from).collect(),
                    position_rad: vec![0.0; 2_001 * JOINTS],
                };
            }),
        ];
        for (field, change) in cases {
            let message = refusal(change);
            assert!(message.starts_with(field), "{message} names {field}");
        }
    }

    #[test]
    fn times_begin_at_zero_and_increase() {
        for times_s in [
            [0.001, 0.01, 0.02],
            [0.0, 0.01, 0.01],
            [0.0, 0.02, 0.01],
            [0.0, f64::NAN, 0.01],
            [0.0, 0.01, 1e6],
        ] {
            let message = refusal(|cycle| trajectory(cycle).time_s = times_s.to_vec());
            assert!(message.starts_with("trajectory.time_s"), "{message}");
        }
    }
}
