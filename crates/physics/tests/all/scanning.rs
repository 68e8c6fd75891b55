//! What a scan from above shows.
use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::checks::check::Evidence;
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::scene::Scene;
use ppnpack_packing::streams::episode::PackingCell;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::error::PhysicsError;
use ppnpack_physics::packing_cell::{PoseError, Sampling, SimulatedPackingCell};
use ppnpack_physics::settings::CellSettings;

use crate::common::{at, cuboid, placed, poses, put, reference, turned};

/// The samples higher than half a centimetre.
fn covered(surface: &Surface) -> usize {
    let heights_m = surface.heights_m().iter();
    heights_m.filter(|height_m| **height_m > 0.005).count()
}

#[test]
fn an_empty_container_is_flat() {
    let grid = Grid::reference();
    let surface = reference().scan_surface(&grid).unwrap();
    assert_eq!(surface, Surface::empty(&grid));
}

#[test]
fn the_scan_of_a_box_is_its_size() {
    let grid = Grid::reference();
    let mut cell = reference();
    // Its faces lie in the middle of samples of 2.5 mm, well away from where rounding decides.
    let (x_m, y_m) = (0.16 + 0.00125, 0.12 + 0.00125);
    put(&mut cell, &cuboid([0.08, 0.05, 0.04]), at(x_m, y_m, 0.02));
    let surface = cell.scan_surface(&grid).unwrap();
    assert_eq!(covered(&surface), 33 * 21);
    let highest = surface.heights_m().iter().copied().fold(0.0, f32::max);
    assert!((highest - 0.04).abs() < 1e-3, "its height is {highest}");
    let scene = cell.scan(&grid).unwrap();
    assert_eq!(scene.surface(), Some(&surface));
    // 16.125 - 4 to 16.125 + 4 cm: nine cells; 12.125 - 2.5 to 12.125 + 2.5 cm: six.
    let heights = scene.heightmap().heights().iter();
    assert_eq!(heights.filter(|height| **height > 2).count(), 9 * 6);
}

/// Drops one more plate on the pile; gives a cell in which the same lies that was never scanned.
fn pile_up(cell: &mut SimulatedCell, step: u32) -> SimulatedCell {
    let turn = f64::from(step);
    let pose = turned(0.16 + 0.02 * turn.sin(), 0.16, 0.02 + 0.03 * turn, turn);
    cell.place(&cuboid([0.1, 0.05, 0.03]), &pose).unwrap();
    let mut fresh = reference();
    fresh.lay_down(&poses(cell)).unwrap();
    fresh
}

#[test]
fn a_scan_with_a_cache_equals_one_without() {
    let grid = Grid::reference();
    let mut cell = reference();
    for step in 0..6 {
        let mut fresh = pile_up(&mut cell, step);
        let cached = cell.scan_surface(&grid).unwrap();
        assert_eq!(cached, fresh.scan_surface(&grid).unwrap());
    }
}

#[test]
fn another_grid_of_the_same_container_is_scanned_anew() {
    let coarse = Grid::reference();
    let resolution = Resolution::new(0.005, 0.001, Yaws::half_turn(8).unwrap()).unwrap();
    let fine = Grid::new(ContainerSize::REFERENCE, resolution).unwrap();
    let mut cell = reference();
    put(&mut cell, &cuboid([0.08; 3]), at(0.1, 0.1, 0.04));
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
    let refused = reference().scan(&grid);
    assert!(matches!(refused, Err(PhysicsError::Grid { .. })));
}

#[test]
fn what_lies_on_the_rim_is_seen_within_the_walls_only() {
    let grid = Grid::reference();
    let mut cell = reference();
    put(&mut cell, &cuboid([0.36, 0.36, 0.02]), at(0.16, 0.16, 0.31));
    let surface = cell.scan_surface(&grid).unwrap();
    let mut heights_m = surface.heights_m().iter();
    assert!(heights_m.all(|height_m| (0.31..0.33).contains(height_m)));
}

/// A cell with three cubes, of whose poses its scans know only so much.
fn cell_of_cubes(seed: u64, pose_error: PoseError) -> SimulatedPackingCell {
    with_cubes(empty_cell(seed).with_pose_error(pose_error))
}

fn empty_cell(seed: u64) -> SimulatedPackingCell {
    let settings = CellSettings {
        seed,
        ..CellSettings::default()
    };
    let catalogue = Catalogue {
        objects: Vec::new(),
        resolution: Resolution::reference(),
    };
    SimulatedPackingCell::new(settings, &Grid::reference(), &catalogue, Sampling::Greatest).unwrap()
}

fn with_cubes(mut cell: SimulatedPackingCell) -> SimulatedPackingCell {
    let view = ViewSurfaces {
        origin_from_corner_m: Vector3::repeat(0.02),
        ..ViewSurfaces::of_cells(4, 4, vec![20; 16], vec![0; 16])
    };
    let item = Arc::new(Item::new("cube", vec![view; 4], 0.0).unwrap());
    let model = cuboid([0.04; 3]);
    for (arrival, x) in [4, 12, 20].into_iter().enumerate() {
        let cube = Candidate::new(arrival, Arc::clone(&item)).with_model(Arc::clone(&model));
        let placed = cell.place(&cube, &placed(x, 10, 0), &Evidence::default());
        placed.unwrap();
    }
    cell
}

/// The poses of the content as a scene tells them.
fn told(scene: &Scene) -> Vec<Isometry3<f64>> {
    let content = scene.content().unwrap().solids().iter();
    content.map(|solid| solid.container_from_item).collect()
}

fn real(cell: &SimulatedPackingCell) -> Vec<Isometry3<f64>> {
    let contents = cell.contents().into_iter();
    contents.map(|(_, body)| body.container_from_item).collect()
}

#[test]
fn a_scan_tells_what_lies_there_and_where() {
    let mut cell = cell_of_cubes(0, PoseError::default());
    let scene = cell.scan().unwrap();
    assert_eq!(told(&scene).len(), 3);
    assert_eq!(told(&scene), real(&cell));
    let solids = scene.content().unwrap().solids().iter();
    for (solid, (_, body)) in solids.zip(cell.contents()) {
        assert!(Arc::ptr_eq(&solid.model, &body.model));
    }
}

#[test]
fn poses_that_are_not_quite_known_are_told_with_their_error() {
    let exact = cell_of_cubes(3, PoseError::default()).scan().unwrap();
    for (position_m, rotation_rad) in [(0.003, 0.02), (0.003, 0.0), (0.0, 0.02)] {
        let pose_error = PoseError {
            position_m,
            rotation_rad,
        };
        let mut cell = cell_of_cubes(3, pose_error);
        for _ in 0..20 {
            let scene = cell.scan().unwrap();
            for (told, real) in told(&scene).iter().zip(real(&cell)) {
                // The errors are normal: 6 deviations along an axis are as good as never exceeded.
                let moved = told.translation.vector - real.translation.vector;
                assert!(moved.amax() <= 6.0 * position_m, "{moved}");
                assert_eq!(moved.amax() > 0.0, position_m > 0.0);
                let turned = (told.rotation * real.rotation.inverse()).scaled_axis();
                assert!(turned.amax() < 6.0 * rotation_rad + 1e-9, "{turned}");
                assert_eq!(turned.amax() > 1e-6, rotation_rad > 0.0);
            }
            // What is seen from above is seen as it is.
            assert_eq!(scene.surface(), exact.surface());
            assert_eq!(scene.heightmap(), exact.heightmap());
        }
    }
}

#[test]
fn the_errors_of_poses_follow_from_the_seed() {
    let pose_error = PoseError {
        position_m: 0.003,
        rotation_rad: 0.02,
    };
    let scans = |seed: u64| {
        let mut cell = cell_of_cubes(seed, pose_error);
        [(); 2].map(|()| told(&cell.scan().unwrap()))
    };
    let expected = scans(7);
    assert_eq!(scans(7), expected);
    assert_ne!(scans(8), expected);
    assert_ne!(expected[0], expected[1], "each scan errs anew");
}
