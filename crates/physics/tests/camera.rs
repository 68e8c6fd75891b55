//! What depth cameras above the container see.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

mod common;

use common::{at, ball, cuboid};
use nalgebra::{Isometry3, Point3};
use ppnpack_packing::grid::{ContainerSize, Grid};
use ppnpack_physics::camera::{DepthCamera, DepthNoise, Lens};
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::error::PhysicsError;
use ppnpack_physics::settings::CellSettings;

const HEIGHT_M: f64 = 1.0;
const MARGIN_M: f64 = 0.0005;

fn cell_with_box() -> SimulatedCell {
    let mut cell = SimulatedCell::new(CellSettings::default()).unwrap();
    cell.place(&cuboid([0.1, 0.08, 0.06]), &at(0.16, 0.16, 0.03))
        .unwrap();
    cell
}

fn pinhole() -> DepthCamera {
    DepthCamera::pinhole_above(ContainerSize::REFERENCE, HEIGHT_M, 640, 480).unwrap()
}

#[test]
fn the_depth_of_the_floor_is_the_cameras_height() {
    let grid = Grid::reference();
    let cell = SimulatedCell::new(CellSettings::default()).unwrap();
    let parallel = cell
        .render(&DepthCamera::parallel_above(&grid, HEIGHT_M))
        .unwrap();
    assert_eq!(
        (parallel.camera().width_px, parallel.camera().height_px),
        (128, 128)
    );
    assert!(
        parallel
            .depths_m()
            .iter()
            .all(|depth_m| (depth_m - 1.0).abs() < 1e-6)
    );

    let image = cell.render(&pinhole()).unwrap();
    let middle = image.depth_m(320, 240).unwrap();
    assert!((middle - 1.0).abs() < 1e-6, "{middle}");
    // The rim and the walls' upper faces are 0.3 m nearer; beyond them there is nothing.
    let nearest = image
        .depths_m()
        .iter()
        .copied()
        .fold(f32::INFINITY, f32::min);
    assert!((nearest - 0.7).abs() < 1e-6, "{nearest}");
    assert_eq!(image.depth_m(0, 240), None);
    assert_eq!(image.depth_m(640, 240), None);
}

#[test]
fn pinhole_and_parallel_cameras_agree_on_flat_tops() {
    let grid = Grid::reference();
    let cell = cell_with_box();
    let parallel = cell
        .render(&DepthCamera::parallel_above(&grid, HEIGHT_M))
        .unwrap();
    let parallel = parallel.to_surface(&grid, MARGIN_M).unwrap();
    let pinhole = cell
        .render(&pinhole())
        .unwrap()
        .to_surface(&grid, MARGIN_M)
        .unwrap();
    let at = |x: usize, y: usize| x * parallel.ny() + y;
    for (x, y) in [(64, 64), (50, 56), (78, 72), (10, 64), (120, 120), (64, 8)] {
        let (a, b) = (
            parallel.heights_m()[at(x, y)],
            pinhole.heights_m()[at(x, y)],
        );
        assert!((a - b).abs() < 1e-4, "({x}, {y}): {a} and {b}");
    }
    assert!((parallel.heights_m()[at(64, 64)] - 0.06).abs() < 1e-3);
}

#[test]
fn the_surface_seen_never_exceeds_the_scan() {
    let grid = Grid::reference();
    let mut cell = cell_with_box();
    cell.place(&ball(0.03), &at(0.06, 0.06, 0.03)).unwrap();
    let image = cell
        .render(&DepthCamera::parallel_above(&grid, HEIGHT_M))
        .unwrap();
    let seen = image.to_surface(&grid, 0.0).unwrap();
    let scanned = cell.scan_surface(&grid).unwrap();
    for (seen, scanned) in seen.heights_m().iter().zip(scanned.heights_m()) {
        assert!(*seen <= scanned + 1e-6, "{seen} is above {scanned}");
        assert!(*seen > 0.0 || *scanned < 0.061);
    }
    let scene = image.to_scene(&grid, 0.0).unwrap();
    let highest = cell.scan(&grid).unwrap().heightmap().max();
    assert!(scene.heightmap().max() <= highest && scene.heightmap().max() >= highest - 1);
}

#[test]
fn the_point_cloud_lies_on_what_is_seen() {
    let cell = cell_with_box();
    let image = cell.render(&pinhole()).unwrap();
    let cloud = image.to_point_cloud();
    let seen = image
        .depths_m()
        .iter()
        .filter(|depth_m| !depth_m.is_nan())
        .count();
    assert_eq!(cloud.points_m.len(), seen);
    assert!(
        cloud
            .points_m
            .iter()
            .all(|point| point.z > 0.69 && point.z < 1.001)
    );
    let on_top = cloud
        .in_container_m()
        .filter(|point| (point.z - 0.06).abs() < 1e-3)
        .filter(|point| (point.x - 0.16).abs() < 0.051 && (point.y - 0.16).abs() < 0.041)
        .count();
    // fx = fy = 0.95 * 0.7 * 480 / 0.32 pixels; the box's top is 0.94 m away.
    let px_per_m = 0.95 * 0.7 * 480.0 / 0.32 / 0.94;
    let expected = 0.1 * 0.08 * px_per_m * px_per_m;
    assert!(
        (on_top as f64 / expected - 1.0).abs() < 0.05,
        "{on_top} and {expected}"
    );
}

#[test]
fn noise_is_reproducible_and_as_asked() {
    let cell = SimulatedCell::new(CellSettings::default()).unwrap();
    let ideal = cell
        .render(&DepthCamera::parallel_above(&Grid::reference(), HEIGHT_M))
        .unwrap();
    let noise = DepthNoise {
        sigma_m: 0.002,
        dropout: 0.1,
        step_m: 0.0,
    };
    let noisy = ideal.with_noise(&noise, 3).unwrap();
    let bits = |image: &ppnpack_physics::camera::DepthImage| {
        image
            .depths_m()
            .iter()
            .map(|depth_m| depth_m.to_bits())
            .collect::<Vec<_>>()
    };
    assert!(bits(&noisy) == bits(&ideal.with_noise(&noise, 3).unwrap()));
    assert!(bits(&noisy) != bits(&ideal.with_noise(&noise, 4).unwrap()));

    let seen: Vec<f64> = noisy
        .depths_m()
        .iter()
        .filter(|d| !d.is_nan())
        .map(|d| f64::from(*d))
        .collect();
    let count = seen.len() as f64;
    assert!((count / 16384.0 - 0.9).abs() < 0.01, "{count} are left");
    let mean = seen.iter().sum::<f64>() / count;
    let sigma = (seen.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / count).sqrt();
    assert!(
        (mean - 1.0).abs() < 1e-4 && (sigma - 0.002).abs() < 1e-4,
        "{mean} {sigma}"
    );

    let steps = DepthNoise {
        sigma_m: 0.01,
        dropout: 0.0,
        step_m: 0.25,
    };
    let stepped = ideal.with_noise(&steps, 1).unwrap();
    assert!(stepped.depths_m().iter().all(|depth_m| *depth_m == 1.0));

    let impossible = DepthNoise {
        dropout: 1.5,
        ..noise
    };
    assert!(matches!(
        ideal.with_noise(&impossible, 1),
        Err(PhysicsError::Setting { .. })
    ));
}

#[test]
fn squares_that_no_pixel_saw_take_the_highest_neighbour() {
    let grid = Grid::reference();
    let cell = cell_with_box();
    let image = cell
        .render(&DepthCamera::parallel_above(&grid, HEIGHT_M))
        .unwrap();
    let sparse = DepthNoise {
        dropout: 0.3,
        ..DepthNoise::default()
    };
    let holes = image
        .with_noise(&sparse, 9)
        .unwrap()
        .to_surface(&grid, 0.0)
        .unwrap();
    let whole = image.to_surface(&grid, 0.0).unwrap();
    for (filled, seen) in holes.heights_m().iter().zip(whole.heights_m()) {
        assert!(
            filled >= seen,
            "a hole is filled with {filled}, and was {seen}"
        );
    }
    let blind = DepthNoise {
        dropout: 1.0,
        ..DepthNoise::default()
    };
    let nothing = image.with_noise(&blind, 9).unwrap().to_surface(&grid, 0.0);
    assert_eq!(nothing.unwrap_err(), PhysicsError::NothingSeen);
}

#[test]
fn pixels_see_what_projects_onto_them() {
    let camera = pinhole();
    let Lens::Pinhole { fx_px, cx_px, .. } = camera.lens else {
        panic!("it is a pinhole")
    };
    let point = camera.unproject(400.0, 100.0, 0.8);
    assert!((fx_px * point.x / point.z + cx_px - 400.0).abs() < 1e-9);
    let in_container = camera.container_from_camera * Point3::new(0.0, 0.0, 0.8);
    assert!((in_container - Point3::new(0.16, 0.16, 0.2)).norm() < 1e-9);
    // Columns run along x, rows against y.
    let moved = camera.container_from_camera * point;
    assert!(moved.x > 0.16 && moved.y > 0.16);
}

#[test]
fn a_camera_inside_the_content_sees_only_what_is_in_front() {
    let cell = cell_with_box();
    let mut camera = pinhole();
    camera.container_from_camera.translation.z = 0.03;
    let image = cell.render(&camera).unwrap();
    assert!(
        image
            .depths_m()
            .iter()
            .all(|d| d.is_nan() || (*d > 0.0 && *d < 0.5))
    );
    camera.far_m = 0.02;
    let short = cell.render(&camera).unwrap();
    assert!(short.depths_m().iter().all(|d| d.is_nan() || *d <= 0.02));
}

#[test]
fn impossible_cameras_are_refused() {
    let cell = cell_with_box();
    let refused = |change: fn(&mut DepthCamera)| {
        let mut camera = pinhole();
        change(&mut camera);
        cell.render(&camera).unwrap_err()
    };
    let is_setting = |error: PhysicsError| matches!(error, PhysicsError::Setting { .. });
    assert!(is_setting(refused(|camera| camera.width_px = 0)));
    assert!(is_setting(refused(|camera| camera.height_px = 1 << 40)));
    assert!(is_setting(refused(|camera| camera.near_m = f64::NAN)));
    assert!(is_setting(refused(|camera| camera.far_m = 0.0)));
    assert!(is_setting(refused(
        |camera| camera.lens = Lens::Parallel { pitch_m: -1.0 }
    )));
    let lost = Isometry3::translation(f64::NAN, 0.0, 0.0);
    let mut camera = pinhole();
    camera.container_from_camera = lost;
    assert_eq!(cell.render(&camera).unwrap_err(), PhysicsError::CameraPose);
    let size = ContainerSize::REFERENCE;
    assert!(is_setting(
        DepthCamera::pinhole_above(size, 0.2, 640, 480).unwrap_err()
    ));
}
