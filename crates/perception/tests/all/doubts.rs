//! Scenes on which nothing is to be planned, seen by a simulated depth camera.
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_perception::doubts::{Doubt, DoubtSettings, Wall};
use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_perception::settings::MapperSettings;

use crate::simulated::Case;

const WALL_M: f64 = 0.012;

/// Two boxes that lie in the container, the second moved along x.
fn content(moved_m: f64) -> Vec<Mesh> {
    let (low_m, high_m) = (0.17 + moved_m, 0.27 + moved_m);
    vec![
        Mesh::cuboid([0.02, 0.02, 0.0], [0.12, 0.18, 0.11]),
        Mesh::cuboid([low_m, 0.10, 0.0], [high_m, 0.22, 0.06]),
    ]
}

/// A hand that reaches in from the far end of x.
fn hand() -> Vec<Mesh> {
    vec![
        Mesh::cuboid([0.20, 0.14, 0.20], [0.29, 0.20, 0.24]),
        Mesh::cuboid([0.27, 0.15, 0.24], [0.29, 0.19, 0.36]),
        Mesh::cuboid([0.27, 0.15, 0.36], [0.60, 0.20, 0.42]),
    ]
}

/// The reference container with boxes in it, on a table, seen from straight above.
fn with(boxes: Vec<Mesh>) -> Case {
    let mut case = Case::plain();
    case.wall_m = WALL_M;
    case.others = boxes;
    case.look_from(0.7, 0.0, 0.0, 0.0);
    case
}

/// The usual content, with a change.
fn scene(change: impl FnOnce(&mut Case)) -> Case {
    let mut case = with(content(0.0));
    change(&mut case);
    case
}

/// Where the sensor is believed to be.
fn above() -> Isometry3<f64> {
    scene(|_| {}).world_from_camera
}

fn points(mut case: Case, seed: u64) -> Vec<Point3<f32>> {
    case.seed = seed;
    case.cloud()
}

/// As a real cell is set up.
fn settings() -> MapperSettings {
    MapperSettings {
        point_radius_m: 0.00125,
        largest_hole_m: 0.01,
        wall_margin_m: 0.003,
        doubts: DoubtSettings {
            wall_thickness_m: WALL_M,
            reach_above_rim_m: 0.03,
            ..DoubtSettings::default()
        },
        ..deployed()
    }
}

/// The defaults, of a camera with noise.
fn deployed() -> MapperSettings {
    MapperSettings {
        noise_m: 0.001,
        ..MapperSettings::default()
    }
}

fn mapper(settings: MapperSettings) -> Mapper {
    Mapper::new(&Grid::reference(), settings).unwrap()
}

/// What one cloud shows to who believes the sensor where it should be.
fn seen(points: &[Point3<f32>]) -> Mapped {
    let points = points.iter().copied();
    mapper(settings()).map(points, &above()).unwrap()
}

/// Says whether some doubt is of a kind.
macro_rules! has {
    ($doubts:expr, $kind:pat) => {
        $doubts.iter().any(|doubt| matches!(doubt, $kind))
    };
}

fn walls_away(mapped: &Mapped) -> Vec<Wall> {
    let away = |doubt: &Doubt| match doubt {
        Doubt::RimAway { wall, .. } => Some(*wall),
        _ => None,
    };
    mapped.doubts.iter().filter_map(away).collect()
}

#[test]
fn a_scene_as_it_should_be_is_not_doubted() {
    for seed in 0..5 {
        let mapped = seen(&points(scene(|_| {}), seed));
        assert_eq!(mapped.doubts, []);
        assert_eq!(mapped.unknown_cells, 0);
    }
    assert_eq!(seen(&points(with(Vec::new()), 9)).doubts, []);
}

#[test]
fn a_container_that_was_bumped_is_noticed() {
    let bumps = [
        (0.03, 0.0),
        (-0.03, 0.0),
        (0.0, 0.03),
        (0.0, -0.03),
        (0.02, 0.02),
    ];
    for (x_m, y_m) in bumps {
        let bumped = scene(|case| case.stands_at = Isometry3::translation(x_m, y_m, 0.0));
        let mapped = seen(&points(bumped, 1));
        assert!(!walls_away(&mapped).is_empty(), "by ({x_m}, {y_m})");
        assert!(mapped.doubts[0].to_string().contains("was the container"));
    }
    let centre = Translation3::new(0.16, 0.16, 0.0);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 8.0_f64.to_radians());
    let turned = scene(|case| case.stands_at = centre * turn * centre.inverse());
    assert_eq!(walls_away(&seen(&points(turned, 1))).len(), 4);
}

#[test]
fn a_sensor_that_is_not_where_it_should_be_is_noticed() {
    let tilt = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 2.0_f64.to_radians());
    for sensor in [
        Translation3::new(0.02, 0.0, 0.0) * above(),
        Translation3::new(0.0, 0.0, 0.02) * above(),
        above() * tilt,
    ] {
        let scene = scene(|case| case.world_from_camera = sensor);
        let mapped = seen(&points(scene, 2));
        assert!(!walls_away(&mapped).is_empty(), "{sensor}");
    }
}

#[test]
fn a_cloud_in_another_unit_or_frame_is_noticed() {
    let points = points(scene(|_| {}), 3);
    let scaled = |factor: f32| -> Vec<_> { points.iter().map(|point| point * factor).collect() };
    for factor in [1000.0, 100.0, 0.001, 0.0254, 1.05] {
        assert!(!seen(&scaled(factor)).doubts.is_empty(), "{factor}");
    }
    // ROS has bodies look along x with z up where optical frames look along z.
    let axes = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let body_from_optical = Rotation3::from_matrix_unchecked(axes).cast::<f32>();
    let rotated = points.iter().map(|point| body_from_optical * point);
    let rotated: Vec<_> = rotated.collect();
    assert!(!seen(&rotated).doubts.is_empty());
    // By default, without walls to look for, what shows nothing of the container is doubted still.
    let mut mapper = mapper(MapperSettings::default());
    for points in [scaled(1000.0), rotated, Vec::new()] {
        let doubts = mapper.map(points, &above()).unwrap().doubts;
        let is_first = matches!(doubts[..], [Doubt::LittleSeen { .. }, ..]);
        assert!(is_first, "{doubts:?}");
    }
}

#[test]
fn half_a_picture_a_shifted_one_and_a_forgotten_pose_are_noticed_as_it_is_deployed() {
    let mut mapper = mapper(deployed());
    let pose = above();
    let points = points(scene(|_| {}), 5);
    let mapped = mapper.map(points.iter().copied(), &pose).unwrap();
    assert_eq!(mapped.doubts, []);
    let half = points.iter().filter(|point| point.x < 0.0);
    let mapped = mapper.map(half.copied(), &pose).unwrap();
    assert!(matches!(mapped.doubts[0], Doubt::LittleSeen { .. }));
    let shifted = Translation3::new(0.1, 0.0, 0.0) * pose;
    let mapped = mapper.map(points.iter().copied(), &shifted).unwrap();
    assert!(!walls_away(&mapped).is_empty(), "{:?}", mapped.doubts);
    // The sensor's frame taken for the container's, all around its origin.
    let centred = Isometry3::translation(0.16, 0.16, 0.0);
    let mapped = mapper.map(points, &centred).unwrap();
    let is_above = |doubt: &&Doubt| matches!(doubt, Doubt::AboveRim { .. });
    let text = mapped.doubts.iter().find(is_above).unwrap().to_string();
    assert!(text.contains("pose"), "{text}");
}

#[test]
fn what_needs_no_numbers_of_the_sensor_is_noticed_by_default() {
    let mut mapper = mapper(deployed());
    let mut doubts = |points: Vec<Point3<f32>>| mapper.map(points, &above()).unwrap().doubts;
    assert_eq!(doubts(points(scene(|_| {}), 6)), []);
    assert_eq!(doubts(points(with(Vec::new()), 6)), []);
    for (what, stands_at) in [
        ("there is none", Isometry3::translation(3.0, 0.0, 0.0)),
        ("moved", Isometry3::translation(0.03, 0.0, 0.0)),
    ] {
        let doubts = doubts(points(scene(|case| case.stands_at = stands_at), 6));
        assert!(has!(doubts, Doubt::RimAway { .. }), "{what}: {doubts:?}");
    }
    let upside_down = points(scene(|_| {}), 6).into_iter();
    let upside_down = upside_down.map(|point| Point3::new(point.x, point.y, -point.z));
    assert!(!doubts(upside_down.collect()).is_empty());
    let reaching = doubts(points(with([content(0.0), hand()].concat()), 6));
    assert!(has!(reaching, Doubt::Intrusion { .. }), "{reaching:?}");
}

#[test]
fn settings_say_what_they_leave_unnoticed() {
    assert_eq!(MapperSettings::default().unnoticed().len(), 3);
    let mut camera = settings();
    assert_eq!(camera.unnoticed().len(), 1);
    camera.still.clouds = 3;
    assert!(camera.unnoticed().is_empty());
    camera.doubts.least_rim_share = 0.0;
    camera.doubts.least_seen_share = 0.0;
    let unnoticed = camera.unnoticed().join("; ");
    assert!(unnoticed.contains("RIM_AWAY") && unnoticed.contains("LITTLE_SEEN"));
}

#[test]
fn a_hand_in_the_scene_is_noticed() {
    let reaching = with([content(0.0), hand()].concat());
    let doubts = seen(&points(reaching, 4)).doubts;
    assert!(
        has!(doubts, Doubt::Intrusion { points: 101.., .. }),
        "{doubts:?}"
    );
    // Content that stands a little above the rim is no hand.
    let tall = with(vec![Mesh::cuboid([0.1, 0.1, 0.0], [0.2, 0.2, 0.32])]);
    assert_eq!(seen(&points(tall, 4)).doubts, []);
}

/// Maps clouds of the content one after the other, its second box moved each time.
fn sequence(clouds: usize, moved_m: &[f64]) -> Vec<Mapped> {
    let mut mapper = still_mapper(clouds);
    let map = |(seed, moved_m): (usize, &f64)| {
        let points = points(with(content(*moved_m)), seed as u64);
        mapper.map(points, &above()).unwrap()
    };
    moved_m.iter().enumerate().map(map).collect()
}

/// A mapper that asks for so many clouds that agree.
fn still_mapper(clouds: usize) -> Mapper {
    let mut settings = settings();
    settings.still.clouds = clouds;
    mapper(settings)
}

fn is_still(mapped: &Mapped) -> bool {
    !has!(mapped.doubts, Doubt::NotStill { .. })
}

#[test]
fn a_scene_is_still_once_enough_clouds_agree() {
    let moved_m = [0.0, 0.0, 0.0, 0.0, -0.025, -0.025, -0.025, -0.025];
    let mapped = sequence(3, &moved_m);
    let still: Vec<bool> = mapped.iter().map(is_still).collect();
    assert_eq!(still, [false, false, true, true, false, false, true, true]);
    assert!(mapped[4].moved_cells > 10, "{}", mapped[4].moved_cells);
    assert!(mapped[7].moved_cells <= 2);
    let clouds: Vec<usize> = mapped.iter().map(|mapped| mapped.clouds).collect();
    assert_eq!(clouds, [1, 2, 3, 3, 1, 2, 3, 3]);
    // Nothing of where the box was stays.
    assert!(mapped[7].scene.heightmap().get(26, 15) <= Some(2));
}

#[test]
fn what_creeps_is_not_still() {
    let moved_m: Vec<f64> = (0..20).map(|step| -0.005 * f64::from(step)).collect();
    let mapped = sequence(6, &moved_m);
    assert!(mapped.iter().all(|mapped| !is_still(mapped)));
}

#[test]
fn clouds_of_an_earlier_scene_count_no_more_once_it_changed() {
    let mut mapper = still_mapper(3);
    let map = |mapper: &mut Mapper, seed| mapper.map(points(scene(|_| {}), seed), &above());
    for seed in 0..3 {
        map(&mut mapper, seed).unwrap();
    }
    mapper.changed();
    let mapped = map(&mut mapper, 3).unwrap();
    assert_eq!((mapped.clouds, is_still(&mapped)), (1, false));
}

#[test]
fn several_clouds_show_more_and_with_less_noise_than_one() {
    let mapped = sequence(4, &[0.0; 4]);
    let (first, last) = (&mapped[0], &mapped[3]);
    assert!(is_still(last));
    // What the boxes hide stays unseen; what dropouts hid does not.
    let unseen = [first, last].map(|mapped| mapped.unseen_samples);
    assert!(unseen[1] + 150 < unseen[0], "{unseen:?}");
    // The floor between the boxes.
    let spread = |mapped: &Mapped| {
        let surface = mapped.scene.surface().unwrap();
        let heights = (52..66).flat_map(|x| (30..100).map(move |y| x * surface.ny() + y));
        let heights: Vec<f32> = heights.map(|sample| surface.heights_m()[sample]).collect();
        let mean = heights.iter().sum::<f32>() / heights.len() as f32;
        let squares = heights.iter().map(|height| (height - mean).powi(2));
        (squares.sum::<f32>() / heights.len() as f32).sqrt()
    };
    let spreads = [first, last].map(spread);
    assert!(spreads[1] < 0.7 * spreads[0], "{spreads:?}");
}
