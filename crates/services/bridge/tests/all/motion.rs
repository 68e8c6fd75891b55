//! The motion that was checked for a placement reaches the robot that makes it, and the simulated robot follows it.

use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::common::catalogue;
use nalgebra::Isometry3;
use ppnpack_bridge::robot::{CutOff, Ending, Placement, Robot};
use ppnpack_bridge::simulated::{JointState, SimulatedRobot, SimulatedSettings};
use ppnpack_packing::motion::{Cycle, JOINTS, JointPoint, Leg, LegKind};
use ppnpack_service::Shutdown;

/// A cycle whose legs take a tenth of a second each; joint `n` moves `n` times as far as the first.
fn cycle() -> Cycle {
    let kinds = [
        LegKind::Descend,
        LegKind::Lift,
        LegKind::Transfer,
        LegKind::Insert,
        LegKind::Retreat,
        LegKind::Return,
    ];
    let leg = |(number, kind): (usize, LegKind)| {
        let point = |time_s: f64| JointPoint {
            time_s,
            position_rad: std::array::from_fn(|joint| {
                (number as f64 + 10.0 * time_s) * (joint + 1) as f64 * 0.1
            }),
        };
        Leg {
            kind,
            points: vec![point(0.0), point(0.04), point(0.1)],
        }
    };
    Cycle {
        arm: "an arm".to_owned(),
        cycle_s: 0.7,
        container_from_item_at_pick: Isometry3::translation(0.1, -0.35, 0.02),
        grasp_yaw_rad: 0.0,
        grip_s: 0.06,
        release_s: 0.04,
        legs: kinds.into_iter().enumerate().map(leg).collect(),
    }
}

fn placement(cycle: Option<Arc<Cycle>>) -> Placement {
    Placement {
        placement_id: "one".to_owned(),
        item_id: "item-one".to_owned(),
        object: "brick".to_owned(),
        container_from_item: Isometry3::translation(0.16, 0.16, 0.02),
        state_number: 1,
        cycle,
    }
}

/// A simulated robot, and where its joints were.
fn watched(motion_speed: f64) -> (SimulatedRobot, Arc<Mutex<Vec<JointState>>>) {
    let settings = SimulatedSettings {
        motion_speed,
        ..SimulatedSettings::default()
    };
    let mut robot = SimulatedRobot::new(settings, &catalogue()).unwrap();
    let states = Arc::new(Mutex::new(Vec::new()));
    let noted = Arc::clone(&states);
    robot.watch_joints(Box::new(move |state| noted.lock().unwrap().push(state)));
    (robot, states)
}

#[test]
fn the_simulated_robot_follows_the_joint_angles_in_time() {
    let (mut robot, states) = watched(1.0);
    let cycle = Arc::new(cycle());
    let started = Instant::now();
    let finding = robot
        .place(&placement(Some(Arc::clone(&cycle))), &Shutdown::default())
        .unwrap();
    assert!(started.elapsed() >= Duration::from_secs_f64(cycle.cycle_s));
    assert_eq!(finding.ending, Ending::Placed);
    let states = states.lock().unwrap();
    let legs: Vec<LegKind> = cycle.legs.iter().map(|leg| leg.kind).collect();
    let mut followed: Vec<LegKind> = states.iter().map(|state| state.leg).collect();
    followed.dedup();
    assert_eq!(followed, legs);
    for state in states.iter() {
        let number = legs.iter().position(|leg| *leg == state.leg).unwrap();
        for joint in 0..JOINTS {
            let expected = (number as f64 + 10.0 * state.time_s) * (joint + 1) as f64 * 0.1;
            assert!(
                (state.joints_rad[joint] - expected).abs() < 1e-9,
                "{state:?}"
            );
        }
    }
    let last = states.last().unwrap();
    assert_eq!(last.joints_rad, cycle.legs[5].points[2].position_rad);
}

#[test]
fn a_robot_that_is_told_to_stop_gives_up_before_it_holds_the_item_and_not_after() {
    let cycle = Arc::new(cycle());
    let stopped = Shutdown::default();
    stopped.request();
    let (mut robot, _) = watched(0.0);
    let placement = placement(Some(cycle));
    assert_eq!(robot.place(&placement, &stopped).unwrap_err(), CutOff);
    assert!(robot.bodies().is_empty());

    let (mut robot, states) = watched(1.0);
    let end = Shutdown::default();
    let (lifting, lifted) = channel();
    let of_robot = end.clone();
    let waiter = std::thread::spawn(move || {
        lifted.recv().unwrap();
        of_robot.request();
    });
    let noted = Arc::clone(&states);
    robot.watch_joints(Box::new(move |state| {
        if state.leg == LegKind::Lift {
            lifting.send(()).ok();
        }
        noted.lock().unwrap().push(state);
    }));
    let finding = robot.place(&placement, &end).unwrap();
    waiter.join().unwrap();
    assert_eq!(finding.ending, Ending::Placed);
    assert_eq!(states.lock().unwrap().last().unwrap().leg, LegKind::Return);
}
