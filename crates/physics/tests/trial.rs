//! Placements tried in the twin of a cell, and the check that tries them.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod common;

use std::f64::consts::TAU;
use std::sync::Arc;

use common::{Content, at, ball, block, boxed, cuboid, grid, lying, placed, scene, solid_box};
use nalgebra::{Isometry3, Point3, Vector3};
use ppnpack_catalogue::object::{ConvexPiece, Model};
use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::check::{Evidence, ValidityCheck, Verdict};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::loads::LoadSettings;
use ppnpack_packing::motion::Cycle;
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::refusal::{Cause, Refusal};
use ppnpack_packing::step::StepInput;
use ppnpack_packing::trial::{Settling, TrialLimits, TrialSettings};
use ppnpack_physics::error::PhysicsError;
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::trial::{self, TrialCheck};
use ppnpack_physics::twin::{Twin, TwinSettings};

/// A box that is loaded beside its foot, so that it falls over wherever it is put.
fn falling(arrival: usize) -> Candidate {
    let (cells, height) = ([4, 4], 50);
    let mut loaded = Model::clone(&solid_box(cells, height));
    loaded.mass.centre_of_mass_m = Point3::new(0.05, 0.0, 0.0);
    boxed(arrival, Arc::new(loaded), cells, height)
}

/// Tall and thin: 3 x 3 x 10 cm.
fn tall(arrival: usize) -> Candidate {
    block(arrival, [3, 3], 50)
}

/// A block under the cells 10 to 16 along both sides, 50 units high.
fn base() -> (Arc<Model>, Isometry3<f64>) {
    (cuboid([0.06, 0.06, 0.1]), at(0.13, 0.13, 0.05))
}

fn new_check(settings: TrialSettings) -> TrialCheck {
    TrialCheck::new(settings, TwinSettings::default()).unwrap()
}

/// What a check that was not asked before says of a placement in this step.
fn verdict_of(
    settings: TrialSettings,
    input: &StepInput<'_>,
    resting: &RestingPlacement,
) -> Verdict {
    let mut check = new_check(settings);
    check.begin(input).unwrap();
    check.judge(input, &input.candidates[0], resting).unwrap()
}

/// What a check says of a placement: by what it knows of others, else by a try.
fn asked(
    check: &mut dyn ValidityCheck,
    input: &StepInput<'_>,
    held: &Candidate,
    resting: &RestingPlacement,
) -> Verdict {
    match check.refuses_unseen(input, held, resting) {
        Some(refusal) => Verdict::Refused(refusal),
        None => check.judge(input, held, resting).unwrap(),
    }
}

/// Asks about a placement that is refused; says whether it was tried for that.
fn is_refused_tried(
    check: &mut TrialCheck,
    input: &StepInput<'_>,
    held: &Candidate,
    resting: &RestingPlacement,
) -> bool {
    let before = check.tries();
    match asked(check, input, held, resting) {
        Verdict::Refused(refusal) => assert_eq!(refusal.cause, Cause::Unsteady),
        Verdict::Accepted(evidence) => panic!("accepted: {evidence:?}"),
    }
    check.tries() > before
}

fn new_twin(settings: TwinSettings, content: &Content) -> Twin {
    let mut twin = Twin::new(settings).unwrap();
    twin.lay_down(&lying(content)).unwrap();
    twin
}

/// What becomes of a model that is placed there, by the limits of the default.
fn tried(twin: &mut Twin, model: &Arc<Model>, pose: &Isometry3<f64>) -> Settling {
    tried_within(&TrialLimits::default(), twin, model, pose)
}

fn tried_within(
    limits: &TrialLimits,
    twin: &mut Twin,
    model: &Arc<Model>,
    pose: &Isometry3<f64>,
) -> Settling {
    let solid = twin.solid(model).unwrap();
    twin.try_placement(&solid, pose, limits).unwrap()
}

#[test]
fn a_flat_box_on_the_floor_is_accepted_with_what_became_of_it() {
    let grid = grid();
    let scene = scene(&grid, &[]);
    let held = [block(0, [8, 8], 20)];
    let input = StepInput::new(&grid, &scene, &held);
    let verdict = verdict_of(TrialSettings::default(), &input, &placed(10, 10, 0));
    let Verdict::Accepted(Evidence {
        settling: Some(settling),
        ..
    }) = verdict
    else {
        panic!("{verdict:?}");
    };
    assert!(settling.tilt_rad < 0.02, "{settling:?}");
    // It is let go 4.2 mm beside its place in the disturbed tries.
    assert!(settling.slide_m < 6e-3, "{settling:?}");
    assert_eq!(settling.disturbance_m, 0.0);
    assert!(settling.is_still, "{settling:?}");
}

#[test]
fn an_item_is_lowered_to_what_it_touches_but_no_farther_than_it_is_let_go_above_its_place() {
    let mut twin = new_twin(TwinSettings::default(), &[base()]);
    let cube = twin.solid(&cuboid([0.04; 3])).unwrap();
    // By where the middle of its foot is: beside the base, whose top is 0.1 m high, or over it by as little as a centimetre.
    for (x_m, foot_m, clearance_m) in [
        (0.13, 0.106, 0.006),
        (0.17, 0.106, 0.006),
        (0.19, 0.106, 0.01),
        (0.13, 0.15, 0.01),
        (0.13, 0.09, 0.0),
        (0.25, 0.004, 0.004),
        (0.25, -0.001, 0.0),
    ] {
        let lowered_m = twin.clearance_m(&cube, &at(x_m, 0.13, foot_m + 0.02));
        let is_it = (lowered_m - clearance_m).abs() < 1e-5;
        assert!(is_it, "{x_m} m, {foot_m} m: {lowered_m} m");
    }
    // What is not known lies as high as the heightmap shows it.
    let grid = grid();
    let heights = vec![40; grid.nx() * grid.ny()];
    let heightmap = Heightmap::from_units(grid.nx(), grid.ny(), heights).unwrap();
    twin.fill_up(&grid, &Scene::from_heightmap(heightmap))
        .unwrap();
    let lowered_m = twin.clearance_m(&cube, &at(0.25, 0.13, 0.083 + 0.02));
    assert!((lowered_m - 0.003).abs() < 1e-5, "{lowered_m} m");
}

#[test]
fn a_placement_is_made_where_its_item_touches_unless_an_arm_ends_at_its_place() {
    let grid = grid();
    let scene = scene(&grid, &[]);
    let held = [block(0, [8, 8], 20)];
    let input = StepInput::new(&grid, &scene, &held);
    let verdict = verdict_of(TrialSettings::default(), &input, &placed(10, 10, 3));
    let Verdict::Accepted(mut evidence) = verdict else {
        panic!("{verdict:?}");
    };
    assert!((evidence.lowered_m - 0.006).abs() < 1e-5, "{evidence:?}");
    let pose = at(0.1, 0.1, 0.05);
    let below = at(0.1, 0.1, 0.05 - evidence.lowered_m);
    assert_eq!(evidence.lower(pose), below);
    evidence.cycle = Some(Arc::new(Cycle {
        arm: "arm".to_owned(),
        cycle_s: 1.0,
        container_from_item_at_pick: Isometry3::identity(),
        grasp_yaw_rad: 0.0,
        grip_s: 0.0,
        release_s: 0.0,
        legs: Vec::new(),
    }));
    assert_eq!(evidence.lower(pose), pose);
}

#[test]
fn a_tall_item_that_stands_mostly_over_an_edge_is_refused_as_it_would_topple() {
    let grid = grid();
    let scene = scene(&grid, &[base()]);
    let held = [tall(0)];
    let input = StepInput::new(&grid, &scene, &held);
    let settings = TrialSettings {
        // It tilts whatever else it does.
        limits: TrialLimits {
            slide_m: 0.5,
            disturbance_m: 0.5,
            ..TrialLimits::default()
        },
        ..TrialSettings::default()
    };
    let over_the_edge = verdict_of(settings, &input, &placed(15, 11, 50));
    let expected = Refusal::because(Cause::Unsteady, "it would topple");
    assert_eq!(over_the_edge, Verdict::Refused(expected));
    let on_top = verdict_of(settings, &input, &placed(11, 11, 50));
    assert!(on_top.is_accepted(), "{on_top:?}");
}

#[test]
fn an_item_has_so_many_tries_in_all_its_poses_together() {
    let grid = grid();
    let scene = scene(&grid, &[]);
    let other_pose = Candidate {
        pose: 1,
        ..falling(0)
    };
    let held = [falling(0), other_pose, block(1, [8, 8], 20)];
    let [item, other_pose, other] = &held;
    let input = StepInput::new(&grid, &scene, &held);
    let mut check = new_check(TrialSettings {
        tries_per_item: 2,
        neighbour_m: 0.0,
        ..TrialSettings::default()
    });
    check.begin(&input).unwrap();
    let mut asked = |held: &Candidate, x: usize| {
        let is_tried = is_refused_tried(&mut check, &input, held, &placed(x, 10, 0));
        (is_tried, check.is_done_with(held))
    };
    assert_eq!(asked(item, 2), (true, false));
    assert_eq!(asked(other_pose, 8), (true, true));
    assert_eq!(asked(item, 14), (false, true));
    // What is accepted was tried too.
    for (x, is_last) in [(2, false), (10, true)] {
        let verdict = check.judge(&input, other, &placed(x, 10, 0)).unwrap();
        assert!(verdict.is_accepted(), "{verdict:?}");
        assert_eq!(check.is_done_with(other), is_last);
    }
}

#[test]
fn neighbours_of_a_refused_placement_are_refused_unasked() {
    let grid = grid();
    let scene = scene(&grid, &[]);
    let held = [falling(0), falling(1)];
    let [item, other] = &held;
    let input = StepInput::new(&grid, &scene, &held);
    let mut check = new_check(TrialSettings {
        tries_per_item: 3,
        // A cell.
        neighbour_m: 0.01,
        ..TrialSettings::default()
    });
    check.begin(&input).unwrap();
    let mut asked = |held: &Candidate, resting: &RestingPlacement| {
        let is_tried = is_refused_tried(&mut check, &input, held, resting);
        (is_tried, check.is_done_with(held))
    };
    assert_eq!(asked(item, &placed(10, 10, 0)), (true, false));
    for x in 9..=11 {
        for y in 9..=11 {
            assert_eq!(asked(item, &placed(x, y, 0)), (false, false), "at {x}, {y}");
        }
    }
    assert_eq!(asked(other, &placed(11, 10, 0)), (true, false));
    let turned = RestingPlacement {
        placement: Placement {
            yaw: 1,
            x: 10,
            y: 10,
        },
        resting_height: 0,
    };
    assert_eq!(asked(item, &turned), (true, false));
    assert_eq!(asked(item, &placed(12, 10, 0)), (true, true));
}

#[test]
fn a_widened_search_tries_again_what_it_was_done_with_and_farther_away() {
    let grid = grid();
    let scene = scene(&grid, &[]);
    let held = [falling(0)];
    let input = StepInput::new(&grid, &scene, &held);
    let mut check = new_check(TrialSettings {
        tries_per_item: 1,
        ..TrialSettings::default()
    });
    check.begin(&input).unwrap();
    assert!(!check.widen(), "nothing was tried yet");
    let is_tried =
        |check: &mut TrialCheck, x| is_refused_tried(check, &input, &held[0], &placed(x, 10, 0));
    assert!(is_tried(&mut check, 10));
    assert!(check.is_done_with(&held[0]));
    assert!(check.widen());
    assert!(!check.is_done_with(&held[0]));
    // Cells of a centimetre: neighbours are 2 cm away now, and not 5 mm.
    assert!(!is_tried(&mut check, 12));
    assert!(is_tried(&mut check, 13));
    check.begin(&input).unwrap();
    assert!(is_tried(&mut check, 12));
}

#[test]
fn a_search_is_not_widened_for_what_has_a_last_resort() {
    let grid = grid();
    let scene = scene(&grid, &[]);
    let held = [roller(0)];
    let input = StepInput::new(&grid, &scene, &held);
    let mut check = new_check(TrialSettings {
        tries_per_item: 4,
        ..rolling_within(0.0)
    });
    check.begin(&input).unwrap();
    let there = placed(10, 10, 0);
    assert!(is_refused_tried(&mut check, &input, &held[0], &there));
    assert!(check.last_resort().is_some());
    assert!(check.is_done_with(&held[0]), "a fourth of the tries");
    assert!(!check.widen());
}

/// Placements on the floor and on the base of the items of [`held`], by increasing x: some stay, some fall, some are
/// neighbours of others.
fn placements() -> Vec<(usize, RestingPlacement)> {
    let on_floor = [2, 3, 11, 20].map(|x| placed(x, 2, 0));
    let on_base = [8, 11, 12, 14, 15].map(|x| placed(x, 11, 50));
    let all = on_floor.into_iter().chain(on_base);
    all.flat_map(|resting| (0..4).map(move |held| (held, resting)))
        .collect()
}

fn held() -> [Candidate; 4] {
    [falling(0), block(1, [5, 4], 15), tall(2), roller(3)]
}

/// What a check says of the placements in a step, told of as many at once as it wants to know.
fn verdicts(check: &mut dyn ValidityCheck, input: &StepInput<'_>) -> Vec<Verdict> {
    check.begin(input).unwrap();
    let mut verdicts = Vec::new();
    for chunk in placements().chunks(check.foresight()) {
        let next = chunk
            .iter()
            .map(|(index, resting)| (&input.candidates[*index], *resting));
        let next: Vec<_> = next.collect();
        check.foresee(input, &next).unwrap();
        for (candidate, resting) in next {
            verdicts.push(asked(check, input, candidate, &resting));
        }
    }
    verdicts
}

fn with_last_resort() -> TrialSettings {
    TrialSettings {
        tries_per_item: 6,
        ..rolling_within(0.0)
    }
}

#[test]
fn answers_are_the_same_with_any_number_of_threads() {
    let grid = grid();
    let scene = scene(&grid, &[base()]);
    let held = held();
    let input = StepInput::new(&grid, &scene, &held);
    let of_threads = |threads: usize| {
        let pool = trial::pool(threads).unwrap();
        let made = trial::check(
            with_last_resort(),
            &LoadSettings::default(),
            TwinSettings::default(),
            pool,
        );
        let mut check = made.unwrap().unwrap();
        assert_eq!(check.foresight(), threads);
        let verdicts = verdicts(&mut *check, &input);
        let done: Vec<bool> = held.iter().map(|held| check.is_done_with(held)).collect();
        (verdicts, done, check.last_resort())
    };
    let expected = of_threads(1);
    assert!(expected.0.iter().any(Verdict::is_accepted));
    assert!(!expected.0.iter().all(Verdict::is_accepted));
    assert!(expected.2.is_some());
    assert_eq!(of_threads(4), expected);
}

#[test]
fn a_step_is_judged_as_if_there_had_been_none_before() {
    let grid = grid();
    let (with_base, without) = (scene(&grid, &[base()]), scene(&grid, &[]));
    let held = held();
    let input = StepInput::new(&grid, &with_base, &held);
    let other = StepInput::new(&grid, &without, &held);
    let mut check = new_check(with_last_resort());
    let first = verdicts(&mut check, &input);
    let resort = check.last_resort();
    assert_ne!(verdicts(&mut check, &other), first);
    assert_eq!(verdicts(&mut check, &input), first);
    assert_eq!(check.last_resort(), resort);
    check.begin(&input).unwrap();
    assert_eq!(check.last_resort(), None);
    assert!(!held.iter().any(|held| check.is_done_with(held)));
}

#[test]
fn what_is_kept_of_earlier_steps_is_what_a_try_would_say_now() {
    let grid = grid();
    let held = held();
    let far = (cuboid([0.04, 0.04, 0.04]), at(0.29, 0.29, 0.02));
    let beside = (cuboid([0.04, 0.04, 0.1]), at(0.185, 0.13, 0.05));
    let (model, _) = base();
    let moved = (model, at(0.135, 0.13, 0.05));
    let contents: [&Content; 6] = [
        &[base()],
        &[base(), far.clone()],
        &[base(), far.clone(), beside.clone()],
        &[moved, far.clone(), beside],
        &[far],
        &[],
    ];
    let mut check = new_check(TrialSettings::default());
    for content in contents {
        let scene = scene(&grid, content);
        let input = StepInput::new(&grid, &scene, &held);
        let fresh = verdicts(&mut new_check(TrialSettings::default()), &input);
        assert_eq!(verdicts(&mut check, &input), fresh);
    }
}

#[test]
fn where_the_content_is_not_known_nothing_is_tried() {
    let grid = grid();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let held = held();
    let input = StepInput::new(&grid, &scene, &held);
    for threads in [1, 2] {
        let pool = trial::pool(threads).unwrap();
        let made = trial::check(
            with_last_resort(),
            &LoadSettings::default(),
            TwinSettings::default(),
            pool,
        );
        let mut check = made.unwrap().unwrap();
        let without_evidence = Verdict::Accepted(Evidence::default());
        let verdicts = verdicts(&mut *check, &input);
        assert!(verdicts.iter().all(|verdict| *verdict == without_evidence));
        assert!(!held.iter().any(|held| check.is_done_with(held)));
        assert_eq!(check.last_resort(), None);
    }
}

#[test]
fn a_method_that_tries_nothing_has_no_check() {
    let twin = TwinSettings::default;
    let check = trial::check(TrialSettings::off(), &LoadSettings::default(), twin(), None).unwrap();
    assert!(check.is_none());
    let mut impossible = TrialSettings::default();
    impossible.limits.slide_m = f64::NAN;
    assert!(matches!(
        trial::check(impossible, &LoadSettings::default(), twin(), None),
        Err(PhysicsError::Setting(_))
    ));
    assert!(trial::pool(1).unwrap().is_none());
}

#[test]
fn bodies_far_from_the_place_make_no_difference() {
    let (model, pose) = (cuboid([0.05, 0.05, 0.04]), at(0.15, 0.13, 0.12));
    let mut among_few = new_twin(TwinSettings::default(), &[base()]);
    let far = [
        (cuboid([0.05; 3]), at(0.26, 0.26, 0.025)),
        (ball(0.03), at(0.05, 0.28, 0.03)),
    ];
    let [first, last] = far;
    let mut among_many = new_twin(TwinSettings::default(), &[first, base(), last]);
    let expected = tried(&mut among_few, &model, &pose);
    assert!(expected.disturbance_m > 0.0, "it lands on what lies there");
    assert_eq!(tried(&mut among_many, &model, &pose), expected);
}

#[test]
fn a_body_out_of_reach_stays_fixed() {
    // A block on a plate that nothing bears: where the plate can move, all falls.
    let content = [
        (cuboid([0.1, 0.1, 0.02]), at(0.16, 0.16, 0.11)),
        (cuboid([0.06, 0.06, 0.05]), at(0.16, 0.16, 0.145)),
    ];
    let (model, pose) = (cuboid([0.04; 3]), at(0.16, 0.16, 0.19));
    let limits = TrialLimits::default();
    let mut near = new_twin(TwinSettings::default(), &content);
    let settling = tried(&mut near, &model, &pose);
    assert_eq!(settling.beyond(&limits), None, "{settling:?}");
    assert!(settling.disturbance_m < 5e-3, "{settling:?}");
    let settings = TwinSettings {
        reach_m: 0.1,
        ..TwinSettings::default()
    };
    let mut far = new_twin(settings, &content);
    let settling = tried(&mut far, &model, &pose);
    let why = Some("it would move what lies there");
    assert_eq!(settling.beyond(&limits), why, "{settling:?}");
}

#[test]
fn what_cannot_be_laid_down_or_tried_is_an_error_and_changes_nothing() {
    // Over the base's edge: without the base it would lie on the floor.
    let (model, pose) = (cuboid([0.03, 0.03, 0.1]), at(0.165, 0.13, 0.15));
    let mut twin = new_twin(TwinSettings::default(), &[base()]);
    let before = tried(&mut twin, &model, &pose);
    assert!(before.beyond(&TrialLimits::default()).is_some());
    let fine = (cuboid([0.05; 3]), at(0.25, 0.25, 0.025));
    let nowhere = (cuboid([0.05; 3]), at(0.1, f64::NAN, 0.1));
    let refused = twin.lay_down(&lying(&[fine.clone(), nowhere]));
    assert!(matches!(refused, Err(PhysicsError::Pose { .. })));
    let mut hollow = Model::clone(&fine.0);
    hollow.pieces.clear();
    let refused = twin.lay_down(&lying(&[fine.clone(), (Arc::new(hollow), fine.1)]));
    assert!(matches!(refused, Err(PhysicsError::Model { .. })));
    let solid = twin.solid(&model).unwrap();
    let far_away = at(0.1, 0.1, 1e30);
    let refused = twin.try_placement(&solid, &far_away, &TrialLimits::default());
    assert!(matches!(refused, Err(PhysicsError::Pose { .. })));
    assert_eq!(tried(&mut twin, &model, &pose), before);
}

#[test]
fn impossible_settings_of_the_twin_are_named() {
    TwinSettings::default().validate().unwrap();
    let refused = |change: fn(&mut TwinSettings)| {
        let mut settings = TwinSettings::default();
        change(&mut settings);
        let error = settings.validate().unwrap_err();
        let refused = Twin::new(settings).err();
        assert_eq!(refused, Some(PhysicsError::Setting(error.clone())));
        error.to_string()
    };
    assert!(refused(|s| s.cell.container.x_m = -0.3).contains("x side"));
    assert!(refused(|s| s.rough.timestep_s = 0.0).contains("time step"));
    assert!(refused(|s| s.rough.substeps = 0).contains("substeps"));
    assert!(refused(|s| s.rough.settle_time_s = 0.0).contains("settling phase"));
    assert!(refused(|s| s.disturbance.friction = 0.0).contains("friction"));
    assert!(refused(|s| s.disturbance.shift_m = 0.2).contains("shift"));
    assert!(refused(|s| s.disturbance.yaw_rad = -0.1).contains("turn"));
    assert!(refused(|s| s.reach_m = f64::INFINITY).contains("reach"));
    assert!(refused(|s| s.still_speed_m_s = 2.0).contains("speed of rest"));
}

#[test]
fn the_twin_of_a_cell_makes_no_errors_but_its_own_and_ends_soon() {
    let mut cell = CellSettings {
        settle_time_s: 5.0,
        ..CellSettings::robot()
    };
    cell.release.jitter_m = 0.01;
    cell.release.jitter_yaw_rad = 0.1;
    let twin = TwinSettings::of(&cell).cell;
    assert_eq!(
        (twin.release.jitter_m, twin.release.jitter_yaw_rad),
        (0.0, 0.0)
    );
    assert_eq!(twin.release.height_m, cell.release.height_m);
    assert!(twin.settle_time_s <= 1.0);
}

#[test]
fn settings_left_out_take_their_defaults_and_unknown_ones_are_refused() {
    let settings: TrialSettings =
        serde_json::from_str(r#"{"limits": {"slide_m": 0.01}, "tries_per_item": 7}"#).unwrap();
    let expected = TrialSettings {
        limits: TrialLimits {
            slide_m: 0.01,
            ..TrialLimits::default()
        },
        tries_per_item: 7,
        ..TrialSettings::default()
    };
    assert_eq!(settings, expected);
    let written = serde_json::to_string(&settings).unwrap();
    assert_eq!(
        serde_json::from_str::<TrialSettings>(&written).unwrap(),
        settings
    );
    for unknown in [r#"{"tries": 3}"#, r#"{"limits": {"tilt": 0.1}}"#] {
        assert!(serde_json::from_str::<TrialSettings>(unknown).is_err());
    }
    let twin: TwinSettings =
        serde_json::from_str(r#"{"rough": {"substeps": 3}, "reach_m": 0.02}"#).unwrap();
    assert_eq!((twin.rough.substeps, twin.reach_m), (3, 0.02));
    assert_eq!(twin.disturbance, TwinSettings::default().disturbance);
    let written = serde_json::to_string(&twin).unwrap();
    assert_eq!(
        serde_json::from_str::<TwinSettings>(&written).unwrap(),
        twin
    );
    for unknown in [r#"{"reach": 0.02}"#, r#"{"disturbance": {"shift": 0.1}}"#] {
        assert!(serde_json::from_str::<TwinSettings>(unknown).is_err());
    }
}

/// A tower under the cells 10 to 20 along both sides, this high.
fn tower(height_m: f64) -> (Arc<Model>, Isometry3<f64>) {
    (cuboid([0.1, 0.1, height_m]), at(0.15, 0.15, height_m / 2.0))
}

#[test]
fn what_reaches_above_the_rim_is_made_where_it_sinks_below_it() {
    let grid = grid();
    let held = [block(0, [6, 6], 20)];
    // 1 cm above the rim of 30 cm, as planned.
    let planned = placed(12, 12, 135);
    for (tower_m, is_accepted) in [(0.255, true), (0.265, false)] {
        let scene = scene(&grid, &[tower(tower_m)]);
        let input = StepInput::new(&grid, &scene, &held);
        let verdict = verdict_of(TrialSettings::default(), &input, &planned);
        match verdict {
            Verdict::Accepted(evidence) => {
                assert!(is_accepted);
                assert!(evidence.settling.unwrap().above_rim_m < 0.001);
            }
            Verdict::Refused(refusal) => {
                let why = Refusal::because(Cause::Unsteady, "it would stick out above the rim");
                assert_eq!(refusal, why);
                assert!(!is_accepted);
            }
        }
    }
}

/// A plank on a pillar, its middle so high, and a lower pillar 8 mm under its left end.
fn seesaw(plank_m: f64) -> [(Arc<Model>, Isometry3<f64>); 3] {
    let pillar = |x_m: f64, height_m: f64| {
        let model = cuboid([0.02, 0.06, height_m]);
        (model, at(x_m, 0.16, height_m / 2.0))
    };
    let plank = (cuboid([0.2, 0.03, 0.006]), at(0.16, 0.16, plank_m));
    [
        pillar(0.16, plank_m - 0.003),
        pillar(0.07, plank_m - 0.011),
        plank,
    ]
}

#[test]
fn what_lifts_another_item_above_the_rim_sticks_out_itself() {
    let item = cuboid([0.03, 0.03, 0.008]);
    for (plank_m, is_above) in [(0.292, true), (0.26, false)] {
        let mut twin = new_twin(TwinSettings::default(), &seesaw(plank_m));
        let on_the_left = at(0.08, 0.16, plank_m + 0.007);
        let settling = tried(&mut twin, &item, &on_the_left);
        assert!(settling.tilt_rad > 0.05, "the plank tips: {settling:?}");
        assert_eq!(settling.above_rim_m > 0.002, is_above, "{settling:?}");
        let why = settling.beyond(&TrialLimits::default());
        assert_eq!(why, is_above.then_some("it would stick out above the rim"));
    }
}

#[test]
fn what_cannot_be_tried_may_not_reach_above_the_rim() {
    let grid = grid();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let held = [block(0, [6, 6], 20)];
    let input = StepInput::new(&grid, &scene, &held);
    let of = |height| verdict_of(TrialSettings::default(), &input, &placed(12, 12, height));
    assert_eq!(of(130), Verdict::Accepted(Evidence::default()));
    assert_eq!(of(131), Verdict::Refused(Cause::AboveRim.into()));
}

/// A lying prism of sixteen sides, 4 cm across and 4 cm long.
fn roller(arrival: usize) -> Candidate {
    let (cells, height) = ([4, 4], 20);
    let mut model = Model::clone(&solid_box(cells, height));
    let centre = model.mass.centre_of_mass_m;
    let corner = |side: usize, end: f64| {
        let (sin, cos) = (TAU * (side as f64 + 0.5) / 16.0).sin_cos();
        centre + Vector3::new(0.02 * end, 0.02 * cos, 0.02 * sin)
    };
    let vertices = (0..16).flat_map(|side| [corner(side, -1.0), corner(side, 1.0)]);
    model.pieces = vec![ConvexPiece {
        vertices: vertices.collect(),
    }];
    boxed(arrival, Arc::new(model), cells, height)
}

fn rolling_within(rolling_tilt_rad: f64) -> TrialSettings {
    TrialSettings {
        limits: TrialLimits {
            rolling_tilt_rad,
            ..TrialLimits::default()
        },
        ..TrialSettings::default()
    }
}

#[test]
fn what_rolls_is_placed_where_it_tilts_beyond_its_own_limit_only_as_the_last_resort() {
    let grid = grid();
    let scene = scene(&grid, &[]);
    let held = [roller(0), block(1, [4, 4], 20)];
    let input = StepInput::new(&grid, &scene, &held);
    let (there, beside) = (placed(10, 10, 0), placed(20, 10, 0));
    let usual = verdict_of(rolling_within(0.14), &input, &there);
    assert!(usual.is_accepted(), "{usual:?}");

    let mut check = new_check(rolling_within(0.0));
    check.begin(&input).unwrap();
    let refused = check.judge(&input, &held[0], &there).unwrap();
    let expected = Refusal::because(Cause::Unsteady, "it would topple");
    assert_eq!(refused, Verdict::Refused(expected));
    let other = check.judge(&input, &held[1], &beside).unwrap();
    assert!(other.is_accepted(), "{other:?}");
    let resort = check.last_resort().unwrap();
    assert_eq!((resort.arrival, resort.resting), (0, there));
}

#[test]
fn the_last_resort_is_where_what_rolls_tilts_least_and_nothing_beyond_the_limits_of_all() {
    let grid = grid();
    let scene = scene(&grid, &[base()]);
    let held = [roller(0), falling(1)];
    let input = StepInput::new(&grid, &scene, &held);
    let settings = TrialSettings {
        neighbour_m: 0.0,
        ..rolling_within(0.0)
    };
    let mut check = new_check(settings);
    check.begin(&input).unwrap();
    assert!(is_refused_tried(
        &mut check,
        &input,
        &held[1],
        &placed(2, 2, 0)
    ));
    assert_eq!(check.last_resort(), None);
    let mut twin = new_twin(TwinSettings::default(), &[base()]);
    let mut refused = Vec::new();
    for resting in [
        placed(2, 20, 0),
        placed(11, 11, 50),
        placed(15, 11, 50),
        placed(25, 2, 0),
    ] {
        assert!(is_refused_tried(&mut check, &input, &held[0], &resting));
        let pose = held[0].item.container_from_item(&grid, &resting);
        let model = held[0].model.as_ref().unwrap();
        let settling = tried(&mut twin, model, &pose.unwrap());
        refused.push((resting, settling));
    }
    let severity = |settling: &Settling| settling.severity(&settings.limits.of_rolling());
    let least = refused
        .into_iter()
        .filter(|(_, settling)| settling.beyond(&settings.limits).is_none())
        .min_by(|(_, a), (_, b)| severity(a).total_cmp(&severity(b)));
    let (resting, settling) = least.unwrap();
    let resort = check.last_resort().unwrap();
    assert_eq!((resort.arrival, resort.resting), (0, resting));
    assert_eq!(resort.evidence.settling, Some(settling));
}
