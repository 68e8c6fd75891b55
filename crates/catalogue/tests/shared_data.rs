//! Real objects, where the shared data is there: the folder is too large and too variously licensed
//! to be part of the project.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic is a failing test"
)]

use std::sync::LazyLock;
use std::time::Instant;

use nalgebra::{Isometry3, Point3};
use ndarray::Array2;
use parry3d::math::Vector;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings, Source};
use ppnpack_catalogue::convex::{MAX_PIECE_VERTICES, MAX_PIECES};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_packing::grid::Resolution;
use ppnpack_packing::item::ABSENT;

#[path = "../../packing/tests/golden/cases.rs"]
mod golden;
#[path = "../../../tests/shared.rs"]
mod shared;

use shared::shared;

fn loaded(folder: &str, cache: CacheDir) -> Option<Catalogue> {
    let source = Source::Folder(shared(folder)?);
    let settings = Settings {
        cache,
        ..Settings::default()
    };
    Some(Catalogue::load(&source, &settings, &Resolution::reference(), &|_, _| ()).unwrap())
}

/// The 96 objects that sequences refer to, loaded cold once for all tests and then warm.
static OBJECTS: LazyLock<Option<Catalogue>> = LazyLock::new(|| {
    let directory = tempfile::tempdir().unwrap();
    let cache = || CacheDir::At(directory.path().to_owned());
    let start = Instant::now();
    let cold = loaded("data/ycb_apc", cache())?;
    let cold_time = start.elapsed();
    let start = Instant::now();
    let warm = loaded("data/ycb_apc", cache())?;
    eprintln!(
        "{} objects: cold {cold_time:?}, warm {:?}",
        cold.len(),
        start.elapsed()
    );
    assert_eq!(cold.content_hash(), warm.content_hash());
    Some(warm)
});

#[test]
fn every_object_has_pieces_poses_and_views() {
    let Some(catalogue) = &*OBJECTS else { return };
    assert_eq!(catalogue.len(), 96);
    for object in &catalogue.objects {
        let model = &object.model;
        eprintln!(
            "{:42} {:6.1} cm3 {:2} pieces {:3} poses {:6} voxels",
            model.name,
            model.volume_m3 * 1e6,
            model.pieces.len(),
            model.resting_poses.len(),
            object.item.views()[0].voxel_count(),
        );
        assert!(
            (1..=MAX_PIECES).contains(&model.pieces.len()),
            "{}",
            model.name
        );
        assert!(
            model
                .pieces
                .iter()
                .all(|piece| piece.vertices.len() <= MAX_PIECE_VERTICES)
        );
        assert!(!model.resting_poses.is_empty());
        assert_eq!(object.item.views().len(), 4);
    }
}

#[test]
fn vessels_stay_hollow() {
    let Some(catalogue) = &*OBJECTS else { return };
    for (name, most) in [
        ("024_bowl", 0.35),
        ("025_mug", 0.65),
        ("029_plate", 0.4),
        ("065-j_cups", 0.4),
    ] {
        let (_, object) = catalogue.find(name).unwrap();
        let total_m3: f64 = object
            .model
            .pieces
            .iter()
            .map(|piece| volume_m3(&piece.vertices))
            .sum();
        let share = total_m3 / volume_m3(&object.model.mesh.vertices);
        eprintln!("{name}: pieces have {share:.2} of the hull");
        assert!(share < most, "{name}: {share}");
    }
}

/// The volume of the hull of points, in cubic metres.
fn volume_m3(points: &[Point3<f64>]) -> f64 {
    // parry's hull takes points of a size near one.
    let scaled: Vec<_> = points
        .iter()
        .map(|point| Vector::new(point.x as f32, point.y as f32, point.z as f32) * 10.0)
        .collect();
    let (vertices, triangles) = parry3d::transformation::convex_hull(&scaled);
    let vertices = vertices
        .iter()
        .map(|at| Point3::new(at.x, at.y, at.z).map(f64::from) * 0.1)
        .collect();
    Mesh {
        vertices,
        triangles,
    }
    .signed_volume_m3()
}

#[test]
fn unseen_objects_load() {
    let Some(catalogue) = loaded("data/unseen", CacheDir::Nowhere) else {
        return;
    };
    assert_eq!(catalogue.len(), 28);
}

#[test]
fn voxels_agree_with_the_reference() {
    let Some(catalogue) = &*OBJECTS else { return };
    let cases = golden::cases();
    assert_eq!(cases.len(), 40);
    for case in cases {
        let (yaw, top, bottom) = (case.yaw, case.top, case.bottom);
        let columns = || top.iter().zip(&bottom).filter(|(_, bottom)| **bottom >= 0);
        let voxels: i64 = columns().map(|(top, bottom)| i64::from(top - bottom)).sum();
        // The cases do not name their objects: each is found by its shape.
        let alike = |ours: &[i16], theirs: &Array2<i16>| {
            ours.iter()
                .zip(theirs)
                .filter(|(a, b)| (**a - **b).abs() <= 1)
                .count() as f64
                / theirs.len() as f64
        };
        let best = catalogue
            .objects
            .iter()
            .filter_map(|object| {
                let view = object.item.views().get(yaw)?;
                (top.dim() == (view.nx(), view.ny())).then(|| {
                    (
                        alike(view.bottom(), &bottom),
                        &object.model.name,
                        view.voxel_count(),
                    )
                })
            })
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let (share, name, ours) = best.expect("no object has the footprint of a case");
        eprintln!("{name:42} yaw {yaw}: {share:.3} of cells alike, {ours} voxels for {voxels}");
        assert!(share > 0.94, "{name}");
        // Ours count every cell that is touched, the reference those whose samples are.
        let ratio = ours as f64 / voxels as f64;
        assert!((0.99..1.1).contains(&ratio), "{name}: {ratio}");
    }
}

/// The heights at which a vertical line passes the surface, ascending.
fn crossings(mesh: &Mesh, x: f64, y: f64) -> Vec<f64> {
    let mut heights: Vec<f64> = mesh
        .corners()
        .filter_map(|[a, b, c]| {
            let cross =
                |a: Point3<f64>, b: Point3<f64>| (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
            let shares = [cross(b, c), cross(c, a), cross(a, b)];
            let whole: f64 = shares.iter().sum();
            let inside = shares.iter().all(|share| share / whole > 0.0);
            inside.then(|| (shares[0] * a.z + shares[1] * b.z + shares[2] * c.z) / whole)
        })
        .collect();
    heights.sort_by(f64::total_cmp);
    heights
}

#[test]
fn views_hold_the_surface_and_no_more_than_a_cell_around_it() {
    let Some(catalogue) = &*OBJECTS else { return };
    let (cell_m, unit_m) = (0.01, 0.002);
    for index in [5, 31, 60, 64, 80, 92] {
        let object = catalogue.get(index).unwrap();
        for (view, yaw_rad) in object
            .item
            .views()
            .iter()
            .zip(catalogue.resolution.yaws().radians())
        {
            let rotation =
                nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), *yaw_rad);
            let pose = Isometry3::from_parts(view.origin_from_corner_m().into(), rotation);
            let mesh = object.model.mesh.transformed(&pose);
            for (x, y) in (0..view.nx()).flat_map(|x| (0..view.ny()).map(move |y| (x, y))) {
                let (top, bottom) = (
                    view.top()[x * view.ny() + y],
                    view.bottom()[x * view.ny() + y],
                );
                for step in 0..25 {
                    let at = |cell: usize, step: i32| {
                        (cell as f64 + 0.1 + 0.2 * f64::from(step)) * cell_m
                    };
                    let heights = crossings(&mesh, at(x, step / 5), at(y, step % 5));
                    let (Some(low), Some(high)) = (heights.first(), heights.last()) else {
                        continue;
                    };
                    assert_ne!(bottom, ABSENT, "{} ({x}, {y})", object.model.name);
                    assert!(f64::from(bottom) * unit_m <= low + 1e-6);
                    assert!(f64::from(top) * unit_m >= high - 1e-6);
                }
            }
        }
    }
}
