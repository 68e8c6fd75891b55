//! Whole cycles: timed within limits, straight where they must be, clear of everything.
use std::sync::Arc;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use ppnpack_packing::checks::motion::LegKind;
use ppnpack_packing::ranking::candidate::Lying;
use ppnpack_packing::ranking::step::StepInput;
use ppnpack_robot::arms;
use ppnpack_robot::cell::CellSettings;
use ppnpack_robot::cycle::{CycleSettings, PlannedCycle};
use ppnpack_robot::feasibility::ArmCheck;
use ppnpack_robot::motion::{PlacePlanner, Placing};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::common::scenes::{Case, case};

/// Beside the container, on the table.
fn pick_pose(random: &mut ChaCha8Rng) -> Isometry3<f64> {
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), random.random_range(-3.0..3.0));
    let x_m = random.random_range(-0.1..0.3);
    let y_m = random.random_range(-0.45..-0.25);
    Isometry3::from_parts(Translation3::new(x_m, y_m, 0.0), yaw)
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

const LEGS: [LegKind; 6] = [
    LegKind::Descend,
    LegKind::Lift,
    LegKind::Transfer,
    LegKind::Insert,
    LegKind::Retreat,
    LegKind::Return,
];

/// As whoever carries them out is given them: joint angles over time.
#[test]
fn sampled_cycles_keep_the_joints_limits_and_their_times_increase() {
    for name in arms::names() {
        let (planner, found) = cycles(name, 6);
        for (_, _, cycle) in &found {
            let sampled = cycle.sampled("arm", &Lying::default());
            let legs: Vec<_> = sampled.legs.iter().map(|leg| leg.kind).collect();
            assert_eq!(legs, LEGS);
            assert_eq!((&*sampled.arm, sampled.cycle_s), ("arm", cycle.cycle_s));
            assert!((0.8..6.0).contains(&cycle.cycle_s), "{name}: {cycle:?}");
            let nexts = sampled.legs.iter().cycle().skip(1);
            for (leg, next) in sampled.legs.iter().zip(nexts) {
                let end = leg.points.last().unwrap();
                assert_eq!(leg.points[0].time_s, 0.0);
                for (joint, limits) in planner.arm().limits().iter().enumerate() {
                    let join = end.position_rad[joint] - next.points[0].position_rad[joint];
                    assert!(join.abs() < 1e-9, "{name}: legs join");
                    for pair in leg.points.windows(2) {
                        let moved = pair[1].position_rad[joint] - pair[0].position_rad[joint];
                        let within_s = pair[1].time_s - pair[0].time_s;
                        assert!(within_s > 0.0);
                        assert!(limits.contains(pair[1].position_rad[joint]), "{name}");
                        let most = limits.speed_rad_per_s * within_s * 1.001 + 1e-9;
                        assert!(moved.abs() <= most, "{name}");
                    }
                }
            }
            let legs = sampled.legs.iter();
            let moving_s: f64 = legs
                .map(|leg| leg.points[leg.points.len() - 1].time_s)
                .sum();
            let cycle_s = moving_s + sampled.grip_s + sampled.release_s;
            assert!((sampled.cycle_s - cycle_s).abs() < 1e-6);
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
                let end = trajectory.at(trajectory.duration_s()).unwrap();
                let end = planner.arm().lip(&end);
                for (_, joints) in trajectory.samples(0.002) {
                    let lip = planner.arm().lip(&joints);
                    match leg {
                        LegKind::Transfer | LegKind::Return => {
                            assert!((lip.z - end.z).abs() < 0.005, "{name} {leg:?}");
                        }
                        _ => assert!((lip - end).xy().norm() < tolerance_m, "{name} {leg:?}"),
                    }
                    let [.., flange] = planner.arm().container_from_links(&joints);
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
            let placed = case.item.container_from_item(&case.grid, &case.resting);
            let item_turn = placed.unwrap().rotation * pose.rotation.inverse();
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
    let refused = slow.validate().unwrap_err().to_string();
    assert!(refused.starts_with("speed_share"), "{refused}");
}
