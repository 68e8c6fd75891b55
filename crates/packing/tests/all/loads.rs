//! Loads: against statics by hand on stacks of boxes, and as a check of placements.

use ppnpack_packing::checks::loads::{BalanceCheck, LoadCheck, LoadSettings, Pile};
use ppnpack_packing::checks::trial::TrialSettings;
use ppnpack_packing::planning::method::Method;
use ppnpack_packing::scene::model::mesh::Mesh;

use crate::support::*;

/// A box by its sides, its mass, and where it lies.
fn lying(name: &str, sides_m: [f64; 3], mass_kg: f64, at_m: [f64; 3]) -> LyingSolid {
    lies(cuboid(name, sides_m, mass_kg), at_m)
}

fn pile(solids: &[LyingSolid]) -> Pile {
    let mut pile = Pile::new(&Grid::reference());
    pile.lay_down(solids);
    pile
}

/// Each within 10 % of what statics says.
fn assert_carry(solids: &[LyingSolid], expected_kg: &[f64]) {
    let pile = pile(solids);
    assert_eq!(solids.len(), expected_kg.len());
    for (solid, expected_kg) in expected_kg.iter().enumerate() {
        let found_kg = pile.carried_kg(solid);
        let is_near = (found_kg - expected_kg).abs() <= 0.1 * expected_kg + 1e-6;
        assert!(
            is_near,
            "{solid}: {found_kg} kg where {expected_kg} are expected"
        );
    }
}

#[test]
fn boxes_carry_what_statics_says() {
    let level =
        |level: f64, mass_kg| lying("box", [0.1, 0.1, 0.05], mass_kg, [0.1, 0.1, 0.05 * level]);
    let tower = [level(0.0, 1.0), level(1.0, 2.0), level(2.0, 3.0)];
    assert_carry(&tower, &[5.0, 3.0, 0.0]);

    // By the lever rule: the beam's middle is at 14.5 cm, the pillars' at 5.5 and 20.5.
    let pillar = |x_m| lying("pillar", [0.01, 0.04, 0.1], 0.1, [x_m, 0.1, 0.0]);
    let beam = lying("beam", [0.25, 0.04, 0.02], 2.0, [0.02, 0.1, 0.1]);
    assert_carry(&[pillar(0.05), pillar(0.2), beam], &[0.8, 1.2, 0.0]);

    let brick = |(x_m, level): (f64, f64)| {
        lying("brick", [0.08, 0.08, 0.04], 1.0, [x_m, 0.1, 0.04 * level])
    };
    let pyramid = [
        (0.02, 0.0),
        (0.10, 0.0),
        (0.18, 0.0),
        (0.06, 1.0),
        (0.14, 1.0),
        (0.10, 2.0),
    ];
    let pyramid = pyramid.map(brick);
    assert_carry(&pyramid, &[0.75, 1.5, 0.75, 0.5, 0.5, 0.0]);
    // No item is counted twice.
    let above_kg = [0, 1, 2, 3, 4, 5].map(|brick| pile(&pyramid).above_kg(brick));
    assert_eq!(above_kg, [2.0, 3.0, 2.0, 1.0, 1.0, 0.0]);

    // What hangs over is borne by what is below its middle.
    let base = lying("base", [0.1, 0.1, 0.1], 1.0, [0.1, 0.1, 0.0]);
    let beside = lying("beside", [0.05, 0.1, 0.08], 1.0, [0.2, 0.1, 0.0]);
    let plate = lying("plate", [0.15, 0.1, 0.01], 3.0, [0.1, 0.1, 0.1]);
    assert_carry(&[base, beside, plate], &[3.0, 0.0, 0.0]);

    let mut bowl = cuboid("bowl", [0.12, 0.12, 0.01], 0.5);
    bowl.mesh
        .append(&Mesh::cuboid([0.0, 0.0, 0.01], [0.01, 0.12, 0.06]));
    bowl.mesh
        .append(&Mesh::cuboid([0.11, 0.0, 0.01], [0.12, 0.12, 0.06]));
    let inside = lying("inside", [0.06, 0.06, 0.03], 2.0, [0.13, 0.13, 0.01]);
    assert_carry(&[lies(bowl, [0.1, 0.1, 0.0]), inside], &[2.0, 0.0]);
}

proptest! {
    /// Boxes that only get narrower, each wholly on the one below.
    #[test]
    fn towers_of_any_boxes_add_up(
        steps in prop::collection::vec((0.01..0.08_f64, 0.05..3.0_f64, 0.0..1.0_f64), 1..7),
    ) {
        let (mut x_m, mut side_m, mut z_m) = (0.05, 0.2, 0.0);
        let mut solids = Vec::new();
        for (height_m, mass_kg, shift) in &steps {
            solids.push(lying("box", [side_m, side_m, *height_m], *mass_kg, [x_m, x_m, z_m]));
            z_m += height_m;
            x_m += 0.02 * shift;
            side_m -= 0.02;
        }
        let pile = pile(&solids);
        for level in 0..steps.len() {
            let above_kg: f64 = steps.iter().skip(level + 1).map(|(_, mass_kg, _)| mass_kg).sum();
            let found_kg = pile.carried_kg(level);
            prop_assert!((found_kg - above_kg).abs() < 1e-4, "{found_kg} {above_kg}");
        }
    }

    /// However boxes lie, no weight is lost, and none carries more than is above it.
    #[test]
    fn no_item_carries_more_than_all_that_is_above(
        boxes in prop::collection::vec((0.0..0.2_f64, 0.0..0.2_f64, 0.03..0.1_f64, 0.1..2.0_f64), 1..9),
    ) {
        let boxes = boxes.into_iter().enumerate().map(|(level, (x_m, y_m, side_m, mass_kg))| {
            lying("box", [side_m, side_m, 0.03], mass_kg, [x_m, y_m, 0.03 * level as f64])
        });
        let solids: Vec<LyingSolid> = boxes.collect();
        let pile = pile(&solids);
        for solid in 0..solids.len() {
            prop_assert!(pile.carried_kg(solid) <= pile.above_kg(solid) + 1e-4);
        }
    }
}

/// A box of so many cells and units as an item that weighs so much.
fn held(cells: [usize; 2], height: Units, mass_kg: f64) -> Candidate {
    let sides_m = [
        cells[0] as f64 * 0.01,
        cells[1] as f64 * 0.01,
        f64::from(height) * 0.002,
    ];
    let model = Arc::new(cuboid("held", sides_m, mass_kg));
    Candidate::new(0, block(&Grid::reference(), cells, height)).with_model(model)
}

/// A glass of 10 x 10 x 10 cm that carries so much, with 1 kg on it.
fn glass(carries_kg: Option<f64>) -> Vec<LyingSolid> {
    let glass = Model {
        carries_kg,
        ..cuboid("glass", [0.1; 3], 0.2)
    };
    let lid = lying("lid", [0.1, 0.1, 0.02], 1.0, [0.1, 0.1, 0.1]);
    vec![lies(glass, [0.1, 0.1, 0.0]), lid]
}

/// What a check says of an item at these cells and this height in units.
fn judged(
    mut check: impl ValidityCheck,
    content: impl Into<Content>,
    held: Candidate,
    (x, y, resting_height): (usize, usize, Units),
) -> Verdict {
    let grid = Grid::reference();
    let scene = empty(&grid).with_content(content.into());
    let candidates = [held];
    let input = StepInput::new(&grid, &scene, &candidates);
    let at = resting([x, y], resting_height);
    check.begin(&input).unwrap();
    check.judge(&input, &candidates[0], &at).unwrap()
}

#[test]
fn a_placement_that_would_crush_an_item_is_refused_with_its_name_and_the_excess() {
    let on_top = |margin, mass_kg| {
        let held = held([10, 10], 10, mass_kg);
        judged(LoadCheck::new(margin), glass(Some(2.0)), held, (10, 10, 60))
    };
    let why = "glass would carry up to 250 g more than it may";
    let refused = Verdict::Refused(Refusal::because(Cause::Load, why));
    assert_eq!(on_top(1.0, 1.25), refused);
    // A load that may be is evidence.
    let Verdict::Accepted(evidence) = on_top(1.0, 0.5) else {
        panic!("half a kilogram more is not too much");
    };
    let load = evidence.load.unwrap();
    assert_eq!(load.item, "glass");
    assert!((load.estimated_kg - 1.5).abs() < 1e-4);
    assert!((load.share() - 0.75).abs() < 1e-4);
    // A margin does not count more than all that is above.
    assert!(on_top(10.0, 0.99).is_accepted());
    // Nothing may rest on what carries nothing.
    for (at, expected) in [((12, 12, 50), false), ((22, 12, 0), true)] {
        let bare = glass(Some(0.0))[..1].to_vec();
        let verdict = judged(LoadCheck::new(1.0), bare, held([4, 4], 10, 0.01), at);
        assert_eq!(verdict.is_accepted(), expected);
    }
}

#[test]
fn a_load_is_shared_by_what_bears_it() {
    let pillar = |x_m| {
        let model = Model {
            carries_kg: Some(0.6),
            ..cuboid("pillar", [0.02, 0.1, 0.1], 0.1)
        };
        lies(model, [x_m, 0.1, 0.0])
    };
    // Moved by 4 cm the beam stands on one of them alone, but for what hangs over. With a margin
    // for what is not known, neither may bear it.
    for (margin, x, expected) in [(1.0, 10, true), (1.0, 14, false), (1.5, 10, false)] {
        let pillars = vec![pillar(0.1), pillar(0.2)];
        let beam = held([12, 10], 5, 1.0);
        let verdict = judged(LoadCheck::new(margin), pillars, beam, (x, 10, 50));
        assert_eq!(verdict.is_accepted(), expected, "{margin} {x}");
    }
}

#[test]
fn what_is_not_limited_carries_anything_and_what_is_not_known_is_told() {
    let on_top = |content: Content| {
        judged(
            LoadCheck::new(1.0),
            content,
            held([10, 10], 10, 100.0),
            (10, 10, 60),
        )
    };
    assert_eq!(
        on_top(glass(None).into()),
        Verdict::Accepted(Evidence::default())
    );
    let known = glass(Some(200.0)).into_iter().map(LyingBody::Known);
    let Verdict::Accepted(evidence) = on_top(known.chain([LyingBody::Unknown]).collect()) else {
        panic!("it carries more");
    };
    assert!(evidence.degraded[0].contains("not known"));
}

#[test]
fn a_container_that_would_be_out_of_balance_is_refused_and_what_brings_it_back_is_not() {
    // The reference container is 32 cm square: its middle is at 16 cm, the box's at 5 cm.
    let heavy = || lying("heavy", [0.1; 3], 2.0, [0.0, 0.11, 0.0]);
    // Three on one side are too many; a fourth on the other is better than none.
    for (count, x, expected) in [(0, 0, true), (1, 0, false), (1, 22, true), (3, 22, true)] {
        let content: Vec<LyingSolid> = (0..count).map(|_| heavy()).collect();
        let held = held([10, 10], 10, 2.0);
        let verdict = judged(BalanceCheck::new(0.25), content, held, (x, 11, 0));
        assert_eq!(verdict.is_accepted(), expected, "{count} {x}");
    }
}

#[test]
fn the_planner_leaves_what_is_limited_alone() {
    let grid = Grid::reference();
    let method = Method {
        trial: TrialSettings::off(),
        ..Method::default()
    };
    // Everywhere but on the lid the container is full to the rim.
    let mut heightmap = Heightmap::empty(&grid);
    for (x, y) in (0..grid.nx()).flat_map(|x| (0..grid.ny()).map(move |y| (x, y))) {
        let is_lid = (10..20).contains(&x) && (10..20).contains(&y);
        heightmap.raise(x, y, if is_lid { 60 } else { grid.rim() });
    }
    let scene = Scene::from_heightmap(heightmap);
    for (carries_kg, expected) in [(None, true), (Some(3.5), true), (Some(2.0), false)] {
        let scene = scene.clone().with_content(glass(carries_kg).into());
        let candidates = [held([10, 10], 10, 1.25)];
        let mut planner = method.build(&grid, None).unwrap();
        let plan = planner.plan(&StepInput::new(&grid, &scene, &candidates));
        assert_eq!(plan.unwrap().choice().is_some(), expected, "{carries_kg:?}");
    }
}

#[test]
fn impossible_settings_are_named() {
    LoadSettings::default().validate().unwrap();
    let refused = |change: fn(&mut LoadSettings)| {
        let mut settings = LoadSettings::default();
        change(&mut settings);
        settings.validate().unwrap_err().to_string()
    };
    assert!(refused(|settings| settings.margin = 0.5).contains("margin"));
    assert!(refused(|settings| settings.imbalance_kg_m = Some(f64::NAN)).contains("imbalance"));
}
