//! What a scan from above shows.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod common;

use common::{at, cuboid, turned};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::heightmap::Surface;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::error::PhysicsError;
use ppnpack_physics::settings::CellSettings;

fn reference() -> SimulatedCell {
    SimulatedCell::new(CellSettings::default()).unwrap()
}

/// The samples higher than half a centimetre.
fn covered(surface: &Surface) -> usize {
    surface
        .heights_m()
        .iter()
        .filter(|height_m| **height_m > 0.005)
        .count()
}

#[test]
fn an_empty_container_is_flat() {
    let grid = Grid::reference();
    assert_eq!(
        reference().scan_surface(&grid).unwrap(),
        Surface::empty(&grid)
    );
}

#[test]
fn the_scan_of_a_box_is_its_size() {
    let grid = Grid::reference();
    let mut cell = reference();
    // Its faces lie in the middle of samples of 2.5 mm, well away from where rounding decides.
    let (x_m, y_m) = (0.16 + 0.00125, 0.12 + 0.00125);
    cell.place(&cuboid([0.08, 0.05, 0.04]), &at(x_m, y_m, 0.02))
        .unwrap();
    let surface = cell.scan_surface(&grid).unwrap();
    assert_eq!(covered(&surface), 33 * 21);
    let highest = surface.heights_m().iter().copied().fold(0.0, f32::max);
    assert!((highest - 0.04).abs() < 1e-3, "its height is {highest}");
    let scene = cell.scan(&grid).unwrap();
    assert_eq!(scene.surface(), Some(&surface));
    // 16.125 - 4 to 16.125 + 4 cm: nine cells; 12.125 - 2.5 to 12.125 + 2.5 cm: six.
    let cells = scene
        .heightmap()
        .heights()
        .iter()
        .filter(|height| **height > 2)
        .count();
    assert_eq!(cells, 9 * 6);
}

#[test]
fn a_scan_with_a_cache_equals_one_without() {
    let grid = Grid::reference();
    let mut cell = reference();
    for step in 0..6 {
        let turn = f64::from(step);
        let pose = turned(0.16 + 0.02 * turn.sin(), 0.16, 0.02 + 0.03 * turn, turn);
        cell.place(&cuboid([0.1, 0.05, 0.03]), &pose).unwrap();
        let cached = cell.scan_surface(&grid).unwrap();
        let mut fresh = reference();
        let bodies = cell.contents().into_iter();
        let poses: Vec<_> = bodies
            .map(|body| (body.model, body.container_from_item))
            .collect();
        fresh.lay_down(&poses).unwrap();
        assert_eq!(cached, fresh.scan_surface(&grid).unwrap());
    }
}

#[test]
fn another_grid_of_the_same_container_is_scanned_anew() {
    let coarse = Grid::reference();
    let resolution = Resolution::new(0.005, 0.001, Yaws::half_turn(8).unwrap()).unwrap();
    let fine = Grid::new(ContainerSize::REFERENCE, resolution).unwrap();
    let mut cell = reference();
    cell.place(&cuboid([0.08; 3]), &at(0.1, 0.1, 0.04)).unwrap();
    let surface = cell.scan_surface(&coarse).unwrap();
    let scene = cell.scan(&fine).unwrap();
    assert_eq!(scene.surface().unwrap().heights_m(), surface.heights_m());
    assert_eq!(cell.scan_surface(&coarse).unwrap(), surface);
}

#[test]
fn a_grid_of_another_container_is_refused() {
    let container = ContainerSize {
        x_m: 0.4,
        ..ContainerSize::REFERENCE
    };
    let grid = Grid::new(container, Resolution::reference()).unwrap();
    assert!(matches!(
        reference().scan(&grid),
        Err(PhysicsError::Grid { .. })
    ));
}

#[test]
fn what_lies_on_the_rim_is_seen_within_the_walls_only() {
    let grid = Grid::reference();
    let mut cell = reference();
    cell.place(&cuboid([0.36, 0.36, 0.02]), &at(0.16, 0.16, 0.31))
        .unwrap();
    let surface = cell.scan_surface(&grid).unwrap();
    assert!(
        surface
            .heights_m()
            .iter()
            .all(|height_m| (0.31..0.33).contains(height_m))
    );
}
