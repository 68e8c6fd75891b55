//! An arm made of settings: what its check accepts it can carry out, and what it says of the rest.
use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use ppnpack_catalogue::build::{self, ModelSettings};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::checks::check::{ValidityCheck, Verdict};
use ppnpack_packing::checks::motion::{Cycle, MAX_POINTS};
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::kernel::objective::Order;
use ppnpack_packing::planning::plan::Planner;
use ppnpack_packing::ranking::candidate::Lying;
use ppnpack_packing::ranking::proposals::ProposeAll;
use ppnpack_packing::ranking::refusal::Cause;
use ppnpack_packing::ranking::search::{Search, SearchSettings};
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_packing::scene::Scene;
use ppnpack_packing::streams::episode::{Ending, IdealCell, Play, play};
use ppnpack_robot::arm::Arm;
use ppnpack_robot::arms;
use ppnpack_robot::cell::CellSettings;
use ppnpack_robot::cycle::{CycleSettings, PickPlace};
use ppnpack_robot::error::ParameterError;
use ppnpack_robot::feasibility::ArmCheck;
use ppnpack_robot::motion::PlacePlanner;
use ppnpack_robot::refusal::Refusal;
use ppnpack_robot::station::{ArmStation, StationSettings};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::common::scenes::{case, even, placed};

fn named(arm: &str) -> StationSettings {
    StationSettings {
        arm: arm.to_owned(),
        ..StationSettings::default()
    }
}

/// A block of so many cells and units, the same at all four yaws; its origin is 1 cm above its
/// lowest point.
fn block(cells: usize, height: i16) -> Arc<Item> {
    let mut view = even(cells, cells, height);
    view.origin_from_corner_m.z = 0.01;
    Arc::new(Item::new("block", vec![view; 4], 0.0).unwrap())
}

/// A model of a block of so many cells and units.
fn model(cells: usize, height: i16, mass_kg: f64) -> Model {
    let half_m = cells as f64 * 0.005;
    let top = [half_m, half_m, f64::from(height) * 0.002];
    let settings = ModelSettings {
        mass_kg: Some(mass_kg),
        ..ModelSettings::default()
    };
    let mesh = Mesh::cuboid([-half_m, -half_m, 0.0], top);
    build::model("block", mesh, &settings).unwrap().0
}

/// A planner for the reference grid that asks the station's check.
fn planner(station: &ArmStation) -> Planner {
    let search = Search::new(&Grid::reference(), &SearchSettings::default()).unwrap();
    let (search, check) = (Box::new(search.bounded()), Box::new(station.check()));
    Planner::new(Box::new(ProposeAll), search, vec![check], Order::Balance, 0)
}

#[test]
fn the_check_accepts_what_can_be_placed_and_has_a_whole_cycle() {
    for name in arms::names() {
        let station = ArmStation::new(&named(name)).unwrap();
        let mut check = station.check();
        let arm = Arc::new(Arm::new(station.parameters()).unwrap());
        let planner = PlacePlanner::new(arm, CellSettings::default()).unwrap();
        // One check of the place motion alone, one for the cycles.
        let mut motion = ArmCheck::new(planner.clone());
        let mut cycles =
            ArmCheck::new(planner).with_cycles(PickPlace::default(), CycleSettings::default());
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let (mut asked, mut accepted) = (0, 0);
        for _ in 0..150 {
            let case = case(&mut random);
            let candidate = case.candidate();
            let input = StepInput::new(&case.grid, &case.scene, std::slice::from_ref(&candidate));
            let can_hold = motion.pick(&candidate, case.grid.resolution()).is_ok();
            let ruled_out = check.rules_out(&input, &candidate).unwrap();
            assert_eq!(ruled_out.is_none(), can_hold, "{name}");
            let verdict = check.judge(&input, &candidate, &case.resting).unwrap();
            let placed = motion.plan(&input, &candidate, &case.resting);
            let cycle = cycles.cycle(&input, &candidate, &case.resting);
            asked += 1;
            match verdict {
                Verdict::Accepted(evidence) => {
                    accepted += 1;
                    assert!(placed.is_ok(), "{name}");
                    let planned = cycle.unwrap().unwrap();
                    let expected = planned.sampled(&station.parameters().name, &candidate.lying);
                    assert_eq!(evidence.cycle.as_deref(), Some(&expected), "{name}");
                }
                Verdict::Refused(refusal) => {
                    let causes = [placed.err(), cycle.err()];
                    let cause = causes.into_iter().flatten().next().unwrap().cause();
                    let expected =
                        ppnpack_packing::ranking::refusal::Refusal::because(Cause::Arm, cause);
                    assert_eq!(refusal, expected, "{name}");
                }
            }
        }
        assert!(accepted > 20 && accepted < asked, "{name}: {accepted}");
    }
}

#[test]
fn the_reference_container_can_be_packed_in_the_default_cell() {
    let grid = Grid::reference();
    for name in arms::names() {
        let station = ArmStation::new(&named(name)).unwrap();
        let mut planner = planner(&station);
        let items = Candidate::sequence((0..40).map(|index| block(6 + index % 3, 25)));
        let mut cell = IdealCell::new(&grid);
        let how = Play::with_buffer(3);
        let episode = play(&grid, &mut planner, &mut cell, items, how, &mut ()).unwrap();
        // A layer of 25 units holds at most 25 blocks of the smallest kind: they lie in layers.
        assert!(episode.steps.len() >= 30, "{name}: {}", episode.steps.len());
        assert!(episode.scene.heightmap().max() >= 50, "{name}");
        for step in &episode.steps {
            let cycle_s = step.cycle_s().unwrap();
            assert!((1.0..5.0).contains(&cycle_s), "{name}: {cycle_s} s");
        }
    }
}

#[test]
fn what_cannot_be_picked_is_left_out_with_the_reason_and_does_not_keep_others_waiting() {
    let grid = Grid::reference();
    let station = ArmStation::new(&StationSettings::default()).unwrap();
    let (narrow, heavy, light) = (block(2, 40), block(9, 40), block(6, 20));
    let known = |arrival, item: &Arc<Item>, model| {
        Candidate::new(arrival, Arc::clone(item)).with_model(Arc::new(model))
    };
    let items = vec![
        Candidate::new(0, narrow),
        known(1, &heavy, model(9, 40, 7.5)),
        known(2, &light, model(6, 20, 0.5)),
    ];
    let mut check = station.check();
    let [narrow, heavy, light] = [0, 1, 2].map(|at| check.lift(&items[at], grid.resolution()));
    assert!(matches!(narrow, Err(Refusal::Pick(_))));
    assert_eq!(heavy, Err(Refusal::TooHeavy { mass_kg: 7.5 }));
    assert!(light.is_ok());
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let input = StepInput::new(&grid, &scene, &items);
    let resting = placed(0, 0, 0);
    let cycle = check.cycle(&input, &items[1], &resting);
    assert_eq!(cycle, Err(Refusal::TooHeavy { mass_kg: 7.5 }));
    let mut cell = IdealCell::new(&grid);
    let how = Play::with_buffer(3);
    let episode = play(
        &grid,
        &mut planner(&station),
        &mut cell,
        items,
        how,
        &mut (),
    )
    .unwrap();
    let placed = episode.steps.iter().map(|step| step.candidate.arrival);
    assert_eq!(placed.collect::<Vec<_>>(), [2]);
    let Ending::NothingFits(reasons) = episode.ending else {
        panic!("two items cannot be picked");
    };
    for (candidate, reason) in reasons {
        let why = reason.to_string();
        assert!(why.contains("not possible for the arm"), "{why}");
        let expected = ["smaller than the cup", "weighs more"][candidate.arrival];
        assert!(why.contains(expected), "{why}");
    }
    // Nothing was asked of placements of what cannot be picked.
    assert_eq!(episode.refusals.total(), episode.steps[0].refusals.total());
}

#[test]
fn an_item_lies_with_its_pick_point_at_the_pick_place() {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let input = StepInput::new(&grid, &scene, &[]);
    let resting = placed(2, 12, 9);
    let pick = PickPlace {
        position_m: [0.05, -0.30, 0.02],
        yaw_deg: 30.0,
    };
    let station = ArmStation::new(&StationSettings {
        pick,
        ..StationSettings::default()
    })
    .unwrap();
    let mut check = station.check();
    let mut cycle_of = |waits_at| {
        let mut candidate = Candidate::new(3, block(6, 20));
        candidate.lying.waits_at = waits_at;
        let cycle = check.cycle(&input, &candidate, &resting).unwrap();
        cycle.unwrap()
    };
    let cycle = cycle_of(None);
    let from = cycle.container_from_item_at_pick;
    assert!((from.translation.z - 0.03).abs() < 1e-9);
    let (_, _, yaw_rad) = from.rotation.euler_angles();
    assert!((yaw_rad - 30_f64.to_radians()).abs() < 1e-9);
    let arm = Arm::new(station.parameters()).unwrap();
    let (_, descent) = &cycle.legs[0];
    let lip = arm.lip(&descent.at(descent.duration_s()).unwrap());
    let expected = Point3::new(0.05, -0.30, 0.02 + 0.04);
    assert!((lip - expected).norm() < 1e-6, "{lip}");

    let in_item = from.inverse() * lip;
    let waits_at = Isometry3::new(Vector3::new(0.12, -0.28, 0.0), Vector3::z() * -0.4);
    let cycle = cycle_of(Some(waits_at));
    let at_pick = cycle.container_from_item_at_pick;
    assert!(at_pick.rotation.angle_to(&waits_at.rotation) < 1e-9);
    let (_, descent) = &cycle.legs[0];
    let lip = arm.lip(&descent.at(descent.duration_s()).unwrap());
    assert!((lip - waits_at * in_item).norm() < 1e-6, "{lip}");
    // What is seen a little below the table lies on it.
    let sunk = Isometry3::new(Vector3::new(0.12, -0.28, -0.004), Vector3::z() * -0.4);
    let cycle = cycle_of(Some(sunk));
    assert!(cycle.container_from_item_at_pick.translation.z.abs() < 1e-9);
    assert_eq!(cycle_of(None).container_from_item_at_pick, from);
}

#[test]
fn arms_come_by_name_or_from_a_file_and_base_and_gripper_can_be_replaced() {
    let built_in = named("nachi-mz07l").parameters().unwrap();
    let path = std::env::temp_dir().join(format!("ppnpack-arm-{}.toml", std::process::id()));
    let of_file = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let read = named(path.to_str().unwrap()).parameters();
        std::fs::remove_file(&path).unwrap();
        read
    };
    let text = arms::text("nachi-mz07l").unwrap();
    assert_eq!(of_file(text), Ok(built_in.clone()));
    let wrong = of_file(&text.replace("payload_kg = 7.0", "payload_kg = -1.0"));
    assert!(wrong.unwrap_err().to_string().contains("payload_kg"));
    let too_large = of_file(&" ".repeat(2 << 20));
    let missing = named("no/such/file.toml").parameters();
    for refused in [too_large, missing] {
        assert!(matches!(refused, Err(ParameterError::File { .. })));
    }
    let unknown = named("r2d2").parameters().unwrap_err().to_string();
    assert_eq!(arms::arm("r2d2").unwrap_err().to_string(), unknown);
    for name in arms::names().chain(["r2d2"]) {
        assert!(unknown.contains(name), "{unknown}");
    }
    let mut settings = named("nachi-mz07l");
    let mut base = built_in.base;
    base.position_m[0] = -0.4;
    let mut gripper = built_in.gripper;
    gripper.cup_radius_m = 0.01;
    (settings.base, settings.gripper) = (Some(base), Some(gripper));
    let changed = settings.parameters().unwrap();
    assert_eq!((changed.base, changed.gripper), (base, gripper));
    gripper.cup_radius_m = -1.0;
    settings.gripper = Some(gripper);
    let refused = ArmStation::new(&settings).unwrap_err().to_string();
    assert!(refused.starts_with("gripper.cup_radius_m"), "{refused}");
}

/// The cycle that is the evidence of a placement.
fn cycle(settings: &StationSettings, candidate: &Candidate) -> Arc<Cycle> {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let input = StepInput::new(&grid, &scene, &[]);
    let mut check = ArmStation::new(settings).unwrap().check();
    match check.judge(&input, candidate, &placed(1, 20, 5)).unwrap() {
        Verdict::Accepted(evidence) => evidence.cycle.unwrap(),
        Verdict::Refused(refusal) => panic!("{refusal:?}"),
    }
}

#[test]
fn a_slow_cycle_has_no_more_points_than_can_be_handed_on() {
    let mut settings = StationSettings::default();
    settings.cycle.speed_share = 0.001;
    settings.cycle.acceleration_share = 0.001;
    let cycle = cycle(&settings, &Candidate::new(0, block(6, 20)));
    assert!(cycle.cycle_s > 60.0, "{}", cycle.cycle_s);
    let points = cycle.legs.iter().map(|leg| leg.points.len());
    let longest = points.max().unwrap();
    assert!(longest > 1_900 && longest <= MAX_POINTS, "{longest}");
}

#[test]
fn the_pose_at_the_pick_is_that_of_the_items_own_frame() {
    let turn = Isometry3::rotation(Vector3::x() * 1.2);
    let waits_at = Isometry3::translation(0.12, -0.28, 0.0) * turn;
    let candidate = Candidate {
        lying: Lying {
            heightmap_from_item: Some(turn),
            waits_at: Some(waits_at),
        },
        ..Candidate::new(0, block(6, 20))
    };
    let cycle = cycle(&StationSettings::default(), &candidate);
    let at_pick = cycle.container_from_item_at_pick;
    assert!((at_pick.translation.vector - waits_at.translation.vector).norm() < 0.02);
    assert!(at_pick.rotation.angle_to(&waits_at.rotation) < 1e-9);
}
