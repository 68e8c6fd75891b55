//! Scenes on which nothing is to be planned, seen by a simulated depth camera.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_packing::grid::Grid;
use ppnpack_perception::doubts::{Doubt, DoubtSettings, Wall};
use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_perception::settings::MapperSettings;
use ppnpack_perception::still::StillSettings;

const WALL_M: f64 = 0.012;

/// What a camera sees, in its own frame, and where it is.
struct Scene {
    boxes: Vec<Mesh>,
    container: Isometry3<f64>,
    /// The sensor as it is.
    sensor: Isometry3<f64>,
}

/// The reference container with walls, on a table.
fn container() -> Vec<Mesh> {
    let (side, high, wall) = (0.32, 0.30, WALL_M);
    let (low, far) = (-wall, side + wall);
    vec![
        Mesh::cuboid([low, low, -0.005], [far, far, 0.0]),
        Mesh::cuboid([low, low, 0.0], [0.0, far, high]),
        Mesh::cuboid([side, low, 0.0], [far, far, high]),
        Mesh::cuboid([0.0, low, 0.0], [side, 0.0, high]),
        Mesh::cuboid([0.0, side, 0.0], [side, far, high]),
    ]
}

/// Two boxes that lie in the container.
fn content() -> Vec<Mesh> {
    vec![
        Mesh::cuboid([0.02, 0.02, 0.0], [0.12, 0.18, 0.11]),
        Mesh::cuboid([0.17, 0.10, 0.0], [0.27, 0.22, 0.06]),
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

fn above() -> DepthCamera {
    let intrinsics = Intrinsics::centred(640, 480, 580.0).unwrap();
    DepthCamera::looking_down(intrinsics, Point3::new(0.16, 0.16, 1.0))
}

impl Scene {
    fn new() -> Self {
        Self {
            boxes: content(),
            container: Isometry3::identity(),
            sensor: above().world_from_camera,
        }
    }

    /// The points of the camera, with noise and dropouts.
    fn points(&self, seed: u64) -> Vec<Point3<f32>> {
        let table = Mesh::cuboid([-1.0, -1.0, -0.02], [1.0, 1.0, -0.006]);
        let (mut fixed, mut moved) = (Mesh::default(), Mesh::default());
        fixed.append(&table);
        container().iter().for_each(|part| moved.append(part));
        self.boxes.iter().for_each(|part| fixed.append(part));
        let body = |mesh: &'_ Mesh, world_from_body| (mesh.clone(), world_from_body);
        let bodies = [
            body(&fixed, Isometry3::identity()),
            body(&moved, self.container),
        ];
        let bodies: Vec<Body<'_>> = bodies
            .iter()
            .map(|(mesh, world_from_body)| Body {
                vertices: &mesh.vertices,
                triangles: &mesh.triangles,
                world_from_body: *world_from_body,
            })
            .collect();
        let camera = DepthCamera::new(*above().see(&bodies).unwrap().intrinsics(), self.sensor);
        let noise = NoiseModel {
            deviation_m: 0.001,
            dropout: 0.05,
            ..NoiseModel::default()
        };
        let view = camera.see(&bodies).unwrap();
        view.noisy_points(&noise, seed).unwrap().points_m().to_vec()
    }
}

/// As a real cell is set up.
fn settings() -> MapperSettings {
    MapperSettings {
        noise_m: 0.001,
        point_radius_m: 0.00125,
        largest_hole_m: 0.01,
        wall_margin_m: 0.003,
        doubts: DoubtSettings {
            wall_thickness_m: WALL_M,
            reach_above_rim_m: Some(0.03),
            ..DoubtSettings::default()
        },
        ..MapperSettings::default()
    }
}

fn mapper(settings: MapperSettings) -> Mapper {
    Mapper::new(&Grid::reference(), settings).unwrap()
}

/// What one cloud shows to who believes the sensor where it should be.
fn seen(points: &[Point3<f32>]) -> Mapped {
    let mut mapper = mapper(settings());
    mapper
        .map(points.iter().copied(), &above().world_from_camera)
        .unwrap()
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
        let mapped = seen(&Scene::new().points(seed));
        assert_eq!(mapped.doubts, []);
        assert_eq!(mapped.unknown_cells, 0);
    }
    let empty = Scene {
        boxes: Vec::new(),
        ..Scene::new()
    };
    assert_eq!(seen(&empty.points(9)).doubts, []);
}

#[test]
fn a_container_that_was_bumped_is_noticed() {
    for (x_m, y_m) in [
        (0.03, 0.0),
        (-0.03, 0.0),
        (0.0, 0.03),
        (0.0, -0.03),
        (0.02, 0.02),
    ] {
        let bumped = Scene {
            container: Isometry3::translation(x_m, y_m, 0.0),
            ..Scene::new()
        };
        let mapped = seen(&bumped.points(1));
        assert!(!walls_away(&mapped).is_empty(), "by ({x_m}, {y_m})");
        assert!(mapped.doubts[0].to_string().contains("was the container"));
    }
    let centre = Translation3::new(0.16, 0.16, 0.0);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 8.0_f64.to_radians());
    let turned = Scene {
        container: centre * turn * centre.inverse(),
        ..Scene::new()
    };
    assert_eq!(walls_away(&seen(&turned.points(1))).len(), 4);
}

#[test]
fn a_sensor_that_is_not_where_it_should_be_is_noticed() {
    let wrong = [
        Translation3::new(0.02, 0.0, 0.0) * above().world_from_camera,
        Translation3::new(0.0, 0.0, 0.02) * above().world_from_camera,
        above().world_from_camera
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 2.0_f64.to_radians()),
    ];
    for sensor in wrong {
        let scene = Scene {
            sensor,
            ..Scene::new()
        };
        assert!(!walls_away(&seen(&scene.points(2))).is_empty(), "{sensor}");
    }
}

#[test]
fn a_cloud_in_another_unit_or_frame_is_noticed() {
    let points = Scene::new().points(3);
    let scaled = |factor: f32| -> Vec<_> { points.iter().map(|point| point * factor).collect() };
    for factor in [1000.0, 100.0, 0.001, 0.0254, 1.05] {
        assert!(!seen(&scaled(factor)).doubts.is_empty(), "{factor}");
    }
    // ROS has bodies look along x with z up where optical frames look along z.
    let axes = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let body_from_optical = Rotation3::from_matrix_unchecked(axes).cast::<f32>();
    let rotated: Vec<_> = points
        .iter()
        .map(|point| body_from_optical * point)
        .collect();
    assert!(!seen(&rotated).doubts.is_empty());
    // By default, without walls to look for, what shows nothing of the container is doubted still.
    let mut mapper = mapper(MapperSettings::default());
    let pose = above().world_from_camera;
    for points in [scaled(1000.0), rotated, Vec::new()] {
        let mapped = mapper.map(points, &pose).unwrap();
        assert!(
            matches!(mapped.doubts[..], [Doubt::LittleSeen { .. }, ..]),
            "{:?}",
            mapped.doubts
        );
    }
}

#[test]
fn half_a_picture_a_shifted_one_and_a_forgotten_pose_are_noticed_as_it_is_deployed() {
    let settings = MapperSettings {
        noise_m: 0.001,
        ..MapperSettings::default()
    };
    let mut mapper = mapper(settings);
    let pose = above().world_from_camera;
    let points = Scene::new().points(5);
    assert_eq!(
        mapper.map(points.iter().copied(), &pose).unwrap().doubts,
        []
    );
    let half = points.iter().filter(|point| point.x < 0.0);
    let mapped = mapper.map(half.copied(), &pose).unwrap();
    assert!(matches!(mapped.doubts[0], Doubt::LittleSeen { .. }));
    let shifted = Translation3::new(0.1, 0.0, 0.0) * pose;
    let mapped = mapper.map(points.iter().copied(), &shifted).unwrap();
    assert!(!walls_away(&mapped).is_empty(), "{:?}", mapped.doubts);
    // The sensor's frame taken for the container's, all around its origin.
    let centred = Isometry3::translation(0.16, 0.16, 0.0);
    let mapped = mapper.map(points, &centred).unwrap();
    let is_above = |doubt: &Doubt| matches!(doubt, Doubt::AboveRim { .. });
    assert!(mapped.doubts.iter().any(is_above), "{:?}", mapped.doubts);
    let text = mapped.doubts.iter().find(|doubt| is_above(doubt)).unwrap();
    assert!(text.to_string().contains("pose"), "{text}");
}

#[test]
fn a_hand_in_the_scene_is_noticed() {
    let scene = Scene {
        boxes: [content(), hand()].concat(),
        ..Scene::new()
    };
    let doubts = seen(&scene.points(4)).doubts;
    let reaches_in =
        |doubt: &Doubt| matches!(doubt, Doubt::Intrusion { points, .. } if *points > 100);
    assert!(doubts.iter().any(reaches_in), "{doubts:?}");
    // Content that stands a little above the rim is no hand.
    let tall = Scene {
        boxes: vec![Mesh::cuboid([0.1, 0.1, 0.0], [0.2, 0.2, 0.32])],
        ..Scene::new()
    };
    assert_eq!(seen(&tall.points(4)).doubts, []);
}

/// Maps clouds of scenes one after the other.
fn sequence(still: StillSettings, scenes: &[Scene]) -> Vec<Mapped> {
    let mut mapper = mapper(MapperSettings {
        still,
        ..settings()
    });
    let map = |(seed, scene): (usize, &Scene)| {
        let points = scene.points(seed as u64);
        mapper.map(points, &above().world_from_camera).unwrap()
    };
    scenes.iter().enumerate().map(map).collect()
}

fn is_still(mapped: &Mapped) -> bool {
    let not_still = |doubt: &Doubt| matches!(doubt, Doubt::NotStill { .. });
    !mapped.doubts.iter().any(not_still)
}

fn three_clouds() -> StillSettings {
    StillSettings {
        clouds: 3,
        ..StillSettings::default()
    }
}

/// The content, its second box moved along x.
fn moved_by(x_m: f64) -> Scene {
    let [first, second] = content().try_into().unwrap();
    Scene {
        boxes: vec![
            first,
            second.transformed(&Isometry3::translation(x_m, 0.0, 0.0)),
        ],
        ..Scene::new()
    }
}

#[test]
fn a_scene_is_still_once_enough_clouds_agree() {
    let scenes: Vec<_> = [0.0, 0.0, 0.0, 0.0, -0.025, -0.025, -0.025, -0.025]
        .map(moved_by)
        .into();
    let mapped = sequence(three_clouds(), &scenes);
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
    let still = StillSettings {
        clouds: 6,
        ..StillSettings::default()
    };
    let scenes: Vec<_> = (0..20)
        .map(|step| moved_by(-0.005 * f64::from(step)))
        .collect();
    let mapped = sequence(still, &scenes);
    assert!(mapped.iter().all(|mapped| !is_still(mapped)));
}

#[test]
fn clouds_of_an_earlier_scene_count_no_more_once_it_changed() {
    let mut mapper = mapper(MapperSettings {
        still: three_clouds(),
        ..settings()
    });
    let pose = above().world_from_camera;
    for seed in 0..3 {
        mapper.map(Scene::new().points(seed), &pose).unwrap();
    }
    mapper.changed();
    let mapped = mapper.map(Scene::new().points(3), &pose).unwrap();
    assert_eq!((mapped.clouds, is_still(&mapped)), (1, false));
}

#[test]
fn several_clouds_show_more_and_with_less_noise_than_one() {
    let scenes: Vec<_> = (0..4).map(|_| Scene::new()).collect();
    let four = StillSettings {
        clouds: 4,
        ..StillSettings::default()
    };
    let mapped = sequence(four, &scenes);
    let (first, last) = (&mapped[0], &mapped[3]);
    assert!(is_still(last));
    // What the boxes hide stays unseen; what dropouts hid does not.
    assert!(
        last.unseen_samples + 150 < first.unseen_samples,
        "{} and {}",
        first.unseen_samples,
        last.unseen_samples
    );
    // The floor between the boxes.
    let spread = |mapped: &Mapped| {
        let surface = mapped.scene.surface().unwrap();
        let heights = (52..66).flat_map(|x| (30..100).map(move |y| x * surface.ny() + y));
        let heights: Vec<f32> = heights.map(|sample| surface.heights_m()[sample]).collect();
        let mean = heights.iter().sum::<f32>() / heights.len() as f32;
        let squares = heights.iter().map(|height| (height - mean).powi(2));
        (squares.sum::<f32>() / heights.len() as f32).sqrt()
    };
    assert!(
        spread(last) < 0.7 * spread(first),
        "{} and {}",
        spread(first),
        spread(last)
    );
}
