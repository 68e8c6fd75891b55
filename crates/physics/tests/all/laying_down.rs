//! A cell that goes on where another one ended, known by the poses of its bodies alone.
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::error::PhysicsError;

use crate::common::{at, ball, cuboid, poses, put, robot, turned};

/// A cell with a heap of tilted bodies.
fn heap() -> SimulatedCell {
    let mut cell = robot();
    let models = [cuboid([0.09, 0.06, 0.04]), ball(0.03), cuboid([0.05; 3])];
    for step in 0..9_u32 {
        let turn = f64::from(step);
        let x_m = 0.16 + 0.06 * (1.7 * turn).cos();
        let y_m = 0.16 + 0.06 * (2.3 * turn).sin();
        let pose = turned(x_m, y_m, 0.03 + 0.025 * turn, 0.4 * turn);
        cell.place(&models[step as usize % models.len()], &pose)
            .unwrap();
    }
    cell
}

#[test]
fn a_scan_of_bodies_laid_down_is_the_scan_they_came_from() {
    let grid = Grid::reference();
    let mut before = heap();
    let bodies = poses(&before);
    assert!(bodies.len() > 5);
    let mut after = robot();
    after.place(&cuboid([0.1; 3]), &at(0.1, 0.1, 0.05)).unwrap();
    after.lay_down(&bodies).unwrap();
    let contents = after.contents();
    let mut numbered = contents.iter().enumerate();
    assert!(numbered.all(|(index, body)| body.id.index() == index));
    assert_eq!(poses(&after), bodies);
    assert_eq!(after.scan(&grid).unwrap(), before.scan(&grid).unwrap());
    assert!(after.is_still());
    assert_eq!(after.settle(), 0.0);
    assert_eq!(poses(&after), bodies);
}

#[test]
fn bodies_laid_down_bear_what_is_placed_on_them() {
    let mut cell = robot();
    let block = cuboid([0.06, 0.06, 0.04]);
    put(&mut cell, &block, at(0.06, 0.06, 0.02));
    let bodies = poses(&cell);
    cell.lay_down(&bodies).unwrap();
    let apart = put(&mut cell, &block, at(0.24, 0.24, 0.02));
    assert!(apart.disturbance_m < 1e-4, "{apart:?}");
    let report = put(&mut cell, &block, at(0.06, 0.06, 0.06));
    assert!(report.inside && report.still, "{report:?}");
    assert_eq!(report.id.index(), 2);
    let height_m = report.container_from_item.translation.z;
    assert!((height_m - 0.06).abs() < 1e-3, "it stands at {height_m}");
    assert!(report.disturbance_m < 1e-3);
}

#[test]
fn a_heap_laid_down_stays_a_heap() {
    let mut cell = heap();
    let before = poses(&cell);
    cell.lay_down(&before).unwrap();
    put(&mut cell, &cuboid([0.02; 3]), at(0.01, 0.31, 0.01));
    let after = poses(&cell);
    for ((_, before), (_, after)) in before.iter().zip(&after) {
        let moved_m = (after.translation.vector - before.translation.vector).norm();
        assert!(moved_m < 2e-3, "moved by {moved_m} m");
    }
}

#[test]
fn bodies_that_cannot_be_laid_down_change_nothing() {
    let mut cell = heap();
    let before = poses(&cell);
    let mut bodies = before.clone();
    bodies[3].1.translation.x = f64::NAN;
    let refused = cell.lay_down(&bodies);
    assert!(matches!(refused, Err(PhysicsError::Pose { .. })));
    assert_eq!(poses(&cell), before);
}
