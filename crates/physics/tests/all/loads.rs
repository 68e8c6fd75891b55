//! What rests on bodies, as measured in the cell, against statics by hand.
use std::sync::Arc;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use ppnpack_catalogue::object::Model;
use ppnpack_packing::checks::loads::Pile;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::scene::content::LyingSolid;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::settings::CellSettings;

use crate::common::{at, ball, cuboid, poses, put, robot};

type Posed = (Arc<Model>, Isometry3<f64>);

/// A cell in which these were placed one after the other.
fn placed(bodies: &[Posed]) -> SimulatedCell {
    let mut cell = robot();
    for (model, pose) in bodies {
        put(&mut cell, model, *pose);
    }
    assert!(cell.is_still());
    cell
}

fn masses_kg(bodies: &[Posed]) -> Vec<f64> {
    bodies.iter().map(|(model, _)| model.mass.mass_kg).collect()
}

/// Each within a share of the whole mass of what is expected, and all held up with what they weigh
/// and carry.
fn assert_carry(cell: &SimulatedCell, expected_kg: &[f64], share: f64) {
    let loads = cell.loads();
    assert_eq!(loads.len(), expected_kg.len());
    let contents = cell.contents();
    let all_kg: f64 = contents.iter().map(|body| body.model.mass.mass_kg).sum();
    for (load, expected_kg) in loads.iter().zip(expected_kg) {
        let is_near = (load.carried_kg - expected_kg).abs() < share * all_kg;
        assert!(is_near, "{loads:?} where {expected_kg:?} kg are expected");
        assert!(load.unbalanced_kg.abs() < 0.005 * all_kg, "{loads:?}");
    }
}

fn estimated_kg(cell: &SimulatedCell) -> Vec<f64> {
    let solids = cell.contents().into_iter();
    let solids = solids.map(|body| LyingSolid::new(body.model, body.container_from_item));
    let solids: Vec<_> = solids.collect();
    let mut pile = Pile::new(&Grid::reference());
    pile.lay_down(&solids);
    let solids = 0..solids.len();
    solids.map(|solid| pile.carried_kg(solid)).collect()
}

/// Boxes of these sides, one on the other.
fn tower(sides_m: &[[f64; 3]]) -> Vec<Posed> {
    let mut z_m = 0.0;
    let level = |sides_m: &[f64; 3]| {
        z_m += sides_m[2];
        (cuboid(*sides_m), at(0.15, 0.15, z_m - sides_m[2] / 2.0))
    };
    sides_m.iter().map(level).collect()
}

#[test]
fn each_box_of_a_tower_carries_those_above() {
    let bodies = tower(&[
        [0.1, 0.1, 0.04],
        [0.12, 0.08, 0.05],
        [0.08, 0.08, 0.03],
        [0.06, 0.06, 0.06],
    ]);
    let kg = masses_kg(&bodies);
    let cell = placed(&bodies);
    let expected = [kg[1] + kg[2] + kg[3], kg[2] + kg[3], kg[3], 0.0];
    assert_carry(&cell, &expected, 0.01);
}

#[test]
fn measuring_changes_nothing_and_gives_the_same_twice() {
    let mut cell = placed(&tower(&[[0.1, 0.1, 0.04], [0.08, 0.08, 0.03]]));
    let before = cell.contents();
    let loads = cell.loads();
    assert_eq!(cell.loads(), loads);
    assert_eq!(cell.contents(), before);
    assert_eq!(cell.settle(), 0.0);
    // What was laid down asleep is known by its poses alone.
    let bodies = poses(&cell);
    cell.lay_down(&bodies).unwrap();
    assert_carry(&cell, &[bodies[1].0.mass.mass_kg, 0.0], 0.01);
}

#[test]
fn supports_bear_a_bridge_by_the_lever_rule() {
    let pillar = cuboid([0.02, 0.05, 0.06]);
    let bridge = cuboid([0.22, 0.05, 0.02]);
    // The bridge's middle is 5 cm from the one pillar's, and 10 cm from the other's.
    let bodies = [
        (Arc::clone(&pillar), at(0.10, 0.15, 0.03)),
        (pillar, at(0.25, 0.15, 0.03)),
        (bridge, at(0.15, 0.15, 0.07)),
    ];
    let bridge_kg = bodies[2].0.mass.mass_kg;
    let cell = placed(&bodies);
    // A pillar's top may bear at its edges: by a centimetre each the shares are between 0.6 and
    // 0.71.
    let loads = cell.loads();
    let shares = [0, 1].map(|pillar| loads[pillar].carried_kg / bridge_kg);
    assert!(
        (shares[0] - 2.0 / 3.0).abs() < 0.06 && (shares[0] + shares[1] - 1.0).abs() < 0.02,
        "{shares:?}"
    );
    assert!(loads[2].carried_kg.abs() < 1e-6);
}

#[test]
fn what_is_estimated_is_within_a_tenth_of_what_is_measured_on_stacks_of_boxes() {
    let flat = cuboid([0.12, 0.12, 0.03]);
    let wide = cuboid([0.2, 0.1, 0.03]);
    let small = cuboid([0.05, 0.05, 0.05]);
    let stacks: [Vec<Posed>; 3] = [
        tower(&[[0.2, 0.2, 0.03], [0.14, 0.14, 0.03], [0.1, 0.1, 0.06]]),
        vec![
            (Arc::clone(&flat), at(0.08, 0.15, 0.015)),
            (Arc::clone(&flat), at(0.22, 0.15, 0.015)),
            (Arc::clone(&wide), at(0.15, 0.15, 0.045)),
            (Arc::clone(&small), at(0.15, 0.15, 0.085)),
        ],
        vec![
            (flat, at(0.15, 0.15, 0.015)),
            (Arc::clone(&small), at(0.12, 0.15, 0.055)),
            (small, at(0.18, 0.15, 0.055)),
            (wide, at(0.15, 0.15, 0.095)),
        ],
    ];
    for bodies in stacks {
        let cell = placed(&bodies);
        let estimated_kg = estimated_kg(&cell);
        for (load, estimated_kg) in cell.loads().iter().zip(&estimated_kg) {
            let is_near = (load.carried_kg - estimated_kg).abs() <= 0.1 * load.carried_kg + 1e-3;
            assert!(is_near, "{:?} kg for {estimated_kg:?}", cell.loads());
        }
    }
}

/// A plate leans on a block, by friction and by its edge: what it weighs is on the floor, or on the
/// block.
#[test]
fn what_leans_is_held_by_friction_and_normal_forces_together() {
    let block = cuboid([0.08, 0.1, 0.08]);
    let plate = cuboid([0.14, 0.08, 0.01]);
    let lean = Isometry3::from_parts(
        Translation3::new(0.09, 0.15, 0.05),
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -0.6),
    );
    let mut settings = CellSettings::robot();
    settings.contact.item_friction = 1.0;
    settings.contact.wall_friction = 1.0;
    let mut cell = SimulatedCell::new(settings).unwrap();
    put(&mut cell, &block, at(0.18, 0.15, 0.04));
    let leaning = cell.place(&plate, &lean).unwrap();
    assert!(leaning.still, "{leaning:?}");
    let up = leaning.container_from_item.rotation * Vector3::z();
    assert!(up.z < 0.98, "it lies flat: {up:?}");
    let loads = cell.loads();
    let plate_kg = plate.mass.mass_kg;
    let share = loads[0].carried_kg / plate_kg;
    // It leans with its upper end: the floor bears more than a third.
    assert!((0.05..0.67).contains(&share), "{share}");
    for load in &loads {
        assert!(load.unbalanced_kg.abs() < 0.01 * plate_kg, "{loads:?}");
    }
}

/// Four balls in a corner bear a fifth: their normals lean, and friction bears a part.
#[test]
fn a_ball_on_others_is_borne_by_them_together() {
    let ball = ball(0.03);
    let one_kg = ball.mass.mass_kg;
    let places = [(0.03, 0.03), (0.09, 0.03), (0.03, 0.09), (0.09, 0.09)];
    let bodies = places.map(|(x_m, y_m)| (Arc::clone(&ball), at(x_m, y_m, 0.03)));
    let blocks = [
        (cuboid([0.18, 0.32 - 0.12, 0.06]), at(0.09, 0.22, 0.03)),
        (cuboid([0.32 - 0.12, 0.12, 0.06]), at(0.22, 0.06, 0.03)),
    ];
    let mut cell = robot();
    for (model, pose) in bodies.iter().chain(&blocks) {
        put(&mut cell, model, *pose);
    }
    let top = put(&mut cell, &ball, at(0.06, 0.06, 0.075));
    assert!(top.inside && top.still, "{top:?}");
    let loads = cell.loads();
    let borne_kg: f64 = loads[..4].iter().map(|load| load.carried_kg).sum();
    assert!((borne_kg / one_kg - 1.0).abs() < 0.05, "{loads:?}");
    for load in &loads {
        assert!(load.unbalanced_kg.abs() < 0.02 * one_kg, "{loads:?}");
    }
}
