//! The check that tries placements in the twin of a cell.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use ppnpack_catalogue::object::{ConvexPiece, Model};
use ppnpack_packing::checks::check::{BoxedCheck, Evidence, ValidityCheck, Verdict};
use ppnpack_packing::checks::loads::LoadSettings;
use ppnpack_packing::checks::motion::Cycle;
use ppnpack_packing::checks::trial::{TrialLimits, TrialSettings};
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use ppnpack_packing::ranking::refusal::{Cause, Refusal};
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_physics::error::PhysicsError;
use ppnpack_physics::trial::{self, TrialCheck};
use ppnpack_physics::twin::TwinSettings;

use crate::common::{Step, at, block, boxed, cuboid, lying, placed, solid_box};
use crate::twin::{base, new_twin, tried};

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
    let vertices = vertices.collect();
    model.pieces = vec![ConvexPiece { vertices }];
    boxed(arrival, Arc::new(model), cells, height)
}

/// The default, but for this.
fn settings(change: impl FnOnce(&mut TrialSettings)) -> TrialSettings {
    let mut settings = TrialSettings::default();
    change(&mut settings);
    settings
}

fn new_check(settings: TrialSettings) -> TrialCheck {
    TrialCheck::new(settings, TwinSettings::default()).unwrap()
}

/// A check that tries on so many threads.
fn threaded(settings: TrialSettings, threads: usize) -> BoxedCheck {
    let (loads, twin) = (LoadSettings::default(), TwinSettings::default());
    let pool = trial::pool(threads).unwrap();
    trial::check(settings, &loads, twin, pool).unwrap().unwrap()
}

/// What a check that was not asked before says of a placement of what is held.
fn verdict_of(settings: TrialSettings, step: &Step, resting: &RestingPlacement) -> Verdict {
    let mut check = new_check(settings);
    check.begin(&step.input()).unwrap();
    let verdict = check.judge(&step.input(), &step.held[0], resting);
    verdict.unwrap()
}

fn accepted(verdict: Verdict) -> Evidence {
    match verdict {
        Verdict::Accepted(evidence) => evidence,
        Verdict::Refused(refusal) => panic!("{refusal:?}"),
    }
}

fn refused_as(why: &'static str) -> Verdict {
    Verdict::Refused(Refusal::because(Cause::Unsteady, why))
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
    step: &Step,
    held: usize,
    resting: &RestingPlacement,
) -> bool {
    let before = check.tries();
    match asked(check, &step.input(), &step.held[held], resting) {
        Verdict::Refused(refusal) => assert_eq!(refusal.cause, Cause::Unsteady),
        Verdict::Accepted(evidence) => panic!("accepted: {evidence:?}"),
    }
    check.tries() > before
}

#[test]
fn a_flat_box_on_the_floor_is_accepted_with_what_became_of_it() {
    let step = Step::new(Vec::new(), [block(0, [8, 8], 20)]);
    let verdict = verdict_of(TrialSettings::default(), &step, &placed(10, 10, 0));
    let settling = accepted(verdict).settling.unwrap();
    assert!(settling.tilt_rad < 0.02, "{settling:?}");
    // It is let go 4.2 mm beside its place in the disturbed tries.
    assert!(settling.slide_m < 6e-3, "{settling:?}");
    assert_eq!(settling.disturbance_m, 0.0);
    assert!(settling.is_still, "{settling:?}");
}

#[test]
fn a_placement_is_made_where_its_item_touches_unless_an_arm_ends_at_its_place() {
    let step = Step::new(Vec::new(), [block(0, [8, 8], 20)]);
    let verdict = verdict_of(TrialSettings::default(), &step, &placed(10, 10, 3));
    let mut evidence = accepted(verdict);
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
    let step = Step::new(lying(&[base()]), [tall(0)]);
    // It tilts whatever else it does.
    let settings = settings(|settings| {
        settings.limits.slide_m = 0.5;
        settings.limits.disturbance_m = 0.5;
    });
    let over_the_edge = verdict_of(settings, &step, &placed(15, 11, 50));
    assert_eq!(over_the_edge, refused_as("it would topple"));
    accepted(verdict_of(settings, &step, &placed(11, 11, 50)));
}

#[test]
fn an_item_has_so_many_tries_in_all_its_poses_together() {
    let other_pose = Candidate {
        pose: 1,
        ..falling(0)
    };
    let held = [falling(0), other_pose, block(1, [8, 8], 20)];
    let step = Step::new(Vec::new(), held);
    let mut check = new_check(settings(|settings| {
        settings.tries_per_item = 2;
        settings.neighbour_m = 0.0;
    }));
    check.begin(&step.input()).unwrap();
    for (held, x, expected) in [
        (0, 2, (true, false)),
        (1, 8, (true, true)),
        (0, 14, (false, true)),
    ] {
        let is_tried = is_refused_tried(&mut check, &step, held, &placed(x, 10, 0));
        let found = (is_tried, check.is_done_with(&step.held[held]));
        assert_eq!(found, expected, "{held} at {x}");
    }
    // What is accepted was tried too.
    check.begin(&step.input()).unwrap();
    for (x, is_last) in [(2, false), (10, true)] {
        let verdict = check.judge(&step.input(), &step.held[2], &placed(x, 10, 0));
        accepted(verdict.unwrap());
        assert_eq!(check.is_done_with(&step.held[2]), is_last);
    }
}

#[test]
fn a_step_has_half_as_many_tries_again_as_an_item() {
    let step = Step::new(Vec::new(), [falling(0), falling(1), falling(2)]);
    let mut check = new_check(settings(|settings| {
        settings.tries_per_item = 2;
        settings.neighbour_m = 0.0;
    }));
    check.begin(&step.input()).unwrap();
    for (held, x) in [(0, 2), (0, 8), (1, 2)] {
        assert!(is_refused_tried(&mut check, &step, held, &placed(x, 10, 0)));
    }
    let untried = check.refuses_unseen(&step.input(), &step.held[2], &placed(2, 10, 0));
    let untried = untried.map(Verdict::Refused);
    assert_eq!(
        untried,
        Some(refused_as("other items took the tries of this step"))
    );
    assert!(step.held.iter().all(|held| check.is_done_with(held)));
}

#[test]
fn neighbours_of_a_refused_placement_are_refused_unasked() {
    let step = Step::new(Vec::new(), [falling(0), falling(1)]);
    let mut check = new_check(settings(|settings| {
        settings.tries_per_item = 3;
        // A cell.
        settings.neighbour_m = 0.01;
    }));
    check.begin(&step.input()).unwrap();
    let mut asked = |held: usize, resting: &RestingPlacement| {
        let is_tried = is_refused_tried(&mut check, &step, held, resting);
        (is_tried, check.is_done_with(&step.held[held]))
    };
    assert_eq!(asked(0, &placed(10, 10, 0)), (true, false));
    for (x, y) in (9..=11).flat_map(|x| (9..=11).map(move |y| (x, y))) {
        assert_eq!(asked(0, &placed(x, y, 0)), (false, false), "at {x}, {y}");
    }
    assert_eq!(asked(1, &placed(11, 10, 0)), (true, false));
    let (x, y) = (10, 10);
    let turned = RestingPlacement {
        placement: Placement { yaw: 1, x, y },
        resting_height: 0,
    };
    assert_eq!(asked(0, &turned), (true, false));
    assert_eq!(asked(0, &placed(12, 10, 0)), (true, true));
}

#[test]
fn a_widened_search_tries_again_what_it_was_done_with() {
    let step = Step::new(Vec::new(), [falling(0)]);
    let mut check = new_check(settings(|settings| settings.tries_per_item = 1));
    check.begin(&step.input()).unwrap();
    assert!(is_refused_tried(&mut check, &step, 0, &placed(10, 10, 0)));
    assert!(check.is_done_with(&step.held[0]));
    check.widen();
    assert!(!check.is_done_with(&step.held[0]));
}

/// As by default, where what rolls may not tilt by more than this, with so many tries.
fn rolling_within(rolling_tilt_rad: f64, tries_per_item: usize) -> TrialSettings {
    settings(|settings| {
        settings.limits.rolling_tilt_rad = rolling_tilt_rad;
        settings.tries_per_item = tries_per_item;
    })
}

#[test]
fn what_has_a_last_resort_is_tried_less_often() {
    let step = Step::new(Vec::new(), [roller(0)]);
    let mut check = new_check(rolling_within(0.0, 4));
    check.begin(&step.input()).unwrap();
    let there = placed(10, 10, 0);
    assert!(is_refused_tried(&mut check, &step, 0, &there));
    assert!(check.last_resort().is_some());
    assert!(check.is_done_with(&step.held[0]), "a fourth of the tries");
}

/// Placements on the floor and on the base of the items of [`held`], by increasing x: some stay,
/// some fall, some are neighbours of others.
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
fn verdicts(check: &mut dyn ValidityCheck, step: &Step) -> Vec<Verdict> {
    let input = step.input();
    check.begin(&input).unwrap();
    let mut verdicts = Vec::new();
    for chunk in placements().chunks(check.foresight()) {
        let next = chunk.iter();
        let next = next.map(|(index, resting)| (&step.held[*index], *resting));
        let next: Vec<_> = next.collect();
        check.foresee(&input, &next).unwrap();
        let asked = |(candidate, resting)| asked(check, &input, candidate, &resting);
        verdicts.extend(next.into_iter().map(asked));
    }
    verdicts
}

#[test]
fn answers_are_the_same_with_any_number_of_threads() {
    let step = Step::new(lying(&[base()]), held());
    let of_threads = |threads: usize| {
        let mut check = threaded(rolling_within(0.0, 6), threads);
        assert_eq!(check.foresight(), threads);
        let verdicts = verdicts(&mut *check, &step);
        let done = step.held.iter().map(|held| check.is_done_with(held));
        (verdicts, done.collect::<Vec<_>>(), check.last_resort())
    };
    let expected = of_threads(1);
    assert!(expected.0.iter().any(Verdict::is_accepted));
    assert!(!expected.0.iter().all(Verdict::is_accepted));
    assert!(expected.2.is_some());
    assert_eq!(of_threads(4), expected);
}

#[test]
fn a_step_is_judged_as_if_there_had_been_none_before() {
    let step = Step::new(lying(&[base()]), held());
    let other = Step::new(Vec::new(), held());
    let mut check = new_check(rolling_within(0.0, 16));
    let first = verdicts(&mut check, &step);
    let resort = check.last_resort();
    assert_ne!(verdicts(&mut check, &other), first);
    assert_eq!(verdicts(&mut check, &step), first);
    assert_eq!(check.last_resort(), resort);
    check.begin(&step.input()).unwrap();
    assert_eq!(check.last_resort(), None);
    assert!(!step.held.iter().any(|held| check.is_done_with(held)));
}

#[test]
fn what_is_kept_of_earlier_steps_is_what_a_try_would_say_now() {
    let far = (cuboid([0.04, 0.04, 0.04]), at(0.29, 0.29, 0.02));
    let beside = (cuboid([0.04, 0.04, 0.1]), at(0.185, 0.13, 0.05));
    let moved = (base().0, at(0.135, 0.13, 0.05));
    let mut check = new_check(TrialSettings::default());
    for content in [
        vec![base()],
        vec![base(), far.clone()],
        vec![base(), far.clone(), beside.clone()],
        vec![moved, far.clone(), beside],
        vec![far],
        vec![],
    ] {
        let step = Step::new(lying(&content), held());
        let fresh = verdicts(&mut new_check(TrialSettings::default()), &step);
        assert_eq!(verdicts(&mut check, &step), fresh);
    }
}

#[test]
fn where_the_content_is_not_known_nothing_is_tried() {
    let step = Step::unknown(held());
    for threads in [1, 2] {
        let mut check = threaded(rolling_within(0.0, 6), threads);
        let without_evidence = Verdict::Accepted(Evidence::default());
        let verdicts = verdicts(&mut *check, &step);
        assert!(verdicts.iter().all(|verdict| *verdict == without_evidence));
        assert!(!step.held.iter().any(|held| check.is_done_with(held)));
        assert_eq!(check.last_resort(), None);
    }
}

#[test]
fn a_method_that_tries_nothing_has_no_check() {
    let (loads, twin) = (LoadSettings::default(), TwinSettings::default());
    let check = |settings| trial::check(settings, &loads, twin.clone(), None);
    assert!(check(TrialSettings::off()).unwrap().is_none());
    let impossible = settings(|settings| settings.limits.slide_m = f64::NAN);
    assert!(matches!(check(impossible), Err(PhysicsError::Setting(_))));
    assert!(trial::pool(1).unwrap().is_none());
}

#[test]
fn what_reaches_above_the_rim_is_made_where_it_sinks_below_it() {
    for (tower_m, is_accepted) in [(0.255, true), (0.265, false)] {
        // Under the cells 10 to 20 along both sides; the item is 1 cm above the rim of 30 cm, as
        // planned.
        let tower = (cuboid([0.1, 0.1, tower_m]), at(0.15, 0.15, tower_m / 2.0));
        let step = Step::new(lying(&[tower]), [block(0, [6, 6], 20)]);
        let verdict = verdict_of(TrialSettings::default(), &step, &placed(12, 12, 135));
        if is_accepted {
            assert!(accepted(verdict).settling.unwrap().above_rim_m < 0.001);
        } else {
            assert_eq!(verdict, refused_as("it would stick out above the rim"));
        }
    }
}

#[test]
fn what_cannot_be_tried_may_not_reach_above_the_rim() {
    let step = Step::unknown([block(0, [6, 6], 20)]);
    let of = |height| verdict_of(TrialSettings::default(), &step, &placed(12, 12, height));
    assert_eq!(of(130), Verdict::Accepted(Evidence::default()));
    assert_eq!(of(131), Verdict::Refused(Cause::AboveRim.into()));
}

#[test]
fn what_rolls_is_placed_where_it_tilts_beyond_its_own_limit_only_as_the_last_resort() {
    let step = Step::new(Vec::new(), [roller(0), block(1, [4, 4], 20)]);
    let (there, beside) = (placed(10, 10, 0), placed(20, 10, 0));
    accepted(verdict_of(rolling_within(0.14, 40), &step, &there));

    let mut check = new_check(rolling_within(0.0, 40));
    check.begin(&step.input()).unwrap();
    let refused = check.judge(&step.input(), &step.held[0], &there).unwrap();
    assert_eq!(refused, refused_as("it would topple"));
    accepted(check.judge(&step.input(), &step.held[1], &beside).unwrap());
    let resort = check.last_resort().unwrap();
    assert_eq!((resort.arrival, resort.resting), (0, there));
}

#[test]
fn the_last_resort_is_where_what_rolls_tilts_least_and_nothing_beyond_the_limits_of_all() {
    let step = Step::new(lying(&[base()]), [roller(0), falling(1)]);
    let settings = TrialSettings {
        neighbour_m: 0.0,
        ..rolling_within(0.0, 40)
    };
    let mut check = new_check(settings);
    check.begin(&step.input()).unwrap();
    assert!(is_refused_tried(&mut check, &step, 1, &placed(2, 2, 0)));
    assert_eq!(check.last_resort(), None);
    let mut twin = new_twin(TwinSettings::default(), &[base()]);
    let places = [(2, 20, 0), (11, 11, 50), (15, 11, 50), (25, 2, 0)];
    let refused = places.map(|(x, y, height)| {
        let resting = placed(x, y, height);
        assert!(is_refused_tried(&mut check, &step, 0, &resting));
        let held = &step.held[0];
        let pose = held.item.container_from_item(&step.grid, &resting);
        let settling = tried(&mut twin, held.model.as_ref().unwrap(), &pose.unwrap());
        (resting, settling)
    });
    let TrialSettings { limits, .. } = settings;
    let possible = refused.into_iter();
    let possible = possible.filter(|(_, settling)| settling.beyond(&limits).is_none());
    let rolling: TrialLimits = limits.of_rolling();
    let (resting, settling) = possible
        .min_by(|(_, a), (_, b)| a.severity(&rolling).total_cmp(&b.severity(&rolling)))
        .unwrap();
    let resort = check.last_resort().unwrap();
    assert_eq!((resort.arrival, resort.resting), (0, resting));
    assert_eq!(resort.evidence.settling, Some(settling));
}
