//! Placed items found again in simulated containers.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a panic is a failing test"
)]

mod common;

use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, LazyLock};

use common::{at_rest, ball, cuboid, models, object_of};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::grid::ContainerSize;
use ppnpack_packing::heightmap::Surface;
use ppnpack_recognition::inspection::{
    ContainerCloud, Inspection, InspectionSettings, Lying, UnclearReason, inspect,
};
use ppnpack_recognition::library::{Library, LibraryObject, LibrarySettings};

const CONTAINER: ContainerSize = ContainerSize {
    x_m: 0.32,
    y_m: 0.32,
    z_m: 0.2,
};
const PITCH_M: f64 = 0.0025;
const SIDE: usize = 128;
const EYE: Point3<f64> = Point3::new(0.13, 0.2, 0.9);

static LIBRARY: LazyLock<Library> =
    LazyLock::new(|| Library::new(&models(), LibrarySettings::default()).unwrap());
static BALL: LazyLock<LibraryObject> = LazyLock::new(|| object_of("ball", ball(0.035)));

fn bracket() -> &'static LibraryObject {
    &LIBRARY.objects[0]
}

fn carton() -> &'static LibraryObject {
    &LIBRARY.objects[1]
}

fn can() -> &'static LibraryObject {
    &LIBRARY.objects[2]
}

type Posed = (Arc<Model>, Isometry3<f64>);

fn walls() -> Mesh {
    let (x, y, z, wall) = (CONTAINER.x_m, CONTAINER.y_m, CONTAINER.z_m, 0.004);
    let boxes = [
        ([-0.4, -0.4, -0.02], [x + 0.4, y + 0.4, -0.01]),
        ([0.0, 0.0, -wall], [x, y, 0.0]),
        ([-wall, -wall, -wall], [0.0, y + wall, z]),
        ([x, -wall, -wall], [x + wall, y + wall, z]),
        ([-wall, -wall, -wall], [x + wall, 0.0, z]),
        ([-wall, y, -wall], [x + wall, y + wall, z]),
    ];
    let mut mesh = Mesh {
        vertices: Vec::new(),
        triangles: Vec::new(),
    };
    for (lowest, highest) in boxes {
        mesh.append(&Mesh::cuboid(lowest, highest));
    }
    mesh
}

fn body(mesh: &Mesh, world_from_body: Isometry3<f64>) -> Body<'_> {
    Body {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        world_from_body,
    }
}

/// What a noisy camera sees of a container with items.
fn seen(items: &[Posed], seed: u64) -> Vec<Point3<f64>> {
    let walls = walls();
    let mut bodies = vec![body(&walls, Isometry3::identity())];
    bodies.extend(items.iter().map(|(model, pose)| body(&model.mesh, *pose)));
    let intrinsics = Intrinsics::centred(640, 480, 600.0).unwrap();
    let camera = DepthCamera::looking_at(intrinsics, EYE, &Point3::new(0.16, 0.16, 0.0));
    let view = camera.see(&bodies).unwrap();
    let image = view.noisy_points(&NoiseModel::default(), seed).unwrap();
    image.in_world_m(&camera.world_from_camera).collect()
}

/// The greatest heights of a cloud; what is unseen counts as higher than the rim.
fn surface(points_m: &[Point3<f64>]) -> Surface {
    let mut heights_m = vec![f32::NAN; SIDE * SIDE];
    for point in points_m {
        let (x, y) = ((point.x / PITCH_M).floor(), (point.y / PITCH_M).floor());
        let is_inside = (0.0..SIDE as f64).contains(&x) && (0.0..SIDE as f64).contains(&y);
        if is_inside && point.z > -0.01 {
            let height_m = &mut heights_m[x as usize * SIDE + y as usize];
            *height_m = height_m.max(point.z.max(0.0) as f32);
        }
    }
    let unseen_m = CONTAINER.z_m as f32 + 0.1;
    let filled = (0..SIDE * SIDE).map(|square| {
        let around = [0, 1, SIDE].map(|step| square.checked_sub(step));
        let heights = around.into_iter().flatten().map(|square| heights_m[square]);
        let height_m = heights.fold(f32::NAN, f32::max);
        if heights_m[square].is_nan() && height_m.is_nan() {
            unseen_m
        } else if heights_m[square].is_nan() {
            height_m
        } else {
            heights_m[square]
        }
    });
    Surface::from_metres(SIDE, SIDE, PITCH_M, filled.collect()).unwrap()
}

fn inspected(
    object: &LibraryObject,
    planned: &Isometry3<f64>,
    before: &[Posed],
    after: &[Posed],
) -> Inspection {
    let before = surface(&seen(before, 3));
    let points_m = seen(after, 4);
    let cloud = ContainerCloud {
        points_m: &points_m,
        eye_m: EYE,
    };
    inspect(
        object,
        planned,
        &before,
        &cloud,
        CONTAINER,
        &InspectionSettings::default(),
    )
}

/// What lies in the container already: a box, a can that stands, and a tile on the floor.
fn content() -> Vec<Posed> {
    let model = |index: usize| LIBRARY.objects[index].model.clone();
    vec![
        (model(1), at_rest(&model(1), 0, 0.3, 0.09, 0.07)),
        (model(2), at_rest(&model(2), upright(), 0.0, 0.25, 0.06)),
        (model(4), at_rest(&model(4), 0, 0.5, 0.23, 0.24)),
    ]
}

/// The resting pose in which the can stands.
fn upright() -> usize {
    let poses = &LIBRARY.objects[2].model.resting_poses;
    let stands =
        |rotation: &UnitQuaternion<f64>| (rotation * Vector3::z()).dot(&Vector3::z()).abs() > 0.9;
    poses
        .iter()
        .position(|pose| stands(&pose.rotation))
        .unwrap()
}

fn with(object: &LibraryObject, pose: Isometry3<f64>) -> Vec<Posed> {
    let mut items = content();
    items.push((object.model.clone(), pose));
    items
}

fn lying(inspection: &Inspection) -> &Lying {
    inspection
        .lying()
        .unwrap_or_else(|| panic!("{inspection:?}"))
}

/// Whether the found pose is within 3 mm and 3 degrees of the truth, modulo symmetry.
fn is_right(object: &LibraryObject, truth: &Isometry3<f64>, inspection: &Inspection) -> bool {
    let found = lying(inspection).container_from_item;
    let apart_m = nalgebra::distance(&(found * object.centre_m), &(truth * object.centre_m));
    let angle_rad = object
        .near_symmetry
        .angle_between(&found.rotation, &truth.rotation);
    apart_m < 0.003 && angle_rad < 0.053
}

#[test]
fn an_item_lies_as_planned_within_the_noise() {
    for object in &LIBRARY.objects {
        let planned = at_rest(&object.model, 0, 0.4, 0.1, 0.21);
        let shift = Translation3::new(0.0015, -0.001, 0.0);
        let truth = shift * planned;
        let inspection = inspected(object, &planned, &content(), &with(object, truth));
        assert!(
            matches!(inspection, Inspection::AsPlanned(lying) if lying.is_inside),
            "{} {inspection:?}",
            object.model.name
        );
        assert!(
            is_right(object, &truth, &inspection),
            "{} {inspection:?}",
            object.model.name
        );
    }
}

#[test]
fn an_item_that_slid_has_moved() {
    for object in [bracket(), carton(), can()] {
        let planned = at_rest(&object.model, 0, 0.4, 0.09, 0.21);
        let truth = Translation3::new(0.02, 0.0, 0.0) * planned;
        let inspection = inspected(object, &planned, &content(), &with(object, truth));
        assert!(
            matches!(inspection, Inspection::Moved(lying) if (lying.slide_m - 0.02).abs() < 0.003),
            "{} {inspection:?}",
            object.model.name
        );
        assert!(
            is_right(object, &truth, &inspection),
            "{truth:?} {inspection:?}"
        );
    }
}

#[test]
fn an_item_that_turned_has_moved() {
    for object in [bracket(), carton()] {
        let planned = at_rest(&object.model, 0, 0.4, 0.1, 0.21);
        let truth = at_rest(&object.model, 0, 0.4 + 30.0_f64.to_radians(), 0.1, 0.21);
        let inspection = inspected(object, &planned, &content(), &with(object, truth));
        let Inspection::Moved(lying) = inspection else {
            panic!("{} {inspection:?}", object.model.name);
        };
        assert!((lying.turn_rad - 30.0_f64.to_radians()).abs() < 0.05 && lying.tilt_rad < 0.05);
        assert!(
            is_right(object, &truth, &inspection),
            "{truth:?} {inspection:?}"
        );
    }
}

#[test]
fn an_item_on_its_side_has_toppled() {
    let planned = at_rest(&can().model, upright(), 0.0, 0.09, 0.22);
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.9);
    let fall = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
    let turned = yaw * fall * planned.rotation;
    let middle = turned * can().model.mass.centre_of_mass_m;
    let truth = Translation3::new(0.1 - middle.x, 0.22 - middle.y, 0.033 - middle.z) * turned;
    let inspection = inspected(can(), &planned, &content(), &with(can(), truth));
    assert!(
        matches!(inspection, Inspection::Toppled(lying) if (lying.tilt_rad - FRAC_PI_2).abs() < 0.05),
        "{inspection:?}"
    );
    assert!(is_right(can(), &truth, &inspection), "{inspection:?}");
}

#[test]
fn an_item_that_leans_on_a_neighbour_has_toppled() {
    let object = carton();
    let planned = at_rest(&object.model, 0, 0.3, 0.1, 0.21);
    let lean = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -0.6);
    let turned = lean * planned.rotation;
    let heights_m = object
        .model
        .mesh
        .vertices
        .iter()
        .map(|point| (turned * point).z);
    let lowest_m = heights_m.fold(f64::INFINITY, f64::min);
    let middle = turned * object.model.mass.centre_of_mass_m;
    let truth = Translation3::new(0.1 - middle.x, 0.21 - middle.y, -lowest_m) * turned;
    let inspection = inspected(object, &planned, &content(), &with(object, truth));
    assert!(
        matches!(inspection, Inspection::Toppled(lying) if (lying.tilt_rad - 0.6).abs() < 0.05),
        "{inspection:?}"
    );
    assert!(is_right(object, &truth, &inspection), "{inspection:?}");
}

#[test]
fn an_item_that_was_not_placed_is_missing() {
    for object in [bracket(), carton(), can()] {
        let planned = at_rest(&object.model, 0, 0.4, 0.1, 0.21);
        let inspection = inspected(object, &planned, &content(), &content());
        assert!(
            matches!(inspection, Inspection::Missing(absence) if absence.new_m2 < 0.1 * absence.least_m2),
            "{} {inspection:?}",
            object.model.name
        );
    }
}

#[test]
fn a_neighbour_that_shifted_is_not_the_item() {
    let planned = at_rest(&carton().model, 0, 0.4, 0.1, 0.21);
    for shift in [
        Translation3::new(0.003, 0.0, 0.0),
        Translation3::new(-0.002, 0.002, 0.0),
    ] {
        let shifted: Vec<Posed> = content()
            .into_iter()
            .map(|(model, pose)| (model, shift * pose))
            .collect();
        let inspection = inspected(carton(), &planned, &content(), &shifted);
        assert!(
            matches!(inspection, Inspection::Missing(_)),
            "{inspection:?}"
        );
    }
}

#[test]
fn an_item_among_neighbours_that_shifted_lies_as_planned() {
    let planned = at_rest(&carton().model, 0, 0.4, 0.1, 0.21);
    let shift = Translation3::new(-0.002, -0.002, 0.0);
    let mut items: Vec<Posed> = content()
        .into_iter()
        .map(|(model, pose)| (model, shift * pose))
        .collect();
    items.push((carton().model.clone(), planned));
    let inspection = inspected(carton(), &planned, &content(), &items);
    assert!(
        matches!(inspection, Inspection::AsPlanned(_)),
        "{inspection:?}"
    );
}

#[test]
fn an_item_on_top_of_a_neighbour_has_moved() {
    let planned = at_rest(&bracket().model, 0, 0.4, 0.1, 0.17);
    let height_m = carton().model.mesh.transformed(&content()[0].1);
    let height_m = height_m.bounds().unwrap().highest.z;
    let truth =
        Translation3::new(0.0, 0.0, height_m) * at_rest(&bracket().model, 0, 0.4, 0.09, 0.08);
    let inspection = inspected(bracket(), &planned, &content(), &with(bracket(), truth));
    assert!(
        matches!(inspection, Inspection::Moved(lying) if (lying.rise_m - height_m).abs() < 0.003),
        "{inspection:?}"
    );
    assert!(is_right(bracket(), &truth, &inspection), "{inspection:?}");
}

#[test]
fn a_pen_that_stands_on_its_end_is_found() {
    let object = object_of("pen", cuboid(0.13, 0.016, 0.014));
    let planned = at_rest(&object.model, 0, 0.4, 0.12, 0.21);
    let stand = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2);
    let middle = stand * object.model.mass.centre_of_mass_m;
    let truth = Translation3::new(0.17 - middle.x, 0.19 - middle.y, 0.065 - middle.z) * stand;
    let inspection = inspected(&object, &planned, &content(), &with(&object, truth));
    assert!(
        matches!(inspection, Inspection::Toppled(lying) if (lying.tilt_rad - FRAC_PI_2).abs() < 0.1),
        "{inspection:?}"
    );
}

#[test]
fn a_ball_that_rolled_in_place_lies_as_planned() {
    let planned = at_rest(&BALL.model, 0, 0.0, 0.1, 0.21);
    let centre = planned * BALL.centre_m;
    let roll = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 1.4);
    let truth = Isometry3::rotation_wrt_point(roll, centre) * planned;
    let inspection = inspected(&BALL, &planned, &content(), &with(&BALL, truth));
    assert!(
        matches!(inspection, Inspection::AsPlanned(lying) if lying.tilt_rad == 0.0),
        "{inspection:?}"
    );
}

#[test]
fn an_item_over_the_rim_is_not_inside() {
    let object = object_of("board", cuboid(0.2, 0.08, 0.03));
    let planned = at_rest(&object.model, 0, 0.0, 0.15, 0.2);
    let lean = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.5);
    let turned = lean * planned.rotation;
    let middle = turned * object.model.mass.centre_of_mass_m;
    let target = Vector3::new(0.025, 0.2, CONTAINER.z_m + 0.04);
    let truth = Translation3::from(target - middle.coords) * turned;
    let inspection = inspected(&object, &planned, &content(), &with(&object, truth));
    if let Some(lying) = inspection.lying() {
        assert!(!lying.is_inside, "{inspection:?}");
        assert!(is_right(&object, &truth, &inspection), "{inspection:?}");
    }
    assert!(!matches!(
        inspection,
        Inspection::Missing(_) | Inspection::AsPlanned(_)
    ));
}

#[test]
fn another_object_is_not_the_item() {
    let planned = at_rest(&can().model, upright(), 0.4, 0.1, 0.21);
    let stranger = at_rest(&bracket().model, 0, 0.4, 0.1, 0.21);
    let inspection = inspected(can(), &planned, &content(), &with(bracket(), stranger));
    assert!(
        matches!(inspection, Inspection::Unclear(_)),
        "{inspection:?}"
    );
}

fn reason(points_m: &[Point3<f64>]) -> UnclearReason {
    let planned = at_rest(&carton().model, 0, 0.4, 0.1, 0.21);
    let before = surface(&seen(&content(), 3));
    let cloud = ContainerCloud {
        points_m,
        eye_m: EYE,
    };
    let settings = InspectionSettings::default();
    match inspect(carton(), &planned, &before, &cloud, CONTAINER, &settings) {
        Inspection::Unclear(unclear) => unclear.reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn where_little_or_nothing_is_seen_nothing_is_said() {
    let nan = Point3::new(f64::NAN, 0.1, 0.1);
    let far = Point3::new(0.1, f64::INFINITY, 1e300);
    let is_little = |reason| matches!(reason, UnclearReason::LittleSeen { .. });
    assert!(is_little(reason(&[])));
    assert!(is_little(reason(&vec![nan; 1000])));
    assert!(is_little(reason(&vec![far; 1000])));
    assert!(is_little(reason(&vec![Point3::new(0.1, 0.1, 0.01); 1000])));
    let all = seen(&content(), 4);
    let half: Vec<_> = all.iter().filter(|point| point.x < 0.15).copied().collect();
    assert!(is_little(reason(&half)));
    // A strip without points that the item fits into.
    let strip = |point: &&Point3<f64>| point.y < 0.17 || point.y > 0.26;
    let without: Vec<_> = all.iter().filter(strip).copied().collect();
    assert_eq!(reason(&without), UnclearReason::CouldHide);
    let part = |index: u32, step: f64, side_m: f64| (f64::from(index) * step).fract() * side_m;
    let scattered = (0..200_000).map(|index| {
        Point3::new(
            part(index, 0.754_877_666, 0.32),
            part(index, 0.569_840_291, 0.32),
            part(index, 0.438_312_7, 0.3),
        )
    });
    assert_eq!(
        reason(&scattered.collect::<Vec<_>>()),
        UnclearReason::DoesNotFit
    );
}

#[test]
fn what_is_impossible_is_refused() {
    let planned = at_rest(&carton().model, 0, 0.4, 0.1, 0.21);
    let before = surface(&seen(&content(), 3));
    let points_m = seen(&with(carton(), planned), 4);
    let settings = InspectionSettings::default();
    let told = |planned: &Isometry3<f64>, before: &Surface, eye_m, container| {
        let cloud = ContainerCloud {
            points_m: &points_m,
            eye_m,
        };
        inspect(carton(), planned, before, &cloud, container, &settings)
    };
    let nowhere = Translation3::new(f64::NAN, 0.0, 0.0) * planned;
    let flat = ContainerSize {
        z_m: 0.0,
        ..CONTAINER
    };
    let none = Surface::from_metres(0, 0, PITCH_M, Vec::new()).unwrap();
    let endless = Surface::from_metres(1, 1, f64::NAN, vec![0.0]).unwrap();
    let blind = Point3::new(f64::NAN, 0.0, 0.9);
    for inspection in [
        told(&nowhere, &before, EYE, CONTAINER),
        told(&planned, &before, EYE, flat),
        told(&planned, &none, EYE, CONTAINER),
        told(&planned, &endless, EYE, CONTAINER),
        told(&planned, &before, blind, CONTAINER),
        // A camera within the container sees nothing that it could be compared with.
        told(&planned, &before, Point3::new(0.1, 0.2, 0.02), CONTAINER),
    ] {
        assert!(
            matches!(inspection, Inspection::Unclear(unclear) if unclear.reason == UnclearReason::Unusable),
            "{inspection:?}"
        );
    }
    let coarse = Surface::from_metres(2, 2, 0.16, vec![0.0; 4]).unwrap();
    told(&planned, &coarse, EYE, CONTAINER);
    let beside = Point3::new(900.0, -900.0, 0.21);
    told(&planned, &before, beside, CONTAINER);
}

#[test]
fn settings_are_checked() {
    assert!(InspectionSettings::default().validate().is_ok());
    for settings in [
        InspectionSettings {
            least_rise_m: -0.1,
            ..InspectionSettings::default()
        },
        InspectionSettings {
            least_fitness: f64::NAN,
            ..InspectionSettings::default()
        },
        InspectionSettings {
            topple_rad: 4.0,
            ..InspectionSettings::default()
        },
    ] {
        assert!(settings.validate().is_err());
    }
}
