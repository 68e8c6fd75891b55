use nalgebra::{Point2, Vector3};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::placement::Placement;
use ppnpack_robot::cycle::CycleSettings;
use ppnpack_robot::feasibility::NAME;
use ppnpack_robot::station::StationSettings;
use ppnpack_service::ServiceSettings;
use ppnpack_wire::convert::check::from_name;

use super::*;
use crate::settings::{CellSettings, Settings};

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

fn resting() -> RestingPlacement {
    RestingPlacement {
        placement: Placement {
            yaw: 1,
            x: 20,
            y: 5,
        },
        resting_height: 0,
    }
}

/// The message of the block's cycle, and the station that made it.
fn cycle(settings: &StationSettings) -> (ArmStation, v1::ArmCycle) {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let input = StepInput::new(&grid, &scene, &[]);
    let station = ArmStation::new(settings).unwrap();
    let planned = station.cycle(&input, &block(), &resting()).unwrap();
    let message = write(&station, &planned);
    (station, message)
}

#[test]
fn the_check_has_its_name_on_the_wire() {
    assert_eq!(from_name(NAME), v1::Check::Arm);
}

#[test]
fn a_cycle_on_the_wire_keeps_the_joints_limits_and_its_times_increase() {
    for name in ppnpack_robot::arms::names() {
        let (station, message) = cycle(&StationSettings {
            arm: name.to_owned(),
            ..StationSettings::default()
        });
        // Reading checks that times begin at 0 and increase.
        let read = cycle::read(&message).unwrap();
        let arm = ppnpack_robot::arm::Arm::new(station.parameters()).unwrap();
        let kinds: Vec<ArmLegKind> = read.legs.iter().map(|leg| leg.kind).collect();
        assert_eq!(
            kinds,
            [
                ArmLegKind::Descend,
                ArmLegKind::Lift,
                ArmLegKind::Transfer,
                ArmLegKind::Insert,
                ArmLegKind::Retreat,
                ArmLegKind::Return
            ]
        );
        let mut moving_s = 0.0;
        for (leg, next) in read.legs.iter().zip(read.legs.iter().cycle().skip(1)) {
            let end = leg.points.last().unwrap();
            moving_s += end.time_s;
            for (joint, limits) in arm.limits().iter().enumerate() {
                let join = end.position_rad[joint] - next.points[0].position_rad[joint];
                assert!(join.abs() < 1e-9, "{name}: legs join");
                for pair in leg.points.windows(2) {
                    let moved = pair[1].position_rad[joint] - pair[0].position_rad[joint];
                    let within_s = pair[1].time_s - pair[0].time_s;
                    assert!(limits.contains(pair[1].position_rad[joint]), "{name}");
                    assert!(
                        moved.abs() <= limits.speed_rad_per_s * within_s * 1.001 + 1e-9,
                        "{name}"
                    );
                }
            }
        }
        assert!((read.cycle_s - moving_s - read.grip_s - read.release_s).abs() < 1e-6);
    }
}

#[test]
fn a_slow_cycle_has_no_more_points_than_the_wire_allows() {
    let (_, message) = cycle(&StationSettings {
        cycle: CycleSettings {
            speed_share: 0.001,
            acceleration_share: 0.001,
            ..CycleSettings::default()
        },
        ..StationSettings::default()
    });
    let read = cycle::read(&message).unwrap();
    assert!(read.cycle_s > 60.0, "{}", read.cycle_s);
    assert!(read.legs.iter().any(|leg| leg.points.len() > 1_900));
}

#[test]
fn after_the_deadline_the_arm_is_not_asked() {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let input = StepInput::new(&grid, &scene, &[]);
    let station = ArmStation::new(&StationSettings::default()).unwrap();
    let context = Arc::new(StepContext::new());
    let mut check = ArmInTime::new(&station, &context);
    let minute = std::time::Duration::from_secs(60);
    let rules = std::collections::HashMap::new;
    context.begin(Instant::now() + minute, 1, rules());
    assert!(check.is_valid(&input, &block(), &resting()).unwrap());
    assert!(!context.is_cut());
    context.begin(Instant::now(), 1, rules());
    assert!(!check.is_valid(&input, &block(), &resting()).unwrap());
    assert!(context.is_cut());
    assert_eq!(station.take_tally().asked, 1);
}

#[test]
fn an_unknown_arm_is_refused_with_the_names_there_are() {
    let refusal = |change: fn(&mut StationSettings)| {
        let mut station = StationSettings::default();
        change(&mut station);
        let cell = CellSettings {
            arm: Some(station),
            ..CellSettings::default()
        };
        let settings = Settings {
            cells: std::collections::BTreeMap::from([("cell-1".to_owned(), cell)]),
            ..Settings::default()
        };
        settings.validate().unwrap_err()
    };
    let unknown = refusal(|station| station.arm = "r2d2".to_owned());
    for part in ["cells.cell-1.arm", "r2d2", "nachi-mz07l"] {
        assert!(unknown.contains(part), "{unknown}");
    }
    let file = refusal(|station| station.arm = "no/such/arm.toml".to_owned());
    assert!(file.contains("no/such/arm.toml"), "{file}");
    let place = refusal(|station| station.pick.position_m[2] = f64::NAN);
    assert!(place.contains("pick.position_m[2]"), "{place}");
    let cell = refusal(|station| station.cell.clearance_m = -1.0);
    assert!(cell.contains("clearance_m"), "{cell}");
}
