//! Objects found in simulated views, and clouds that are none.

use std::sync::LazyLock;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_camera::NoiseModel;
use ppnpack_recognition::recognise::{Known, Recogniser, Recognition, UnknownReason};
use ppnpack_recognition::segmentation::{Cluster, SegmentationSettings, segment};
use ppnpack_recognition::support::Support;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::common::{at_rest, models, recogniser, region, segmented, view};

static ALL: LazyLock<Recogniser> = LazyLock::new(|| recogniser(&models()));

fn known(recognition: Recognition) -> Box<Known> {
    match recognition {
        Recognition::Known(known) => known,
        Recognition::Unknown(unknown) => panic!("{unknown:?}"),
    }
}

/// Asks that an object was found within 3 mm and 3 degrees of the truth.
fn assert_near(object: usize, truth: &Isometry3<f64>, known: &Known) {
    let (best, library) = (&known.best, ALL.library());
    let error = library.pose_error(object, truth, best.object, &best.world_from_item);
    let is_near = error.is_some_and(|error| error.is_within(0.003, 3.0_f64.to_radians()));
    assert!(is_near, "{}: {error:?}", best.name);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn without_noise_the_pose_comes_back(
        object in 0..5_usize,
        pose in 0..3_usize,
        yaw_rad in 0.0..std::f64::consts::TAU,
        x_m in -0.12..0.12_f64,
        y_m in -0.08..0.08_f64,
    ) {
        let library = ALL.library();
        let model = &library.objects[object].model;
        let pose = pose.min(model.resting_poses.len() - 1);
        let truth = at_rest(model, pose, yaw_rad, x_m, y_m);
        let found = segmented(&[(model, truth)], &NoiseModel::none());
        prop_assert_eq!(found.clusters.len(), 1);
        let known = known(ALL.recognise(&found.clusters[0]));
        prop_assert_eq!(&known.best.name, &model.name);
        assert_near(object, &truth, &known);
        prop_assert!(known.best.agreement.fitness > 0.95);
        prop_assert!(known.margin > 0.0);
    }

    #[test]
    fn where_the_world_has_its_origin_changes_nothing(
        yaw_rad in 0.0..std::f64::consts::TAU,
        shift in prop::array::uniform3(-2.0..2.0_f64),
    ) {
        let library = ALL.library();
        let model = &library.objects[0].model;
        let truth = at_rest(model, 0, 0.4, 0.05, -0.03);
        let clusters = segmented(&[(model, truth)], &NoiseModel::default()).clusters;
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
        let other_from_world = Translation3::from(Vector3::from(shift)) * turn;
        let moved = Cluster { world_from_support: other_from_world * clusters[0].world_from_support, ..clusters[0].clone() };
        let (here, there) = (known(ALL.recognise(&clusters[0])), known(ALL.recognise(&moved)));
        prop_assert_eq!(here.best.object, there.best.object);
        let expected: Isometry3<f64> = other_from_world * here.best.world_from_item;
        let apart = expected.inverse() * there.best.world_from_item;
        prop_assert!(apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-6);
    }
}

#[test]
fn a_noisy_tray_of_several_objects_is_told_apart() {
    let library = ALL.library();
    let near = [-0.15, 0.0, 0.15].map(|x_m| (x_m, -0.08));
    let places = near.into_iter().chain([(-0.1, 0.1), (0.12, 0.1)]);
    let items = library.objects.iter().zip(places);
    let items = items.map(|(object, (x_m, y_m))| {
        let truth = at_rest(&object.model, 0, 1.0 + x_m, x_m, y_m);
        (&*object.model, truth)
    });
    let items: Vec<_> = items.collect();
    let found = segmented(&items, &NoiseModel::default());
    assert_eq!(found.clusters.len(), items.len());
    let recognised = found.clusters.iter().map(|cluster| {
        let known = known(ALL.recognise(cluster));
        let index = known.best.object;
        assert_near(index, &items[index].1, &known);
        index
    });
    let mut seen: Vec<usize> = recognised.collect();
    seen.sort_unstable();
    assert_eq!(seen, [0, 1, 2, 3, 4]);
}

#[test]
fn what_is_not_in_the_library_is_unknown() {
    let all = models();
    for left_out in 0..all.len() {
        let mut rest = all.clone();
        let stranger = rest.remove(left_out);
        let recogniser = recogniser(&rest);
        let truth = at_rest(&stranger, 0, 0.7, 0.02, 0.03);
        let clusters = segmented(&[(&stranger, truth)], &NoiseModel::default()).clusters;
        match recogniser.recognise(&clusters[0]) {
            Recognition::Unknown(unknown) => assert_ne!(unknown.reason, UnknownReason::FewPoints),
            Recognition::Known(known) => panic!("{} taken for {known:?}", stranger.name),
        }
    }
}

#[test]
fn items_that_touch_are_not_taken_for_one_of_them() {
    let library = ALL.library();
    let model = &library.objects[1].model;
    let items = [
        (&**model, at_rest(model, 0, 0.0, -0.06, 0.0)),
        (&**model, at_rest(model, 0, 1.2, 0.055, 0.0)),
    ];
    let clusters = segmented(&items, &NoiseModel::default()).clusters;
    assert_eq!(clusters.len(), 1);
    let found = ALL.recognise(&clusters[0]);
    assert!(matches!(found, Recognition::Unknown(_)));
}

#[test]
fn a_leaning_support_is_found() {
    let library = ALL.library();
    let model = &library.objects[0].model;
    let truth = at_rest(model, 0, 2.0, 0.02, 0.01);
    let (points, eye) = view(&[(model, truth)], &NoiseModel::default());
    let lean = UnitQuaternion::from_scaled_axis(Vector3::new(0.08, -0.05, 0.0));
    let world_from_level = Translation3::new(0.0, 0.0, 0.03) * lean;
    let leaning = points.iter().map(|point| world_from_level * point);
    let mut settings = SegmentationSettings::of(region());
    settings.region.lowest_m.z = -0.2;
    let found = segment(leaning, &(world_from_level * eye), &settings);
    assert_eq!(found.clusters.len(), 1);
    let known = known(ALL.recognise(&found.clusters[0]));
    assert_near(0, &(world_from_level * truth), &known);
}

#[test]
fn specks_and_clouds_without_a_support_give_no_clusters() {
    let settings = SegmentationSettings::of(region());
    let eye = Point3::new(0.0, 0.0, 0.9);
    let none = segment(Vec::new(), &eye, &settings);
    assert!(none.clusters.is_empty() && none.world_from_support.is_none());
    let at = |step: i32| f64::from(step) * 0.004 - 0.2;
    let points = (0..10_000).map(|index| Point3::new(at(index % 100), at(index / 100), 0.0));
    let mut points: Vec<_> = points.collect();
    points.extend((0..10).map(|index| Point3::new(0.001 * f64::from(index), 0.0, 0.02)));
    let found = segment(points, &eye, &settings);
    assert_eq!((found.clusters.len(), found.specks), (0, 1));
}

/// A cluster of points that no camera would give.
fn hostile(points_m: Vec<Point3<f64>>, eye_m: Point3<f64>) -> Cluster {
    Cluster {
        surroundings_m: points_m.clone(),
        points_m,
        eye_m,
        world_from_support: Isometry3::identity(),
    }
}

#[test]
fn hostile_clouds_are_unknown() {
    let above = Point3::new(0.0, 0.0, 0.9);
    let nan = Point3::new(f64::NAN, 0.0, 0.1);
    let far = Point3::new(1e300, -1e300, f64::INFINITY);
    let scattered = |count: u32, scale: f64| -> Vec<Point3<f64>> {
        let part = |index: u32, step: f64| (f64::from(index) * step).fract() * scale;
        let place = |index| [0.754_877, 0.569_84, 0.438_3].map(|step| part(index, step));
        (0..count).map(|index| place(index).into()).collect()
    };
    let clouds = [
        Vec::new(),
        vec![nan; 1000],
        vec![far; 1000],
        vec![Point3::new(0.1, 0.1, 0.05); 100_000],
        vec![Point3::new(0.1, 0.1, -0.05); 1000],
        (0..1000)
            .map(|index| Point3::new(0.0, 0.0, f64::from(index) * 1e-3))
            .collect(),
        scattered(3_000_000, 0.3),
        scattered(1000, 900.0),
        scattered(50, 1e-6),
    ];
    for points in clouds {
        let count = points.len();
        for eye in [above, Point3::new(0.1, 0.1, 0.05), nan] {
            let found = ALL.recognise(&hostile(points.clone(), eye));
            let is_unknown = matches!(found, Recognition::Unknown(_));
            assert!(is_unknown, "{count} points: {found:?}");
        }
        let settings = SegmentationSettings {
            support: Support::Known {
                world_from_support: Isometry3::identity(),
            },
            ..SegmentationSettings::of(region())
        };
        for cluster in segment(points.iter().copied(), &above, &settings).clusters {
            assert!(matches!(ALL.recognise(&cluster), Recognition::Unknown(_)));
        }
        segment(points, &above, &SegmentationSettings::of(region()));
    }
}
