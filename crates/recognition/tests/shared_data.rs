//! Real objects, where the shared data is there: some easy, some small, some thin.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic is a failing test"
)]

mod common;
#[path = "../../../tests/shared.rs"]
mod shared;

use std::path::Path;
use std::sync::Arc;

use common::{at_rest, recogniser, segmented};
use ppnpack_camera::NoiseModel;
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings, Source};
use ppnpack_catalogue::object::Model;
use ppnpack_packing::grid::Resolution;
use ppnpack_recognition::recognise::Recognition;

const FILES: [&str; 8] = [
    "09_042_adjustable_wrench.ply",
    "17_038_padlock.ply",
    "36_009_gelatin_box.ply",
    "46_011_banana.ply",
    "64_025_mug.ply",
    "65_005_tomato_soup_can.ply",
    "79_006_mustard_bottle.ply",
    "80_004_sugar_box.ply",
];

/// The objects of a folder.
fn models(folder: &Path) -> Vec<Arc<Model>> {
    let settings = Settings {
        cache: CacheDir::Nowhere,
        ..Settings::default()
    };
    let source = Source::Folder(folder.to_owned());
    let catalogue =
        Catalogue::load(&source, &settings, &Resolution::reference(), &|_, _| ()).unwrap();
    catalogue.models()
}

#[test]
fn real_objects_are_recognised_in_noisy_views() {
    let Some(shared) = shared::shared("data/ycb_apc") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for file in FILES {
        std::fs::copy(shared.join(file), folder.path().join(file)).unwrap();
    }
    let models = models(folder.path());
    let recogniser = recogniser(&models);
    let (mut views, mut unknown) = (0, 0);
    for (index, model) in models.iter().enumerate() {
        for pose in 0..model.resting_poses.len().min(2) {
            let truth = at_rest(model, pose, 0.9 + index as f64, 0.04, -0.03);
            let clusters = segmented(&[(model, truth)], &NoiseModel::default()).clusters;
            views += 1;
            let best = match recogniser.recognise(&clusters[0]) {
                Recognition::Known(known) => known.best,
                Recognition::Unknown(mut other) => {
                    unknown += 1;
                    other.candidates.remove(0)
                }
            };
            assert_eq!(best.name, model.name);
            let error = recogniser
                .library()
                .pose_error(index, &truth, best.object, &best.world_from_item)
                .unwrap();
            assert!(
                error.position_m < 0.005,
                "{} in pose {pose}: {error:?}",
                model.name
            );
        }
    }
    assert!(
        views >= 14 && unknown <= 1,
        "{unknown} of {views} are unknown"
    );
}
