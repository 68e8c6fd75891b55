//! Forward and inverse kinematics of the built-in arms agree.
use std::f64::consts::{PI, TAU};

use ppnpack_robot::arm::Arm;
use ppnpack_robot::arms;
use ppnpack_robot::joints::JointAngles;
use proptest::prelude::*;

fn built_in() -> Vec<Arm> {
    arms::names().map(|name| arms::arm(name).unwrap()).collect()
}

/// Joint angles within an arm's limits, from shares of their ranges.
fn within_limits(arm: &Arm, shares: [f64; 6]) -> JointAngles {
    let mut angles = shares;
    for (angle, limits) in angles.iter_mut().zip(arm.limits()) {
        *angle = limits.lowest_rad + *angle * (limits.highest_rad - limits.lowest_rad);
    }
    JointAngles::new(angles)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn every_inverse_solution_leads_back_to_the_pose(shares in prop::array::uniform6(0.0..1.0_f64)) {
        for arm in built_in() {
            let kinematics = arm.kinematics();
            let joints = within_limits(&arm, shares);
            let pose = kinematics.base_from_flange(&joints);
            let solutions = kinematics.inverse(&pose);
            prop_assert!(solutions.len() <= 8);
            for solution in &solutions {
                let back = kinematics.base_from_flange(solution);
                prop_assert!((back.translation.vector - pose.translation.vector).norm() < 1e-5);
                prop_assert!(back.rotation.angle_to(&pose.rotation) < 1e-5);
            }
            // Among the solutions are the angles that the pose was made of; near a singularity
            // others take their place.
            let wrist = joints.as_array()[4].sin().abs();
            let is_found = solutions.iter().any(|solution| {
                solution.as_array().iter().zip(joints.as_array()).all(|(a, b)| {
                    let difference = (a - b + PI).rem_euclid(TAU) - PI;
                    difference.abs() < 1e-4
                })
            });
            prop_assert!(is_found || wrist < 0.01, "{}: {joints:?} of {solutions:?}", arm.name());
        }
    }

    #[test]
    fn what_is_far_away_has_no_solution(
        (x, y, z) in (-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64),
    ) {
        let direction = nalgebra::Vector3::new(x, y, z);
        prop_assume!(direction.norm() > 0.1);
        for arm in built_in() {
            let far = nalgebra::Point3::from(direction.normalize() * 2.5);
            prop_assert!(arm.inverse(&far, 0.0).is_empty());
        }
    }
}

#[test]
fn poses_that_are_no_numbers_have_no_solution() {
    for arm in built_in() {
        for bad in [f64::NAN, f64::INFINITY, 1e300] {
            let nowhere = nalgebra::Point3::new(bad, 0.0, 0.0);
            assert!(arm.inverse(&nowhere, 0.0).is_empty());
        }
    }
}

/// With the upper arm upright and the forearm forwards, a data sheet's drawing gives the flange's
/// place.
#[test]
fn the_nachi_arm_stands_as_its_drawing_shows() {
    let arm = arms::arm("nachi-mz07l").unwrap();
    let drawn = [0.0, 90.0, 0.0, 0.0, 0.0, 0.0].map(f64::to_radians);
    let flange = arm.kinematics().base_from_flange(&JointAngles::new(drawn));
    let expected = nalgebra::Vector3::new(0.050 + 0.440 + 0.073, 0.0, 0.345 + 0.420 + 0.045);
    assert!((flange.translation.vector - expected).norm() < 1e-9);
    // J2 leans back and J3 lifts the forearm as they grow; J5 bends the wrist up.
    let moved = |joint: usize, by_deg: f64| {
        let mut angles = drawn;
        angles[joint] += by_deg.to_radians();
        let flange = arm.kinematics().base_from_flange(&JointAngles::new(angles));
        flange.translation.vector
    };
    assert!(moved(1, 10.0).x < expected.x && moved(1, -10.0).x > expected.x - 0.2);
    assert!(moved(2, 10.0).z > expected.z && moved(4, 10.0).z > expected.z);
    assert!(moved(0, 10.0).y > 0.0);
}
