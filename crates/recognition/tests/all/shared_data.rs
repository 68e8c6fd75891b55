//! Real objects, where the shared data is there: some easy, some small, some thin.

use ppnpack_camera::NoiseModel;
use ppnpack_recognition::recognise::Recognition;

use crate::common::{at_rest, folder, recogniser, segmented};
use crate::shared::shared;

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

#[test]
fn real_objects_are_recognised_in_noisy_views() {
    let Some(all) = shared("data/ycb_apc") else {
        return;
    };
    let some = tempfile::tempdir().unwrap();
    for file in FILES {
        std::fs::copy(all.join(file), some.path().join(file)).unwrap();
    }
    let models = folder(some.path());
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
            let (library, found) = (recogniser.library(), &best.world_from_item);
            let error = library
                .pose_error(index, &truth, best.object, found)
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
