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
use ppnpack_recognition::recognise::{Recogniser, Recognition};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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

/// Shows objects in each of their resting poses of at least 2 %, twice, to who knows those of `known`.
fn measure(what: &str, shown: &[Arc<Model>], recogniser: &Recogniser, are_known: bool) {
    let library = recogniser.library();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let [mut views, mut known, mut right, mut placed, mut same] = [0; 5];
    for (index, model) in shown.iter().enumerate() {
        let poses = 0..model.resting_poses.len();
        for pose in poses.filter(|pose| model.resting_poses[*pose].probability >= 0.02) {
            for _ in 0..2 {
                let mut at = |low, high| random.random_range(low..high);
                let truth = at_rest(
                    model,
                    pose,
                    at(0.0, std::f64::consts::TAU),
                    at(-0.12, 0.12),
                    at(-0.08, 0.08),
                );
                let clusters = segmented(&[(model, truth)], &NoiseModel::default()).clusters;
                views += 1;
                let found = clusters
                    .first()
                    .map(|cluster| recogniser.recognise(cluster));
                let Some(Recognition::Known(found)) = found else {
                    continue;
                };
                known += 1;
                let (object, pose) = (found.best.object, &found.best.world_from_item);
                let error = library
                    .pose_error(index, &truth, object, pose)
                    .filter(|_| are_known);
                if let Some(error) = error {
                    right += 1;
                    let is_placed = error.is_within(0.003, 3_f64.to_radians());
                    placed += usize::from(is_placed);
                    let looks_same = library.looks_same_from_above(index, &truth, object, pose);
                    same += usize::from(is_placed || looks_same);
                }
            }
        }
    }
    println!(
        "{what}: of {views} views {known} called known, {right} rightly; of these {placed} within 3 mm and 3 degrees, {same} or alike"
    );
}

#[test]
#[ignore = "a measurement, of some minutes: with --release, --ignored and --no-capture"]
fn all_objects_and_strangers_are_shown_from_above() {
    let folders = ["data/ycb_apc", "data/unseen"].map(shared::shared);
    let [Some(known), Some(strangers)] = folders else {
        return;
    };
    let known = models(&known);
    let recogniser = recogniser(&known);
    measure("known objects", &known, &recogniser, true);
    measure("strangers", &models(&strangers), &recogniser, false);
}
