//! The arm's check among the others of the planning engine, and what it says of placements it
//! refuses.
use std::sync::Arc;

use nalgebra::{Isometry3, Point2, Vector2};
use ppnpack_packing::checks::check::{Cost, Evidence, ValidityCheck, Verdict};
use ppnpack_packing::kernel::grid::{Grid, Resolution, Units, Yaws};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::kernel::objective::{Heuristic, Order};
use ppnpack_packing::planning::plan::{CandidateReport, Planner, Reason};
use ppnpack_packing::ranking::proposals::ProposeAll;
use ppnpack_packing::ranking::refusal::Cause;
use ppnpack_packing::ranking::search::{Search, SearchSettings};
use ppnpack_packing::ranking::step::{Candidate, Evaluated, StepInput};
use ppnpack_packing::scene::Scene;
use ppnpack_robot::arm::Arm;
use ppnpack_robot::arms;
use ppnpack_robot::cell::{BoxSettings, CellSettings};
use ppnpack_robot::cycle::{CycleSettings, PickPlace};
use ppnpack_robot::feasibility::ArmCheck;
use ppnpack_robot::gripper::GripperPart;
use ppnpack_robot::motion::PlacePlanner;
use ppnpack_robot::parameters::ArmParameters;
use ppnpack_robot::pick::NoPickPoint;
use ppnpack_robot::refusal::{Body, Obstacle, Refusal};

use crate::common::scenes::{even, placed};

fn grid() -> Grid {
    let resolution = Resolution::new(0.01, 0.002, Yaws::half_turn(1).unwrap()).unwrap();
    Grid::new(Grid::reference().container(), resolution).unwrap()
}

/// A block of so many cells and units.
fn block(nx: usize, ny: usize, height: Units) -> Arc<Item> {
    let view = even(nx, ny, height);
    // In the middle of a cell, so that the pick point is there.
    let beside = |centre: Point2<f64>| centre - Vector2::new(0.005, 0.005);
    let view = ViewSurfaces {
        centre_of_mass_m: view.centre_of_mass_m.map(beside),
        ..view
    };
    Arc::new(Item::new("block", vec![view], 0.0).unwrap())
}

fn parameters() -> ArmParameters {
    ArmParameters::from_toml(arms::text("nachi-mz07l").unwrap()).unwrap()
}

fn check(parameters: &ArmParameters, cell: CellSettings) -> ArmCheck {
    let arm = Arc::new(Arm::new(parameters).unwrap());
    ArmCheck::new(PlacePlanner::new(arm, cell).unwrap())
}

/// What the check says of a block of 6 x 6 cells and 20 units in a container with this content.
fn ask(check: &mut ArmCheck, content: &Heightmap, x: usize, y: usize) -> Result<(), Refusal> {
    let grid = grid();
    let scene = Scene::from_heightmap(content.clone());
    let item = block(6, 6, 20);
    let candidates = [Candidate::new(0, item)];
    let input = StepInput::new(&grid, &scene, &candidates);
    let resting = placed(0, x, y);
    let planned = check.plan(&input, &candidates[0], &resting).map(|_| ());
    let verdict = check.judge(&input, &candidates[0], &resting).unwrap();
    let expected = match &planned {
        Ok(()) => Verdict::Accepted(Evidence::default()),
        Err(refusal) => Verdict::Refused(refusal.into()),
    };
    assert_eq!(verdict, expected);
    planned
}

#[test]
fn refusals_name_what_is_in_the_way() {
    let grid = grid();
    let empty = Heightmap::empty(&grid);
    let mut check = check(&parameters(), CellSettings::default());
    assert_eq!(check.cost(), Cost::Motion);
    assert_eq!(ask(&mut check, &empty, 13, 13), Ok(()));

    let hit = |body, obstacle| Err(Refusal::Collision { body, obstacle });
    let mut below = empty.clone();
    below.raise(15, 15, 1);
    let item_hits = hit(Body::HeldItem, Obstacle::Content);
    assert_eq!(ask(&mut check, &below, 13, 13), item_hits);

    // A tower beside the item that reaches the gripper's body, 32 mm wide and 23.6 cm above the
    // lip.
    let mut tower = empty.clone();
    tower.raise(18, 19, 150);
    assert_eq!(ask(&mut check, &tower, 13, 13), Ok(()));
    for y in 13..19 {
        tower.raise(19, y, 150);
    }
    let body = Body::Gripper(GripperPart::Body);
    let body_hits = hit(body, Obstacle::Content);
    assert_eq!(ask(&mut check, &tower, 13, 13), body_hits);
    assert_eq!(ask(&mut check, &empty, 0, 13), hit(body, Obstacle::Wall));

    assert_eq!(ask(&mut check, &empty, 27, 13), Err(Refusal::Placement));
    let scene = Scene::from_heightmap(empty);
    let input = StepInput::new(&grid, &scene, &[]);
    let narrow = Candidate::new(0, block(1, 6, 20));
    let refused = check.plan(&input, &narrow, &placed(0, 10, 10));
    assert_eq!(refused, Err(Refusal::Pick(NoPickPoint::TooSmall)));
}

#[test]
fn boxes_of_the_cell_are_named() {
    let empty = Heightmap::empty(&grid());
    let lamp = |lowest_m, highest_m| {
        let mut cell = CellSettings::default();
        cell.boxes.push(BoxSettings {
            name: "lamp".to_owned(),
            lowest_m,
            highest_m,
        });
        check(&parameters(), cell)
    };
    let named = |refusal: Result<(), Refusal>| match refusal {
        Err(Refusal::Collision {
            body,
            obstacle: Obstacle::Box(name),
        }) if &*name == "lamp" => body,
        other => panic!("{other:?}"),
    };
    // Where the item passes, where the gripper stands at the approach, and where the upper arm is.
    let hit = |lowest_m, highest_m| ask(&mut lamp(lowest_m, highest_m), &empty, 13, 13);
    let above_item = hit([0.14, 0.14, 0.33], [0.15, 0.15, 0.34]);
    assert_eq!(named(above_item), Body::Gripper(GripperPart::Cup));
    let beside_item = hit([0.188, 0.188, 0.305], [0.189, 0.189, 0.31]);
    assert_eq!(named(beside_item), Body::HeldItem);
    let at_arm = hit([-0.40, 0.1, 0.55], [-0.2, 0.2, 0.9]);
    assert!(matches!(named(at_arm), Body::Link(_)));
    assert_eq!(hit([-0.9, 0.1, 0.0], [-0.8, 0.2, 0.9]), Ok(()));
}

#[test]
fn what_is_out_of_reach_is_refused() {
    let empty = Heightmap::empty(&grid());
    let refusal = |arm: &ArmParameters| {
        let refused = ask(&mut check(arm, CellSettings::default()), &empty, 13, 13);
        refused.unwrap_err()
    };
    let too_far = refusal(&far());
    assert!(matches!(too_far, Refusal::OutOfReach { .. }), "{too_far:?}");
    let mut stiff = parameters();
    stiff.joints[1].lowest_deg = 100.0;
    let refused = refusal(&stiff);
    assert!(matches!(refused, Refusal::JointLimit { .. }), "{refused:?}");
}

/// A ceiling mount: the arm hangs above the container.
#[test]
fn an_arm_on_the_ceiling_places_too() {
    let empty = Heightmap::empty(&grid());
    let mut hanging = parameters();
    hanging.base.position_m = [-0.25, 0.16, 1.45];
    hanging.base.roll_deg = 180.0;
    // It reaches straight down, so the wrist passes its stretched pose.
    let cell = CellSettings {
        boxes: Vec::new(),
        least_wrist_bend_deg: 0.0,
        ..CellSettings::default()
    };
    assert_eq!(ask(&mut check(&hanging, cell), &empty, 13, 13), Ok(()));
}

/// What a step chooses for a block in an empty container, and what it says of the block.
fn plan_with(check: ArmCheck) -> (Option<Evaluated>, CandidateReport) {
    let grid = grid();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let candidates = [Candidate::new(0, block(6, 6, 20))];
    let input = StepInput::new(&grid, &scene, &candidates);
    let settings = SearchSettings {
        heuristic: Heuristic::Dbl,
        ..SearchSettings::default()
    };
    let search = Search::new(&grid, &settings).unwrap();
    let (search, check) = (Box::new(search), Box::new(check));
    let mut planner = Planner::new(Box::new(ProposeAll), search, vec![check], Order::Arrival, 0);
    let first = planner.plan(&input).unwrap();
    let (choice, report) = (first.choice(), first.candidates()[0].clone());
    // Nothing is kept from one step to the next.
    let again = planner.plan(&input).unwrap();
    assert_eq!(again.choice(), choice);
    assert_eq!(again.candidates()[0].refusals, report.refusals);
    (choice, report)
}

/// An arm that reaches no place of the container.
fn far() -> ArmParameters {
    let mut far = parameters();
    far.base.position_m = [-1.5, 0.16, 0.1];
    far
}

#[test]
fn the_engine_gives_up_an_item_that_the_arm_cannot_place() {
    let (choice, report) = plan_with(check(&parameters(), CellSettings::default()));
    let chosen = choice.unwrap().resting.placement;
    // The deepest bottom left is the corner; the gripper's body keeps clear of the walls.
    let is_near = chosen.x >= 1 && chosen.y >= 1 && chosen.x + chosen.y <= 4;
    assert!(is_near, "{chosen:?}");
    assert!(report.refusals.total() > 0);
    let (choice, report) = plan_with(check(&far(), CellSettings::default()));
    assert_eq!(choice, None);
    assert!(is_rejected_for_the_arm(&report), "{report:?}");
}

fn is_rejected_for_the_arm(report: &CandidateReport) -> bool {
    matches!(&report.reason, Some(Reason::Rejected(refusal)) if refusal.cause == Cause::Arm)
}

#[test]
fn an_item_that_cannot_be_fetched_from_where_it_lies_is_left_out_of_the_step() {
    let beyond_reach = PickPlace {
        position_m: [3.0, 0.0, 0.0],
        ..PickPlace::default()
    };
    for refused in [1, 7, 100] {
        let check = check(&parameters(), CellSettings::default());
        let (choice, report) = plan_with(check.clone());
        assert!(choice.is_some());
        let refused_for_the_place = report.refusals.total();
        let check = check
            .with_cycles(beyond_reach, CycleSettings::default())
            .with_refused_cycles_per_item(refused);
        let (choice, report) = plan_with(check);
        assert_eq!(choice, None);
        let (least, total) = (refused as u64, report.refusals.total());
        // Those whose place motion is not possible do not count.
        assert!(total >= refused_for_the_place + least, "{total}");
        assert!(total < 500, "{total} of 729");
        assert!(is_rejected_for_the_arm(&report), "{report:?}");
    }
}

#[test]
fn an_item_that_the_arm_can_fetch_is_not_left_out_whatever_is_refused_later() {
    let grid = grid();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let near = Candidate::new(0, block(6, 6, 20));
    let mut far = near.clone();
    far.lying.waits_at = Some(Isometry3::translation(3.0, 0.0, 0.0));
    let candidates = [near, far];
    let [near, far] = &candidates;
    let input = StepInput::new(&grid, &scene, &candidates);
    let resting = placed(0, 13, 13);
    let mut check = check(&parameters(), CellSettings::default())
        .with_cycles(PickPlace::default(), CycleSettings::default())
        .with_refused_cycles_per_item(2);
    let mut is_accepted = |order: &[&Candidate]| -> (Vec<bool>, bool) {
        check.begin(&input).unwrap();
        let verdicts = order.iter().map(|held| check.judge(&input, held, &resting));
        let accepted = verdicts.map(|verdict| verdict.unwrap().is_accepted());
        (accepted.collect(), check.is_done_with(near))
    };
    let (refused, is_left_out) = is_accepted(&[far, far]);
    assert_eq!((refused, is_left_out), (vec![false, false], true));
    let (accepted, is_left_out) = is_accepted(&[near, far, far, far, near]);
    assert_eq!(accepted, [true, false, false, false, true]);
    assert!(!is_left_out);
}
