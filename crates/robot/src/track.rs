//! Joint angles along a path of the cup, the flange facing down: each inverse solution at its start
//! followed to its end.
//!
//! The axis of the cup is J6's, so a turn of the flange about the vertical changes J6 alone. Paths
//! are followed for a flange that is not turned, and J6 is turned afterwards.

use std::cmp::Ordering;

use nalgebra::Point3;

use crate::arm::Arm;
use crate::cell::CellSettings;
use crate::joints::{JOINTS, Joint, JointAngles, wrapped};
use crate::refusal::Refusal;

/// Maximum turn of a joint between two waypoints, in radians: more would be another solution.
const GREATEST_STEP_RAD: f64 = 0.35;

/// Ways to follow a path, and why the way that came furthest ended where there is none.
struct Tracked {
    /// Joint angles per waypoint, within the limits of J1 to J5, the most raised elbow first.
    branches: Vec<Vec<JointAngles>>,
    /// The reason why others ended.
    refusal: Option<Refusal>,
}

/// Number of halvings of the waypoints' distance where a path is not straight enough.
const HALVINGS: i32 = 2;

/// Finds the first branch along a path of the cup of which something can be made, with waypoints as
/// close as it needs.
///
/// `lips` gives the path for a distance of its waypoints; `make` makes something of the joints
/// along it.
///
/// # Errors
/// The reason why the branch that came furthest is not possible.
pub(crate) fn first_possible<Lips: AsRef<[Point3<f64>]>, Made>(
    arm: &Arm,
    cell: &CellSettings,
    lips: impl Fn(f64) -> Lips,
    make: impl Fn(Vec<JointAngles>, &Lips) -> Result<Made, Refusal>,
) -> Result<Made, Refusal> {
    let mut refusal = None;
    for halved in 0..=HALVINGS {
        let lips = lips(cell.waypoint_step_m * 0.5_f64.powi(halved));
        let tracked = track(arm, lips.as_ref(), cell.least_wrist_bend_deg.to_radians());
        refusal = tracked.refusal;
        let mut is_too_coarse = false;
        for branch in tracked.branches {
            match make(branch, &lips) {
                Ok(made) => return Ok(made),
                Err(refused) => {
                    is_too_coarse |= matches!(refused, Refusal::NotStraight { .. });
                    further(&mut refusal, refused);
                }
            }
        }
        if !is_too_coarse {
            break;
        }
    }
    Err(refusal.unwrap_or(Refusal::OutOfReach { height_m: 0.0 }))
}

/// Follows every inverse solution at the first lip position through all others.
fn track(arm: &Arm, lips: &[Point3<f64>], least_bend_rad: f64) -> Tracked {
    let mut refusal = None;
    let mut goes_on = |result: Result<(), Refusal>| match result {
        Ok(()) => true,
        Err(refused) => {
            further(&mut refusal, refused);
            false
        }
    };
    let mut branches: Vec<Vec<JointAngles>> = Vec::new();
    for (at, lip) in lips.iter().enumerate() {
        let mut solutions = arm.inverse(lip, 0.0);
        if solutions.is_empty() {
            branches.clear();
            goes_on(Err(Refusal::OutOfReach { height_m: lip.z }));
        } else if at == 0 {
            solutions.retain(|joints| goes_on(start(arm, joints, least_bend_rad)));
            branches = solutions.into_iter().map(|joints| vec![joints]).collect();
        } else {
            branches.retain_mut(|branch| goes_on(advance(arm, branch, &solutions, least_bend_rad)));
        }
        if branches.is_empty() {
            break;
        }
    }
    branches.retain_mut(|branch| goes_on(turn_into_limits(arm, branch)));
    let rank = |branch: &Vec<JointAngles>| {
        let first = branch.first()?;
        let [_, _, _, elbow, ..] = arm.container_from_links(first);
        let [_, _, _, forearm_turn, ..] = first.as_array();
        // Solutions with the same arm and the wrist turned over have the same elbow, up to the last
        // bits.
        Some(((-elbow.translation.z * 1e6).round(), forearm_turn.abs()))
    };
    branches.sort_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap_or(Ordering::Equal));
    Tracked { branches, refusal }
}

/// Keeps the refusal that came further.
fn further(held: &mut Option<Refusal>, refused: Refusal) {
    let before = held.as_ref().map(Refusal::progress);
    if before.is_none_or(|before| refused.progress() > before) {
        *held = Some(refused);
    }
}

fn start(arm: &Arm, joints: &JointAngles, least_bend_rad: f64) -> Result<(), Refusal> {
    bent(arm, joints, least_bend_rad)?;
    let angles = joints.as_array().iter().zip(arm.limits());
    for (joint, (angle, limits)) in Joint::ALL.into_iter().zip(angles).take(JOINTS - 1) {
        if limits.turns_into((*angle, *angle), 0.0).is_none() {
            return Err(Refusal::JointLimit { joint });
        }
    }
    Ok(())
}

/// Adds the solution that continues a branch.
fn advance(
    arm: &Arm,
    branch: &mut Vec<JointAngles>,
    solutions: &[JointAngles],
    least_bend_rad: f64,
) -> Result<(), Refusal> {
    let none = Refusal::OutOfReach { height_m: f64::NAN };
    let last = branch.last().ok_or(none.clone())?;
    let steps = solutions.iter().map(|solution| {
        let joints = solution.unwrapped_near(last);
        (joints, joints.greatest_step(last))
    });
    let nearest = steps.min_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let (joints, (joint, step_rad)) = nearest.ok_or(none)?;
    if step_rad > GREATEST_STEP_RAD {
        return Err(Refusal::Discontinuous { joint, step_rad });
    }
    bent(arm, &joints, least_bend_rad)?;
    let bend_rad = |joints| wrapped(arm.kinematics().wrist_bend_rad(joints));
    if least_bend_rad > 0.0 && bend_rad(&joints) * bend_rad(last) < 0.0 {
        return Err(Refusal::WristSingularity);
    }
    branch.push(joints);
    Ok(())
}

fn bent(arm: &Arm, joints: &JointAngles, least_bend_rad: f64) -> Result<(), Refusal> {
    let bend_rad = wrapped(arm.kinematics().wrist_bend_rad(joints)).abs();
    if bend_rad < least_bend_rad || bend_rad > std::f64::consts::PI - least_bend_rad {
        return Err(Refusal::WristSingularity);
    }
    Ok(())
}

/// Adds whole turns to J1 to J5 so that they are within their limits everywhere.
fn turn_into_limits(arm: &Arm, branch: &mut [JointAngles]) -> Result<(), Refusal> {
    let mut turns = [0.0; JOINTS];
    let joints = Joint::ALL.into_iter().zip(arm.limits()).zip(&mut turns);
    for (index, ((joint, limits), turn)) in joints.enumerate().take(JOINTS - 1) {
        let range = range(branch, index);
        let turns = limits.turns_into(range, 0.0);
        *turn = turns.ok_or(Refusal::JointLimit { joint })?;
    }
    for joints in branch {
        let mut angles = *joints.as_array();
        for (angle, turn) in angles.iter_mut().zip(&turns) {
            *angle += turn;
        }
        *joints = JointAngles::new(angles);
    }
    Ok(())
}

/// Gives the least and the greatest angle of a joint along a branch, in radians.
pub(crate) fn range(branch: &[JointAngles], joint: usize) -> (f64, f64) {
    let branch = branch.iter();
    let angles = branch.filter_map(|joints| joints.as_array().get(joint));
    angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), angle| {
        (low.min(*angle), high.max(*angle))
    })
}
