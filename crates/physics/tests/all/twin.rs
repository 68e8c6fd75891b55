//! Placements tried in the twin of a cell.

use std::sync::Arc;
use std::time::Instant;

use nalgebra::Isometry3;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::checks::trial::{Settling, TrialLimits};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::scene::Scene;
use ppnpack_physics::error::PhysicsError;
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::twin::{Twin, TwinSettings};

use crate::common::{Content, at, ball, cuboid, grid, lying};

/// A block under the cells 10 to 16 along both sides, 50 units high.
pub(crate) fn base() -> (Arc<Model>, Isometry3<f64>) {
    (cuboid([0.06, 0.06, 0.1]), at(0.13, 0.13, 0.05))
}

pub(crate) fn new_twin(settings: TwinSettings, content: &Content) -> Twin {
    let mut twin = Twin::new(settings).unwrap();
    assert!(twin.lay_down(&lying(content)));
    twin
}

/// What becomes of a model that is placed there, by the limits of the default.
pub(crate) fn tried(twin: &mut Twin, model: &Arc<Model>, pose: &Isometry3<f64>) -> Settling {
    let solid = twin.solid(model).unwrap();
    twin.try_placement(&solid, pose, &TrialLimits::default())
        .unwrap()
}

fn beyond(settling: &Settling) -> Option<&'static str> {
    settling.beyond(&TrialLimits::default())
}

#[test]
fn an_item_is_lowered_to_what_it_touches_but_no_farther_than_it_is_let_go_above_its_place() {
    let mut twin = new_twin(TwinSettings::default(), &[base()]);
    let cube = twin.solid(&cuboid([0.04; 3])).unwrap();
    // By where the middle of its foot is: beside the base, whose top is 0.1 m high, or over it by
    // as little as a centimetre.
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
    let scene = Scene::from_heightmap(heightmap);
    twin.fill_up(&grid, &scene).unwrap();
    let lowered_m = twin.clearance_m(&cube, &at(0.25, 0.13, 0.083 + 0.02));
    assert!((lowered_m - 0.003).abs() < 1e-5, "{lowered_m} m");
}

#[test]
fn bodies_far_from_the_place_make_no_difference() {
    let (model, pose) = (cuboid([0.05, 0.05, 0.04]), at(0.15, 0.13, 0.12));
    let mut among_few = new_twin(TwinSettings::default(), &[base()]);
    let first = (cuboid([0.05; 3]), at(0.26, 0.26, 0.025));
    let last = (ball(0.03), at(0.05, 0.28, 0.03));
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
    let mut twin = new_twin(TwinSettings::default(), &content);
    let settling = tried(&mut twin, &model, &pose);
    assert_eq!(beyond(&settling), None, "{settling:?}");
    assert!(settling.disturbance_m < 5e-3, "{settling:?}");
    let settings = TwinSettings {
        reach_m: 0.1,
        ..TwinSettings::default()
    };
    let settling = tried(&mut new_twin(settings, &content), &model, &pose);
    let why = Some("it would move what lies there");
    assert_eq!(beyond(&settling), why, "{settling:?}");
}

#[test]
fn what_cannot_be_laid_down_is_left_out_and_what_cannot_be_tried_is_an_error() {
    // Over the base's edge: without the base it would lie on the floor.
    let (model, pose) = (cuboid([0.03, 0.03, 0.1]), at(0.165, 0.13, 0.15));
    let mut twin = new_twin(TwinSettings::default(), &[base()]);
    let expected = tried(&mut twin, &model, &pose);
    assert!(beyond(&expected).is_some());
    let nowhere = (cuboid([0.05; 3]), at(0.1, f64::NAN, 0.1));
    let mut hollow = Model::clone(&nowhere.0);
    hollow.pieces.clear();
    let hollow = (Arc::new(hollow), at(0.25, 0.25, 0.025));
    assert!(!twin.lay_down(&lying(&[base(), nowhere, hollow])));
    assert_eq!(tried(&mut twin, &model, &pose), expected);
    let solid = twin.solid(&model).unwrap();
    let far_away = at(0.1, 0.1, 1e30);
    let refused = twin.try_placement(&solid, &far_away, &TrialLimits::default());
    assert!(matches!(refused, Err(PhysicsError::Pose { .. })));
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
    assert!(refused(|s| s.rough.timestep_s = 0.0).contains("timestep_s"));
    assert!(refused(|s| s.rough.substeps = 0).contains("substeps"));
    assert!(refused(|s| s.rough.settle_time_s = 0.0).contains("settling phase"));
    assert!(refused(|s| s.disturbance.friction = 0.0).contains("friction"));
    assert!(refused(|s| s.disturbance.shift_m = 0.2).contains("shift"));
    assert!(refused(|s| s.disturbance.yaw_rad = -0.1).contains("yaw_rad"));
    assert!(refused(|s| s.reach_m = f64::INFINITY).contains("reach"));
    assert!(refused(|s| s.still_speed_m_s = 2.0).contains("still_speed_m_s"));
}

#[test]
fn the_twin_of_a_cell_makes_no_errors_but_its_own_and_ends_soon() {
    let mut cell = CellSettings::robot();
    cell.settle_time_s = 5.0;
    cell.release.jitter_m = 0.01;
    cell.release.jitter_yaw_rad = 0.1;
    let twin = TwinSettings::of(&cell).cell;
    assert_eq!(
        [twin.release.jitter_m, twin.release.jitter_yaw_rad],
        [0.0; 2]
    );
    assert_eq!(twin.release.height_m, cell.release.height_m);
    assert!(twin.settle_time_s <= 1.0);
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
    for (plank_m, is_above) in [(0.292, true), (0.25, false)] {
        let mut twin = new_twin(TwinSettings::default(), &seesaw(plank_m));
        let settling = tried(&mut twin, &item, &at(0.08, 0.16, plank_m + 0.007));
        assert!(settling.tilt_rad > 0.05, "the plank tips: {settling:?}");
        assert_eq!(settling.above_rim_m > 0.002, is_above, "{settling:?}");
        let why = is_above.then_some("it would stick out above the rim");
        assert_eq!(beyond(&settling), why);
    }
}

#[test]
fn a_try_ends_with_its_time() {
    let mut twin = new_twin(TwinSettings::default(), &[base()]);
    let solid = twin.solid(&cuboid([0.05; 3])).unwrap();
    let (pose, limits) = (at(0.25, 0.25, 0.025), TrialLimits::default());
    twin.end_by(Some(Instant::now()));
    let late = twin.try_placement(&solid, &pose, &limits);
    assert_eq!(late, Err(PhysicsError::Late));
    let late = twin.try_loads_kg(&solid, 1.0, &pose, 1.5);
    assert_eq!(late, Err(PhysicsError::Late));
    twin.end_by(None);
    twin.try_placement(&solid, &pose, &limits).unwrap();
}
