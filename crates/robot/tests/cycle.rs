//! Whole cycles: timed within limits, straight where they must be, clear of everything.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod common;

use std::sync::Arc;

use common::scenes::{Case, case};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use ppnpack_packing::motion::LegKind;
use ppnpack_packing::step::StepInput;
use ppnpack_robot::arms;
use ppnpack_robot::cell::CellSettings;
use ppnpack_robot::cycle::{CycleSettings, PlannedCycle};
use ppnpack_robot::feasibility::ArmCheck;
use ppnpack_robot::motion::{PlacePlanner, Placing};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Beside the container, on the table.
fn pick_pose(random: &mut ChaCha8Rng) -> Isometry3<f64> {
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), random.random_range(-3.0..3.0));
    let at = Translation3::new(
        random.random_range(-0.1..0.3),
        random.random_range(-0.45..-0.25),
        0.0,
    );
    Isometry3::from_parts(at, yaw)
}

/// Cycles of random cases that can be planned, with the planner that made them.
fn cycles(name: &str, count: usize) -> (PlacePlanner, Vec<(Case, Isometry3<f64>, PlannedCycle)>) {
    let arm = Arc::new(arms::arm(name).unwrap());
    let mut planner = PlacePlanner::new(Arc::clone(&arm), CellSettings::default()).unwrap();
    let mut check = ArmCheck::new(planner.clone());
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut found = Vec::new();
    for _ in 0..4 * count {
        let case = case(&mut random);
        let pose = pick_pose(&mut random);
        let Ok(pick) = check.pick(&case.candidate(), case.grid.resolution()) else {
            continue;
        };
        let placing = Placing {
            grid: &case.grid,
            scene: &case.scene,
            item: &case.item,
            resting: &case.resting,
            pick: &pick,
        };
        if let Ok(cycle) = planner.plan_cycle(&placing, &pose, &CycleSettings::default()) {
            // What a whole cycle can do, the place motion alone can.
            let input = StepInput::new(&case.grid, &case.scene, &[]);
            assert!(check.plan(&input, &case.candidate(), &case.resting).is_ok());
            found.push((case, pose, cycle));
        }
        if found.len() == count {
            break;
        }
    }
    assert_eq!(found.len(), count, "{name}");
    (planner, found)
}

#[test]
fn cycles_keep_the_limits_and_join_at_rest() {
    for name in arms::names() {
        let (planner, found) = cycles(name, 12);
        for (_, _, cycle) in &found {
            let legs: Vec<_> = cycle.legs.iter().map(|(leg, _)| *leg).collect();
            assert_eq!(
                legs,
                [
                    LegKind::Descend,
                    LegKind::Lift,
                    LegKind::Transfer,
                    LegKind::Insert,
                    LegKind::Retreat,
                    LegKind::Return
                ]
            );
            let moving_s: f64 = cycle.legs.iter().map(|(_, leg)| leg.duration_s()).sum();
            assert!((cycle.cycle_s - moving_s - 0.35).abs() < 1e-9);
            assert!(
                (0.8..6.0).contains(&cycle.cycle_s),
                "{name}: {} s",
                cycle.cycle_s
            );
            for (next, (_, leg)) in cycle.legs.iter().enumerate() {
                let end = leg.at(leg.duration_s()).unwrap();
                let (_, following) = &cycle.legs[(next + 1) % cycle.legs.len()];
                let start = following.at(0.0).unwrap();
                for (a, b) in end.as_array().iter().zip(start.as_array()) {
                    assert!((a - b).abs() < 1e-9, "{name}: legs join");
                }
                let h = 1e-3;
                let samples: Vec<_> = leg.samples(h).map(|(_, joints)| joints).collect();
                let whole = &samples[..samples.len() - 1];
                for (joint, limits) in planner.arm().limits().iter().enumerate() {
                    for window in whole.windows(3) {
                        let [a, b, c] = [0, 1, 2].map(|at| window[at].as_array()[joint]);
                        let speed = (c - a).abs() / (2.0 * h);
                        assert!(speed <= limits.speed_rad_per_s * 1.001, "{name} {joint}");
                        let acceleration = (c - 2.0 * b + a).abs() / (h * h);
                        assert!(
                            acceleration <= limits.acceleration_rad_per_s2 * 1.01,
                            "{name} {joint}: {acceleration}"
                        );
                        assert!(limits.contains(b));
                    }
                    let first = (whole[1].as_array()[joint] - whole[0].as_array()[joint]).abs() / h;
                    assert!(
                        first <= limits.acceleration_rad_per_s2 * h * 1.01,
                        "at rest"
                    );
                }
            }
        }
    }
}

#[test]
fn the_cup_goes_straight_down_and_carries_at_one_height() {
    for name in arms::names() {
        let (planner, found) = cycles(name, 8);
        for (case, pose, cycle) in &found {
            let tolerance_m = planner.cell().path_tolerance_m;
            for (leg, trajectory) in &cycle.legs {
                let joints: Vec<_> = trajectory
                    .samples(0.002)
                    .map(|(_, joints)| joints)
                    .collect();
                let lips: Vec<_> = joints
                    .iter()
                    .map(|joints| planner.arm().lip(joints))
                    .collect();
                let end = lips[lips.len() - 1];
                for (lip, joints) in lips.iter().zip(&joints) {
                    match leg {
                        LegKind::Transfer | LegKind::Return => {
                            assert!((lip.z - end.z).abs() < 0.005, "{name} {leg:?}");
                        }
                        _ => assert!((lip - end).xy().norm() < tolerance_m, "{name} {leg:?}"),
                    }
                    let [.., flange] = planner.arm().container_from_links(joints);
                    let axis = flange.rotation * Vector3::z();
                    assert!(axis.z < -0.9999, "{name}: the cup faces down");
                }
            }
            // The item's yaw changes from that of the pick to that of the placement.
            let flange_yaw = |leg: usize| {
                let trajectory = &cycle.legs[leg].1;
                let joints = trajectory.at(trajectory.duration_s()).unwrap();
                let [.., flange] = planner.arm().container_from_links(&joints);
                flange.rotation
            };
            let placed = case
                .item
                .container_from_item(&case.grid, &case.resting)
                .unwrap();
            let item_turn = placed.rotation * pose.rotation.inverse();
            let turn = flange_yaw(3) * flange_yaw(0).inverse();
            assert!(turn.angle_to(&item_turn) < 1e-4, "{name}");
        }
    }
}

#[test]
fn impossible_settings_are_named() {
    let slow = CycleSettings {
        speed_share: 0.0,
        ..CycleSettings::default()
    };
    assert!(
        slow.validate()
            .unwrap_err()
            .to_string()
            .starts_with("speed_share")
    );
}
