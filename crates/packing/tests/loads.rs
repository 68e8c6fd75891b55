//! Loads: against statics by hand on stacks of boxes, and as a check of placements.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Point3};
use ppnpack_packing::candidate::Candidate;
use ppnpack_packing::check::{ValidityCheck, Verdict};
use ppnpack_packing::content::{Content, LyingBody, LyingSolid};
use ppnpack_packing::grid::{Grid, Units};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::loads::{BalanceCheck, LoadCheck, LoadSettings, Pile};
use ppnpack_packing::method::Method;
use ppnpack_packing::model::mesh::Mesh;
use ppnpack_packing::model::{MassProperties, Model};
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::refusal::{Cause, Refusal};
use ppnpack_packing::step::StepInput;
use ppnpack_packing::trial::TrialSettings;
use proptest::prelude::*;

/// A box with sides in metres; its frame is at its lowest corner, its weight in its middle.
fn cuboid(name: &str, sides_m: [f64; 3], mass_kg: f64) -> Model {
    Model {
        name: name.to_owned(),
        mesh: Mesh::cuboid([0.0; 3], sides_m),
        volume_m3: sides_m.iter().product(),
        pieces: Vec::new(),
        mass: MassProperties {
            mass_kg,
            centre_of_mass_m: Point3::from(sides_m.map(|side_m| side_m / 2.0)),
            inertia_kg_m2: Matrix3::identity(),
        },
        carries_kg: None,
        resting_poses: Vec::new(),
    }
}

fn lies(model: Model, x_m: f64, y_m: f64, z_m: f64) -> LyingSolid {
    LyingSolid::new(Arc::new(model), Isometry3::translation(x_m, y_m, z_m))
}

fn carried_kg(solids: &[LyingSolid]) -> Vec<f64> {
    let mut pile = Pile::new(&Grid::reference());
    pile.lay_down(solids);
    (0..solids.len())
        .map(|solid| pile.carried_kg(solid))
        .collect()
}

/// Each within 10 % of what statics says.
fn assert_carry(solids: &[LyingSolid], expected_kg: &[f64]) {
    let found_kg = carried_kg(solids);
    assert_eq!(found_kg.len(), expected_kg.len());
    for (found, expected) in found_kg.iter().zip(expected_kg) {
        let is_near = (found - expected).abs() <= 0.1 * expected + 1e-6;
        assert!(
            is_near,
            "{found_kg:?} kg where {expected_kg:?} are expected"
        );
    }
}

#[test]
fn each_box_of_a_tower_carries_those_above() {
    let level = |level: f64, mass_kg| {
        lies(
            cuboid("box", [0.1, 0.1, 0.05], mass_kg),
            0.1,
            0.1,
            0.05 * level,
        )
    };
    assert_carry(
        &[level(0.0, 1.0), level(1.0, 2.0), level(2.0, 3.0)],
        &[5.0, 3.0, 0.0],
    );
}

#[test]
fn pillars_carry_a_beam_by_the_lever_rule() {
    let pillar = |x_m| lies(cuboid("pillar", [0.01, 0.04, 0.1], 0.1), x_m, 0.1, 0.0);
    let beam = lies(cuboid("beam", [0.25, 0.04, 0.02], 2.0), 0.02, 0.1, 0.1);
    // The beam's middle is at 14.5 cm, the pillars' at 5.5 and 20.5.
    assert_carry(&[pillar(0.05), pillar(0.2), beam], &[0.8, 1.2, 0.0]);
}

#[test]
fn a_pyramid_hands_down_halves() {
    let brick = |x_m, level: f64| {
        lies(
            cuboid("brick", [0.08, 0.08, 0.04], 1.0),
            x_m,
            0.1,
            0.04 * level,
        )
    };
    let pyramid = [
        brick(0.02, 0.0),
        brick(0.10, 0.0),
        brick(0.18, 0.0),
        brick(0.06, 1.0),
        brick(0.14, 1.0),
        brick(0.10, 2.0),
    ];
    assert_carry(&pyramid, &[0.75, 1.5, 0.75, 0.5, 0.5, 0.0]);
}

#[test]
fn what_hangs_over_is_borne_by_what_is_below_its_middle() {
    let base = lies(cuboid("base", [0.1, 0.1, 0.1], 1.0), 0.1, 0.1, 0.0);
    let beside = lies(cuboid("beside", [0.05, 0.1, 0.08], 1.0), 0.2, 0.1, 0.0);
    let plate = lies(cuboid("plate", [0.15, 0.1, 0.01], 3.0), 0.1, 0.1, 0.1);
    assert_carry(&[base, beside, plate], &[3.0, 0.0, 0.0]);
}

#[test]
fn what_stands_in_a_bowl_is_carried_by_it() {
    let mut bowl = cuboid("bowl", [0.12, 0.12, 0.01], 0.5);
    for [low, high] in [
        [[0.0, 0.0, 0.01], [0.01, 0.12, 0.06]],
        [[0.11, 0.0, 0.01], [0.12, 0.12, 0.06]],
    ] {
        bowl.mesh.append(&Mesh::cuboid(low, high));
    }
    let inside = lies(cuboid("inside", [0.06, 0.06, 0.03], 2.0), 0.13, 0.13, 0.01);
    assert_carry(&[lies(bowl, 0.1, 0.1, 0.0), inside], &[2.0, 0.0]);
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
            solids.push(lies(cuboid("box", [side_m, side_m, *height_m], *mass_kg), x_m, x_m, z_m));
            z_m += height_m;
            x_m += 0.02 * shift;
            side_m -= 0.02;
        }
        let found_kg = carried_kg(&solids);
        for (level, found_kg) in found_kg.iter().enumerate() {
            let above_kg: f64 = steps.iter().skip(level + 1).map(|(_, mass_kg, _)| mass_kg).sum();
            prop_assert!((found_kg - above_kg).abs() < 1e-4, "{found_kg} {above_kg}");
        }
    }

    /// However boxes lie, the floor bears what the boxes do not: no weight is lost, and none carries more than is above it.
    #[test]
    fn no_item_carries_more_than_all_that_is_above(
        boxes in prop::collection::vec((0.0..0.2_f64, 0.0..0.2_f64, 0.03..0.1_f64, 0.1..2.0_f64), 1..9),
    ) {
        let mut solids: Vec<LyingSolid> = Vec::new();
        let mut z_m = 0.0;
        for (x_m, y_m, side_m, mass_kg) in boxes {
            solids.push(lies(cuboid("box", [side_m, side_m, 0.03], mass_kg), x_m, y_m, z_m));
            z_m += 0.03;
        }
        let mut pile = Pile::new(&Grid::reference());
        pile.lay_down(&solids);
        for solid in 0..solids.len() {
            prop_assert!(pile.carried_kg(solid) <= pile.above_kg(solid) + 1e-4);
        }
    }
}

/// A box of so many cells and units as an item that weighs so much.
fn held([nx, ny]: [usize; 2], height: Units, mass_kg: f64) -> Candidate {
    let surfaces = ViewSurfaces::of_cells(nx, ny, vec![height; nx * ny], vec![0; nx * ny]);
    let views = vec![surfaces; Grid::reference().resolution().yaws().count()];
    let sides_m = [
        nx as f64 * 0.01,
        ny as f64 * 0.01,
        f64::from(height) * 0.002,
    ];
    let model = cuboid("held", sides_m, mass_kg);
    let item = Item::new("held", views, model.volume_m3).unwrap();
    Candidate::new(0, Arc::new(item)).with_model(Arc::new(model))
}

fn at(x: usize, y: usize, resting_height: Units) -> RestingPlacement {
    RestingPlacement {
        placement: Placement { yaw: 0, x, y },
        resting_height,
    }
}

/// A glass of 10 x 10 x 10 cm that carries so much, with 1 kg on it.
fn glass(carries_kg: Option<f64>) -> Vec<LyingSolid> {
    let glass = Model {
        carries_kg,
        ..cuboid("glass", [0.1; 3], 0.2)
    };
    let lid = cuboid("lid", [0.1, 0.1, 0.02], 1.0);
    vec![lies(glass, 0.1, 0.1, 0.0), lies(lid, 0.1, 0.1, 0.1)]
}

fn judged(
    check: &mut dyn ValidityCheck,
    content: Content,
    held: Candidate,
    resting: &RestingPlacement,
) -> Verdict {
    let grid = Grid::reference();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid)).with_content(content);
    let candidates = [held];
    let input = StepInput::new(&grid, &scene, &candidates);
    check.begin(&input).unwrap();
    check.judge(&input, &candidates[0], resting).unwrap()
}

#[test]
fn a_placement_that_would_crush_an_item_is_refused_with_its_name_and_the_excess() {
    let verdict = judged(
        &mut LoadCheck::new(1.0),
        glass(Some(2.0)).into(),
        held([10, 10], 10, 1.25),
        &at(10, 10, 60),
    );
    let why = "glass would carry up to 250 g more than it may";
    assert_eq!(
        verdict,
        Verdict::Refused(Refusal::because(Cause::Load, why))
    );
}

#[test]
fn a_load_that_may_be_is_evidence() {
    let on_top = |margin, mass_kg| {
        judged(
            &mut LoadCheck::new(margin),
            glass(Some(2.0)).into(),
            held([10, 10], 10, mass_kg),
            &at(10, 10, 60),
        )
    };
    let Verdict::Accepted(evidence) = on_top(1.0, 0.5) else {
        panic!("half a kilogram more is not too much");
    };
    let load = evidence.load.unwrap();
    assert_eq!(load.item, "glass");
    assert!((load.estimated_kg - 1.5).abs() < 1e-4);
    assert!((load.share() - 0.75).abs() < 1e-4);
    // A margin does not count more than all that is above.
    assert!(on_top(10.0, 0.99).is_accepted());
}

#[test]
fn nothing_may_rest_on_what_carries_nothing() {
    let bare = glass(Some(0.0)).into_iter().take(1).collect::<Content>();
    let judged_at = |resting| {
        judged(
            &mut LoadCheck::new(1.0),
            bare.clone(),
            held([4, 4], 10, 0.01),
            &resting,
        )
    };
    assert!(!judged_at(at(12, 12, 50)).is_accepted());
    assert!(judged_at(at(22, 12, 0)).is_accepted());
}

#[test]
fn a_load_is_shared_by_what_bears_it() {
    let pillar = |x_m| {
        let model = Model {
            carries_kg: Some(0.6),
            ..cuboid("pillar", [0.02, 0.1, 0.1], 0.1)
        };
        lies(model, x_m, 0.1, 0.0)
    };
    let content = || vec![pillar(0.1), pillar(0.2)].into();
    let beam = || held([12, 10], 5, 1.0);
    assert!(judged(&mut LoadCheck::new(1.0), content(), beam(), &at(10, 10, 50)).is_accepted());
    // Moved by 4 cm it stands on one of them alone, but for what hangs over.
    assert!(!judged(&mut LoadCheck::new(1.0), content(), beam(), &at(14, 10, 50)).is_accepted());
    // With a margin for what is not known, neither may bear it.
    assert!(!judged(&mut LoadCheck::new(1.5), content(), beam(), &at(10, 10, 50)).is_accepted());
}

#[test]
fn what_is_not_limited_carries_anything_and_what_is_not_known_is_told() {
    let heavy = || held([10, 10], 10, 100.0);
    let verdict = judged(
        &mut LoadCheck::new(1.0),
        glass(None).into(),
        heavy(),
        &at(10, 10, 60),
    );
    assert_eq!(verdict, Verdict::Accepted(Default::default()));
    let known = glass(Some(200.0)).into_iter().map(LyingBody::Known);
    let partial = known.chain([LyingBody::Unknown]).collect();
    let verdict = judged(&mut LoadCheck::new(1.0), partial, heavy(), &at(10, 10, 60));
    let Verdict::Accepted(evidence) = verdict else {
        panic!("it carries more");
    };
    assert!(evidence.degraded[0].contains("not known"));
}

#[test]
fn a_container_that_would_be_out_of_balance_is_refused_and_what_brings_it_back_is_not() {
    // The reference container is 32 cm square: its middle is at 16 cm, the box's at 5 cm.
    let heavy = |x_m| lies(cuboid("heavy", [0.1; 3], 2.0), x_m, 0.11, 0.0);
    let judged_at = |content: Vec<LyingSolid>, x| {
        let verdict = judged(
            &mut BalanceCheck::new(0.25),
            content.into(),
            held([10, 10], 10, 2.0),
            &at(x, 11, 0),
        );
        verdict.is_accepted()
    };
    assert!(judged_at(Vec::new(), 0));
    assert!(!judged_at(vec![heavy(0.0)], 0));
    assert!(judged_at(vec![heavy(0.0)], 22));
    // Three on one side are too many; a fourth on the other is better than none.
    assert!(judged_at(vec![heavy(0.0), heavy(0.0), heavy(0.0)], 22));
}

#[test]
fn the_planner_leaves_what_is_limited_alone() {
    let grid = Grid::reference();
    let method = Method {
        trial: TrialSettings::off(),
        ..Method::default()
    };
    let resting = |carries_kg| {
        let content = glass(carries_kg);
        let mut heightmap = Heightmap::empty(&grid);
        // Everywhere but on the lid the container is full to the rim.
        for x in 0..grid.nx() {
            for y in 0..grid.ny() {
                let is_lid = (10..20).contains(&x) && (10..20).contains(&y);
                heightmap.raise(x, y, if is_lid { 60 } else { grid.rim() });
            }
        }
        let scene = Scene::from_heightmap(heightmap).with_content(content.into());
        let candidates = [held([10, 10], 10, 1.25)];
        let mut planner = method.build(&grid, None).unwrap();
        let plan = planner
            .plan(&StepInput::new(&grid, &scene, &candidates))
            .unwrap();
        plan.choice().is_some()
    };
    assert!(resting(None));
    assert!(resting(Some(3.5)));
    assert!(!resting(Some(2.0)));
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
