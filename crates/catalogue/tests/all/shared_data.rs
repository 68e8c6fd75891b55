//! Real objects, where the shared data is there: the folder is too large and too variously licensed
//! to be part of the project.

use std::sync::LazyLock;

use nalgebra::Point3;
use parry3d::math::Vector;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings, Source};
use ppnpack_catalogue::convex::{MAX_PIECE_VERTICES, MAX_PIECES};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_packing::kernel::grid::Resolution;

use crate::shared::shared;

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
    let (cold, warm) = (
        loaded("data/ycb_apc", cache())?,
        loaded("data/ycb_apc", cache())?,
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
        let (name, pieces) = (&model.name, &model.pieces);
        assert!((1..=MAX_PIECES).contains(&pieces.len()), "{name}");
        let mut few = pieces.iter().map(|piece| piece.vertices.len());
        assert!(few.all(|vertices| vertices <= MAX_PIECE_VERTICES), "{name}");
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
        let pieces = object.model.pieces.iter();
        let total_m3: f64 = pieces.map(|piece| volume_m3(&piece.vertices)).sum();
        let share = total_m3 / volume_m3(&object.model.mesh.vertices);
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
    let cases = crate::golden::cases();
    assert_eq!(cases.len(), 40);
    for case in cases {
        let (yaw, top, bottom) = (case.yaw, case.top, case.bottom);
        let columns = || top.iter().zip(&bottom).filter(|(_, bottom)| **bottom >= 0);
        let voxels: i64 = columns().map(|(top, bottom)| i64::from(top - bottom)).sum();
        // The cases do not name their objects: each is found by its shape.
        let alike = |ours: &[i16]| {
            let pairs = ours.iter().zip(&bottom);
            pairs.filter(|(a, b)| (**a - **b).abs() <= 1).count() as f64 / bottom.len() as f64
        };
        let objects = catalogue.objects.iter().filter_map(|object| {
            let view = object.item.views().get(yaw)?;
            let share = alike(view.bottom());
            let is_as_large = top.dim() == (view.nx(), view.ny());
            is_as_large.then(|| (share, &object.model.name, view.voxel_count()))
        });
        let best = objects.max_by(|a, b| a.0.total_cmp(&b.0));
        let (share, name, ours) = best.expect("no object has the footprint of a case");
        assert!(share > 0.94, "{name}");
        // Ours count every cell that is touched, the reference those whose samples are.
        let ratio = ours as f64 / voxels as f64;
        assert!((0.99..1.1).contains(&ratio), "{name}: {ratio}");
    }
}
