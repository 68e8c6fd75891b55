//! A tote whose walls lean outwards, with round corners.

use nalgebra::Isometry3;
use ppnpack_packing::checks::trial::TrialLimits;
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::scene::Scene;
use ppnpack_packing::scene::content::Content;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::twin::{Twin, TwinSettings};
use ppnpack_physics::view::{CameraSettings, CameraView};

use crate::common::{at, ball, cuboid, put, turned};

/// 36 x 32 x 30 cm at the rim, 3 degrees, corners of 3 cm.
fn tote() -> ContainerSize {
    ContainerSize {
        draft_rad: 3.0_f64.to_radians(),
        corner_radius_m: 0.03,
        ..ContainerSize::cuboid(0.36, 0.32, 0.3)
    }
}

fn grid() -> Grid {
    let resolution = Resolution::new(0.0025, 0.002, Yaws::half_turn(4).unwrap());
    Grid::new(tote(), resolution.unwrap()).unwrap()
}

fn cell() -> SimulatedCell {
    SimulatedCell::new(CellSettings {
        container: tote(),
        ..CellSettings::robot()
    })
    .unwrap()
}

/// How far the corners of a box reach beyond the walls, in metres.
fn cut_m(sides_m: [f64; 3], container_from_item: &Isometry3<f64>) -> f64 {
    let mesh = &cuboid(sides_m).mesh;
    let corners = mesh.vertices.iter();
    let beyond_m = corners.map(|corner| tote().beyond_walls_m(&(container_from_item * corner)));
    beyond_m.fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn the_scan_of_an_empty_tote_is_its_inside() {
    let mut cell = cell();
    assert_eq!(cell.scan_surface(&grid()).unwrap(), Surface::empty(&grid()));
    let model = cuboid([0.08, 0.05, 0.04]);
    put(&mut cell, &model, at(0.18, 0.16, 0.02));
    let scanned = cell.scan_surface(&grid()).unwrap();
    // The same again, from the cache of what has not moved.
    assert_eq!(cell.scan_surface(&grid()).unwrap(), scanned);
    let empty = Surface::empty(&grid());
    let pairs = scanned.heights_m().iter().zip(empty.heights_m());
    let raised = pairs
        .filter(|(height_m, empty_m)| height_m > empty_m)
        .count();
    assert!((30 * 18..=34 * 22).contains(&raised), "{raised}");
}

#[test]
fn a_box_that_is_laid_down_beside_a_leaning_wall_stays_there_without_cutting_it() {
    let sides_m = [0.08, 0.1, 0.06];
    let model = cuboid(sides_m);
    let setback_m = tote().setback_m(0.0);
    // On the floor, against the wall, and on a box, where the wall is farther away.
    let mut cell = cell();
    let beside = put(&mut cell, &model, at(setback_m + 0.041, 0.16, 0.03));
    let higher = tote().setback_m(0.06);
    let on_top = put(&mut cell, &model, at(higher + 0.041, 0.16, 0.09));
    for report in [beside, on_top] {
        assert!(
            report.inside && report.still && !report.toppled,
            "{report:?}"
        );
        assert!(report.slide_m < 0.003, "{report:?}");
        assert!(
            cut_m(sides_m, &report.container_from_item) < 0.0005,
            "{report:?}"
        );
    }
    assert!(cell.deepest_overlap_m() < 0.0005);
}

#[test]
fn what_is_dropped_on_a_leaning_wall_or_a_round_corner_comes_to_rest_inside() {
    let sides_m = [0.05, 0.04, 0.06];
    for (x_m, y_m, yaw_rad) in [
        (0.026, 0.16, 0.0),
        (0.33, 0.16, 0.4),
        (0.18, 0.02, 0.0),
        (0.034, 0.034, 0.0),
        (0.325, 0.285, 0.8),
    ] {
        let mut cell = cell();
        let report = put(&mut cell, &cuboid(sides_m), turned(x_m, y_m, 0.25, yaw_rad));
        assert!(report.inside && !report.lost, "{x_m} {y_m}: {report:?}");
        let cut_m = cut_m(sides_m, &report.container_from_item);
        assert!(cut_m < 0.001, "{x_m} {y_m}: {cut_m}");
        assert!(cell.deepest_overlap_m() < 0.001, "{x_m} {y_m}");
    }
}

#[test]
fn nothing_passes_a_leaning_wall() {
    let mut cell = cell();
    for drop in 0..6 {
        let x_m = 0.03 + 0.05 * f64::from(drop);
        let report = put(&mut cell, &ball(0.025), at(x_m, 0.03, 0.28));
        assert!(!report.lost && report.others_lost.is_empty(), "{report:?}");
    }
    for body in cell.contents() {
        let centre = body.container_from_item.translation.vector.into();
        assert!(tote().beyond_walls_m(&centre) < -0.024, "{centre}");
    }
}

#[test]
fn a_twin_tries_placements_among_the_same_walls() {
    let settings = TwinSettings {
        cell: CellSettings {
            container: tote(),
            ..TwinSettings::default().cell
        },
        ..TwinSettings::default()
    };
    let mut twin = Twin::new(settings).unwrap();
    let solid = twin.solid(&cuboid([0.08, 0.1, 0.06])).unwrap();
    let empty = Scene::from_surface(&grid(), Surface::empty(&grid())).unwrap();
    assert!(twin.lay_down(&[]));
    twin.fill_up(&grid(), &empty).unwrap();
    let limits = TrialLimits::default();
    let beside = at(tote().setback_m(0.0) + 0.044, 0.16, 0.03);
    let settling = twin.try_placement(&solid, &beside, &limits).unwrap();
    assert!(settling.beyond(&limits).is_none(), "{settling:?}");
    // Over the wall's slope it is pushed away, or tilts.
    let on_wall = at(0.03, 0.16, 0.03);
    let settling = twin.try_placement(&solid, &on_wall, &limits).unwrap();
    assert!(settling.beyond(&limits).is_some(), "{settling:?}");
}

#[test]
fn a_camera_takes_no_wall_for_content_and_sees_what_lies_beside_it() {
    let grid = grid();
    let mut view = CameraView::new(&CameraSettings::default(), &grid).unwrap();
    let mut cell = cell();
    let empty = Surface::empty(&grid);
    let higher = |scene: &Scene, by_m: f32| {
        let seen = scene.surface().unwrap().heights_m().iter();
        let pairs = seen.zip(empty.heights_m());
        pairs
            .clone()
            .for_each(|(seen, empty)| assert!(seen >= empty));
        let higher = pairs.filter(|(seen, empty)| **seen > **empty + by_m);
        higher.count() as f64 / empty.heights_m().len() as f64
    };
    let scene = view.scene(&cell, Content::default()).unwrap();
    assert!(higher(&scene, 0.01) < 0.01, "{}", higher(&scene, 0.01));

    let sides_m = [0.08, 0.1, 0.06];
    let setback_m = tote().setback_m(0.0);
    let pose = at(setback_m + 0.041, 0.16, 0.03);
    assert!(put(&mut cell, &cuboid(sides_m), pose).inside);
    let seen = view.scene(&cell, Content::default()).unwrap();
    let covered = 0.08 * 0.1 / (0.36 * 0.32);
    let share = higher(&seen, 0.01);
    assert!(
        (0.9 * covered..1.5 * covered).contains(&share),
        "{share} {covered}"
    );
    // To its edge at the wall.
    let (x, y) = (((setback_m + 0.004) / 0.0025) as usize, 64);
    let top = seen.heightmap().get(x, y).unwrap();
    assert!((28..=34).contains(&top), "{top}");
}
