//! What becomes of items that are released into the container.
use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use ppnpack_catalogue::object::Model;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::error::PhysicsError;
use ppnpack_physics::settings::{CellSettings, SolverSettings};

use crate::common::{at, ball, cell, cuboid, cuboids, put, reference, turned};

/// A cell that waits until everything is still.
fn patient() -> SimulatedCell {
    cell(|settings| settings.settle_time_s = 5.0)
}

type Exactness = (fn() -> SolverSettings, f64, f64);

/// Solvers of contacts, with the most that a box slides which is dropped from 12 cm on another, and
/// the deepest that it reaches into it, in metres.
const EXACTNESS: [Exactness; 2] = [
    (|| CellSettings::robot().solver, 2e-3, 0.1e-3),
    (SolverSettings::default, 5e-3, 0.2e-3),
];

#[test]
fn a_box_rests_on_the_floor_at_half_its_height() {
    for side_m in [0.02, 0.05, 0.1] {
        let mut cell = reference();
        let planned = turned(0.16, 0.16, side_m / 2.0, 0.3);
        let model = cuboid([side_m * 1.5, side_m, side_m]);
        let report = put(&mut cell, &model, planned);
        assert!(report.height_change_m.abs() < 0.5e-3, "{report:?}");
        assert!(report.slide_m < 1e-3, "{report:?}");
        assert!(report.tilt_rad < 0.01, "{report:?}");
        assert!(report.inside && report.still && !report.toppled && !report.lost);
        assert_eq!(report.disturbance_m, 0.0);
        // It falls asleep soon after it lands.
        assert!(report.simulated_s < 0.3, "{report:?}");
    }
}

#[test]
fn a_stack_of_five_boxes_stands() {
    for (solver, most_slide_m, most_overlap_m) in EXACTNESS {
        let mut cell = cell(|settings| settings.solver = solver());
        let model = cuboid([0.06, 0.06, 0.05]);
        for level in 0..5 {
            let z_m = 0.025 + 0.05 * f64::from(level);
            let report = put(&mut cell, &model, at(0.16, 0.16, z_m));
            assert!(report.inside && !report.toppled, "{report:?}");
        }
        cell.settle();
        assert!(cell.is_still());
        for (level, body) in cell.contents().iter().enumerate() {
            let expected = at(0.16, 0.16, 0.025 + 0.05 * level as f64).translation;
            let off = body.container_from_item.translation.vector - expected.vector;
            assert!(off.xy().norm() < most_slide_m, "{level}: {off:?}");
            assert!(off.z.abs() < 5.0 * most_overlap_m, "{level}: {off:?}");
        }
        let overlap_m = cell.deepest_overlap_m();
        assert!(overlap_m < most_overlap_m, "{overlap_m}");
        // Asleep, nothing drifts.
        let before = cell.contents();
        cell.settle();
        assert_eq!(cell.contents(), before);
    }
}

#[test]
fn a_box_that_overhangs_topples() {
    let mut cell = patient();
    put(&mut cell, &cuboid([0.06, 0.06, 0.1]), at(0.16, 0.16, 0.05));
    let report = put(&mut cell, &cuboid([0.1, 0.04, 0.04]), at(0.22, 0.16, 0.12));
    assert!(report.toppled && report.tilt_rad > 0.5, "{report:?}");
    assert!(report.height_change_m < -0.02, "{report:?}");
    assert!(report.inside && report.still);
}

#[test]
fn an_item_released_outside_is_lost() {
    let mut cell = reference();
    let inside = put(&mut cell, &cuboid([0.05; 3]), at(0.16, 0.16, 0.025));
    let report = put(&mut cell, &cuboid([0.05; 3]), at(0.5, 0.16, 0.025));
    assert!(report.lost && !report.inside, "{report:?}");
    assert_eq!(report.disturbance_m, 0.0);
    let contents = cell.contents();
    assert_eq!(contents.len(), 1);
    assert_eq!(contents[0].id, inside.id);
}

#[test]
fn an_item_that_tips_over_the_rim_is_lost() {
    let mut cell = patient();
    // Its centre of mass is beyond the outer face of the wall.
    let model = cuboid([0.1, 0.04, 0.03]);
    let report = put(&mut cell, &model, at(-0.03, 0.16, 0.315));
    let is_gone = report.lost && !report.inside;
    assert!(is_gone && report.toppled, "{report:?}");
    assert!(cell.contents().is_empty());
}

#[test]
fn an_item_on_top_of_the_rim_is_not_inside() {
    let mut cell = patient();
    let report = put(&mut cell, &cuboid([0.36, 0.36, 0.02]), at(0.16, 0.16, 0.31));
    assert!(!report.lost && !report.inside && report.still, "{report:?}");
    assert!(!cell.contents()[0].inside);
}

#[test]
fn a_ball_comes_to_rest() {
    let mut cell = patient();
    for (x, y) in [(0.16, 0.16), (0.1, 0.1), (0.16, 0.12)] {
        let report = put(&mut cell, &ball(0.02), at(x, y, 0.02));
        assert!(report.still && report.inside, "{report:?}");
        let z_m = report.container_from_item.translation.z;
        assert!((z_m - 0.02).abs() < 1e-3, "it rests at {z_m}");
    }
}

#[test]
fn what_lands_on_another_disturbs_it() {
    let mut cell = patient();
    put(&mut cell, &cuboid([0.02, 0.02, 0.1]), at(0.16, 0.16, 0.05));
    // It falls past the bar, and over it.
    let report = put(&mut cell, &cuboid([0.1, 0.1, 0.05]), at(0.20, 0.16, 0.125));
    assert!(report.disturbance_m > 2e-3, "{report:?}");
}

#[test]
fn friction_decides_whether_a_block_slides() {
    // A bar leans on a wall at about 60 degrees: with friction it stays, without it slides down.
    let lean = |friction: f64| {
        let mut cell = cell(|settings| {
            settings.settle_time_s = 2.0;
            settings.contact.item_friction = friction;
            settings.contact.wall_friction = friction;
            settings.release.height_m = 0.0;
        });
        let angle = 60.0_f64.to_radians();
        let rotation = UnitQuaternion::from_euler_angles(0.0, angle, 0.0);
        let (half_m, thin_m) = (0.1, 0.01);
        let centre_x = half_m * angle.cos() + thin_m * angle.sin();
        let centre_z = half_m * angle.sin() + thin_m * angle.cos();
        let pose = Isometry3::from_parts(Translation3::new(centre_x, 0.16, centre_z), rotation);
        let bar = cuboid([2.0 * half_m, 0.05, 2.0 * thin_m]);
        cell.place(&bar, &pose).unwrap().tilt_rad
    };
    assert!(lean(0.9) < 0.1, "{}", lean(0.9));
    assert!(lean(0.02) > 0.5, "{}", lean(0.02));
}

#[test]
fn mass_properties_are_the_models_not_its_hulls() {
    // Alike but for the centre of mass: the second is loaded at one end.
    let even = cuboid([0.1, 0.04, 0.02]);
    let mut loaded = Model::clone(&even);
    loaded.mass.centre_of_mass_m = Point3::new(0.045, 0.0, 0.0);
    // The edge of the support is 2 cm from the bar's middle.
    let place = |model: Arc<Model>| {
        let mut cell = patient();
        put(&mut cell, &cuboid([0.06, 0.06, 0.1]), at(0.16, 0.16, 0.05));
        put(&mut cell, &model, at(0.17, 0.16, 0.11)).toppled
    };
    assert!(!place(even));
    assert!(place(Arc::new(loaded)));
}

#[test]
fn compounds_rest_on_their_pieces() {
    let mut cell = reference();
    // A table: a plate on two feet.
    let boxes = [
        ([-0.04, 0.0, 0.02], [0.02, 0.08, 0.04]),
        ([0.04, 0.0, 0.02], [0.02, 0.08, 0.04]),
        ([0.0, 0.0, 0.05], [0.1, 0.08, 0.02]),
    ];
    let report = put(&mut cell, &cuboids("table", &boxes), at(0.16, 0.16, 0.0));
    let is_as_planned = report.height_change_m.abs() < 1e-3;
    assert!(is_as_planned && report.still, "{report:?}");
}

#[test]
fn thin_items_do_not_pass_each_other() {
    for (solver, _, most_overlap_m) in EXACTNESS {
        let mut cell = cell(|settings| settings.solver = solver());
        let plate = cuboid([0.12, 0.1, 0.002]);
        for level in 0..8 {
            let planned = at(0.16, 0.16, 0.001 + 0.002 * f64::from(level));
            let report = put(&mut cell, &plate, planned);
            let sunk_m = report.height_change_m.abs();
            assert!(sunk_m < 10.0 * most_overlap_m, "{level}: {report:?}");
        }
        let overlap_m = cell.deepest_overlap_m();
        assert!(overlap_m < 5.0 * most_overlap_m, "{overlap_m}");
    }
}

#[test]
fn impossible_poses_and_models_are_refused_and_change_nothing() {
    let mut cell = reference();
    let model = cuboid([0.05; 3]);
    put(&mut cell, &model, at(0.1, 0.1, 0.025));
    let before = cell.contents();
    let unrigid = UnitQuaternion::new_unchecked(Quaternion::new(2.0, 0.0, 0.0, 0.0));
    for pose in [
        at(f64::NAN, 0.1, 0.1),
        at(0.1, f64::INFINITY, 0.1),
        at(0.1, 0.1, 1e30),
        Isometry3::from_parts(Translation3::identity(), unrigid),
    ] {
        let refused = cell.place(&model, &pose).unwrap_err();
        assert!(matches!(refused, PhysicsError::Pose { .. }), "{refused}");
    }
    let changed = |change: fn(&mut Model)| {
        let mut changed = Model::clone(&model);
        change(&mut changed);
        Arc::new(changed)
    };
    for model in [
        changed(|model| model.pieces.clear()),
        changed(|model| model.pieces[0].vertices.truncate(3)),
        changed(|model| {
            model.pieces[0]
                .vertices
                .iter_mut()
                .for_each(|at| at.z = 0.0);
        }),
        changed(|model| model.pieces[0].vertices.fill(Point3::origin())),
        changed(|model| model.pieces[0].vertices[0].x = f64::NAN),
        changed(|model| model.mass.mass_kg = 0.0),
        changed(|model| model.mass.inertia_kg_m2.fill(0.0)),
        changed(|model| model.mass.centre_of_mass_m.x = f64::NAN),
    ] {
        let refused = cell.place(&model, &at(0.1, 0.1, 0.1)).unwrap_err();
        assert!(matches!(refused, PhysicsError::Model { .. }), "{refused}");
    }
    assert_eq!(cell.contents(), before);
}

#[test]
fn an_item_released_inside_another_is_pushed_out_gently() {
    let mut cell = cell(|settings| {
        settings.settle_time_s = 2.0;
        settings.release.height_m = 0.0;
    });
    let model = cuboid([0.05; 3]);
    put(&mut cell, &model, at(0.16, 0.16, 0.025));
    let report = put(&mut cell, &model, at(0.17, 0.16, 0.05));
    assert!(report.inside && !report.lost, "{report:?}");
}
