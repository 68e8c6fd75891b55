//! Cycles as whoever carries them out is given them: joint angles over time.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;

use nalgebra::{Isometry3, Point2, Vector3};
use ppnpack_packing::candidate::Lying;
use ppnpack_packing::check::{ValidityCheck, Verdict};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::motion::{Cycle, LegKind, MAX_POINTS};
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::step::{Candidate, StepInput};
use ppnpack_robot::cycle::CycleSettings;
use ppnpack_robot::station::{ArmStation, StationSettings};

/// A block of 6 x 6 cells, 4 cm high, at each of the grid's yaws.
fn block() -> Candidate {
    let view = ViewSurfaces {
        nx: 6,
        ny: 6,
        top: vec![20; 36],
        bottom: vec![0; 36],
        underside: None,
        origin_from_corner_m: Vector3::new(0.03, 0.03, 0.0),
        centre_of_mass_m: Some(Point2::new(0.03, 0.03)),
    };
    Candidate::new(0, Arc::new(Item::new("block", vec![view; 4], 0.0).unwrap()))
}

/// The cycle that is the evidence of a placement, and the station whose check gave it.
fn cycle(settings: &StationSettings, candidate: &Candidate) -> (ArmStation, Arc<Cycle>) {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let input = StepInput::new(&grid, &scene, &[]);
    let resting = RestingPlacement {
        placement: Placement {
            yaw: 1,
            x: 20,
            y: 5,
        },
        resting_height: 0,
    };
    let station = ArmStation::new(settings).unwrap();
    let verdict = station.check().judge(&input, candidate, &resting).unwrap();
    let Verdict::Accepted(evidence) = verdict else {
        panic!("{verdict:?}");
    };
    (station, evidence.cycle.unwrap())
}

#[test]
fn a_sampled_cycle_keeps_the_joints_limits_and_its_times_increase() {
    for name in ppnpack_robot::arms::names() {
        let settings = StationSettings {
            arm: name.to_owned(),
            ..StationSettings::default()
        };
        let (station, cycle) = cycle(&settings, &block());
        let arm = ppnpack_robot::arm::Arm::new(station.parameters()).unwrap();
        assert_eq!(cycle.arm, station.parameters().name);
        let kinds: Vec<LegKind> = cycle.legs.iter().map(|leg| leg.kind).collect();
        assert_eq!(
            kinds,
            [
                LegKind::Descend,
                LegKind::Lift,
                LegKind::Transfer,
                LegKind::Insert,
                LegKind::Retreat,
                LegKind::Return
            ]
        );
        let mut moving_s = 0.0;
        for (leg, next) in cycle.legs.iter().zip(cycle.legs.iter().cycle().skip(1)) {
            let end = leg.points.last().unwrap();
            moving_s += end.time_s;
            assert!(leg.points[0].time_s == 0.0);
            for (joint, limits) in arm.limits().iter().enumerate() {
                let join = end.position_rad[joint] - next.points[0].position_rad[joint];
                assert!(join.abs() < 1e-9, "{name}: legs join");
                for pair in leg.points.windows(2) {
                    let moved = pair[1].position_rad[joint] - pair[0].position_rad[joint];
                    let within_s = pair[1].time_s - pair[0].time_s;
                    assert!(within_s > 0.0);
                    assert!(limits.contains(pair[1].position_rad[joint]), "{name}");
                    assert!(
                        moved.abs() <= limits.speed_rad_per_s * within_s * 1.001 + 1e-9,
                        "{name}"
                    );
                }
            }
        }
        assert!((cycle.cycle_s - moving_s - cycle.grip_s - cycle.release_s).abs() < 1e-6);
    }
}

#[test]
fn a_slow_cycle_has_no_more_points_than_can_be_handed_on() {
    let settings = StationSettings {
        cycle: CycleSettings {
            speed_share: 0.001,
            acceleration_share: 0.001,
            ..CycleSettings::default()
        },
        ..StationSettings::default()
    };
    let (_, cycle) = cycle(&settings, &block());
    assert!(cycle.cycle_s > 60.0, "{}", cycle.cycle_s);
    let points = cycle.legs.iter().map(|leg| leg.points.len());
    let longest = points.max().unwrap();
    assert!(longest > 1_900 && longest <= MAX_POINTS, "{longest}");
}

#[test]
fn the_pose_at_the_pick_is_that_of_the_items_own_frame() {
    let turn = Isometry3::rotation(Vector3::x() * 1.2);
    let waits_at = Isometry3::translation(0.12, -0.28, 0.0) * turn;
    let mut candidate = block();
    candidate.lying = Lying {
        heightmap_from_item: Some(turn),
        waits_at: Some(waits_at),
    };
    let (_, cycle) = cycle(&StationSettings::default(), &candidate);
    let at_pick = cycle.container_from_item_at_pick;
    assert!((at_pick.translation.vector - waits_at.translation.vector).norm() < 0.02);
    assert!(at_pick.rotation.angle_to(&waits_at.rotation) < 1e-9);
}
