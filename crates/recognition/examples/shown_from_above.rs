//! How well real objects, and others that it does not know, are recognised from above. It takes some minutes:
//!
//! ```text
//! cargo run --release -p ppnpack-recognition --example shown_from_above
//! ```

#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::print_stdout,
    reason = "a measurement over the simulated views of the tests, which have more than it uses"
)]

#[path = "../tests/all/common/mod.rs"]
mod common;
#[path = "../../../tests/shared.rs"]
mod shared;

use std::sync::Arc;

use common::{at_rest, folder, recogniser, segmented};
use ppnpack_camera::NoiseModel;
use ppnpack_catalogue::object::Model;
use ppnpack_recognition::recognise::{Recogniser, Recognition};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn main() {
    let folders = ["data/ycb_apc", "data/unseen"].map(shared::shared);
    let [Some(known), Some(strangers)] = folders else {
        return;
    };
    let known = folder(&known);
    let recogniser = recogniser(&known);
    measure("known objects", &known, &recogniser, true);
    measure("strangers", &folder(&strangers), &recogniser, false);
}

/// Shows objects in each of their resting poses of at least 2 %, twice, to who knows those of `known`.
fn measure(what: &str, shown: &[Arc<Model>], recogniser: &Recogniser, are_known: bool) {
    let library = recogniser.library();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let [mut views, mut known, mut right, mut placed] = [0; 4];
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
                    placed += usize::from(error.is_within(0.003, 3_f64.to_radians()));
                }
            }
        }
    }
    println!(
        "{what}: of {views} views {known} called known, {right} rightly; of these {placed} within 3 mm and 3 degrees"
    );
}
