//! Placed items found again in simulated containers.

use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, LazyLock};

use Inspection::{AsPlanned, Missing, Moved, Toppled, Unclear};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_camera::{DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_recognition::inspection::{
    ContainerCloud, Inspection, InspectionSettings, Lying, UnclearReason, inspect,
};
use ppnpack_recognition::library::{Library, LibraryObject, LibrarySettings};

use crate::common::{at_rest, body, cuboid, models, object_of};
use crate::shapes::ball;

const CONTAINER: ContainerSize = ContainerSize::cuboid(0.32, 0.32, 0.2);
const PITCH_M: f64 = 0.0025;
const SIDE: usize = 128;
const EYE: Point3<f64> = Point3::new(0.13, 0.2, 0.9);

static LIBRARY: LazyLock<Library> =
    LazyLock::new(|| Library::new(&models(), LibrarySettings::default()).unwrap());

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
    let mut mesh = Mesh::default();
    for (lowest, highest) in [
        ([-0.4, -0.4, -0.02], [x + 0.4, y + 0.4, -0.01]),
        ([0.0, 0.0, -wall], [x, y, 0.0]),
        ([-wall, -wall, -wall], [0.0, y + wall, z]),
        ([x, -wall, -wall], [x + wall, y + wall, z]),
        ([-wall, -wall, -wall], [x + wall, 0.0, z]),
        ([-wall, y, -wall], [x + wall, y + wall, z]),
    ] {
        mesh.append(&Mesh::cuboid(lowest, highest));
    }
    mesh
}

/// What a noisy camera sees of a container with items.
fn seen(items: &[Posed], seed: u64) -> Vec<Point3<f64>> {
    let walls = walls();
    let mut bodies = vec![body(&walls, Isometry3::identity())];
    bodies.extend(items.iter().map(|(model, pose)| body(&model.mesh, *pose)));
    let intrinsics = Intrinsics::centred(640, 480, 600.0).unwrap();
    let camera = DepthCamera::looking_at(intrinsics, EYE, &Point3::new(0.16, 0.16, 0.0));
    let points = camera.see(&bodies, &NoiseModel::default(), seed).unwrap();
    camera.in_world_m(&points).collect()
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
        let around = [1, SIDE].map(|step| square.checked_sub(step));
        let around = around.into_iter().flatten().map(|square| heights_m[square]);
        let beside_m = around.fold(f32::NAN, f32::max);
        let mut known = [heights_m[square], beside_m].into_iter();
        known
            .find(|height_m| !height_m.is_nan())
            .unwrap_or(unseen_m)
    });
    Surface::from_metres(SIDE, SIDE, PITCH_M, filled.collect()).unwrap()
}

/// What is told of an object in a cloud of a container that held the usual content before.
fn told(object: &LibraryObject, planned: &Isometry3<f64>, points_m: &[Point3<f64>]) -> Inspection {
    let before = surface(&seen(&content(), 3));
    let cloud = ContainerCloud {
        points_m,
        eye_m: EYE,
    };
    let settings = InspectionSettings::default();
    inspect(object, planned, &before, &cloud, CONTAINER, &settings)
}

/// What is told where these items lie there after.
fn inspected(object: &LibraryObject, planned: &Isometry3<f64>, after: &[Posed]) -> Inspection {
    told(object, planned, &seen(after, 4))
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

/// The content, all of it shifted.
fn shifted(x_m: f64, y_m: f64) -> Vec<Posed> {
    let shift = Translation3::new(x_m, y_m, 0.0);
    let content = content().into_iter();
    content.map(|(model, pose)| (model, shift * pose)).collect()
}

/// The resting pose in which the can stands.
fn upright() -> usize {
    let mut poses = LIBRARY.objects[2].model.resting_poses.iter();
    let stands = poses.position(|pose| (pose.rotation * Vector3::z()).z.abs() > 0.9);
    stands.unwrap()
}

fn with(object: &LibraryObject, pose: Isometry3<f64>) -> Vec<Posed> {
    let mut items = content();
    items.push((object.model.clone(), pose));
    items
}

/// An object turned so, its centre of mass at a place.
fn centred_at(
    object: &LibraryObject,
    turn: UnitQuaternion<f64>,
    place: [f64; 3],
) -> Isometry3<f64> {
    let middle = turn * object.model.mass.centre_of_mass_m.coords;
    Translation3::from(Vector3::from(place) - middle) * turn
}

/// The lowest point of an object turned so, seen from its centre of mass, in metres.
fn below_centre_m(object: &LibraryObject, turn: UnitQuaternion<f64>) -> f64 {
    let vertices = object.model.mesh.vertices.iter();
    let centre = object.model.mass.centre_of_mass_m;
    let heights_m = vertices.map(|vertex| (turn * (centre - vertex)).z);
    heights_m.fold(0.0, f64::max)
}

fn about(axis: nalgebra::Unit<Vector3<f64>>, angle_rad: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&axis, angle_rad)
}

/// Asks that the found pose is within 3 mm and 3 degrees of the truth, modulo symmetry.
fn assert_right(object: &LibraryObject, truth: &Isometry3<f64>, inspection: &Inspection) {
    let name = &object.model.name;
    let lying = inspection.lying();
    let lying = lying.unwrap_or_else(|| panic!("{name}: {inspection:?}"));
    let found = lying.container_from_item;
    let apart_m = nalgebra::distance(&(found * object.centre_m), &(truth * object.centre_m));
    let symmetry = &object.near_symmetry;
    let angle_rad = symmetry.angle_between(&found.rotation, &truth.rotation);
    let is_right = apart_m < 0.003 && angle_rad < 0.053;
    assert!(is_right, "{name}: {truth:?} {inspection:?}");
}

/// Finds an object that was planned there and lies here, and asks for what is told of it.
fn assert_found(
    object: &LibraryObject,
    planned: &Isometry3<f64>,
    truth: &Isometry3<f64>,
    is_expected: impl Fn(&Inspection, &Lying) -> bool,
) {
    let inspection = inspected(object, planned, &with(object, *truth));
    assert_right(object, truth, &inspection);
    let is_expected = is_expected(&inspection, inspection.lying().unwrap());
    assert!(is_expected, "{}: {inspection:?}", object.model.name);
}

#[test]
fn an_item_lies_as_planned_within_the_noise() {
    for object in &LIBRARY.objects {
        let planned = at_rest(&object.model, 0, 0.4, 0.1, 0.21);
        let truth = Translation3::new(0.0015, -0.001, 0.0) * planned;
        assert_found(object, &planned, &truth, |told, lying| {
            matches!(told, AsPlanned(_)) && lying.is_inside
        });
    }
}

#[test]
fn an_item_that_slid_or_turned_has_moved() {
    for object in [bracket(), carton(), can()] {
        let planned = at_rest(&object.model, 0, 0.4, 0.09, 0.21);
        let truth = Translation3::new(0.02, 0.0, 0.0) * planned;
        assert_found(object, &planned, &truth, |told, lying| {
            matches!(told, Moved(_)) && (lying.slide_m - 0.02).abs() < 0.003
        });
    }
    for object in [bracket(), carton()] {
        let turn_rad = 30.0_f64.to_radians();
        let planned = at_rest(&object.model, 0, 0.4, 0.1, 0.21);
        let truth = at_rest(&object.model, 0, 0.4 + turn_rad, 0.1, 0.21);
        assert_found(object, &planned, &truth, |told, lying| {
            let turned = (lying.turn_rad - turn_rad).abs() < 0.05 && lying.tilt_rad < 0.05;
            turned && matches!(told, Moved(_))
        });
    }
}

#[test]
fn an_item_on_its_side_has_toppled() {
    let planned = at_rest(&can().model, upright(), 0.0, 0.09, 0.22);
    let turned =
        about(Vector3::z_axis(), 0.9) * about(Vector3::x_axis(), FRAC_PI_2) * planned.rotation;
    let truth = centred_at(can(), turned, [0.1, 0.22, 0.033]);
    assert_found(can(), &planned, &truth, |told, lying| {
        matches!(told, Toppled(_)) && (lying.tilt_rad - FRAC_PI_2).abs() < 0.05
    });
}

#[test]
fn an_item_that_leans_on_a_neighbour_has_toppled() {
    let planned = at_rest(&carton().model, 0, 0.3, 0.1, 0.21);
    let turned = about(Vector3::y_axis(), -0.6) * planned.rotation;
    let place = [0.1, 0.21, below_centre_m(carton(), turned)];
    let truth = centred_at(carton(), turned, place);
    assert_found(carton(), &planned, &truth, |told, lying| {
        matches!(told, Toppled(_)) && (lying.tilt_rad - 0.6).abs() < 0.05
    });
}

#[test]
fn an_item_that_was_not_placed_is_missing() {
    for object in [bracket(), carton(), can()] {
        let planned = at_rest(&object.model, 0, 0.4, 0.1, 0.21);
        let inspection = inspected(object, &planned, &content());
        let is_clear =
            matches!(inspection, Missing(absence) if absence.new_m2 < 0.1 * absence.least_m2);
        assert!(is_clear, "{} {inspection:?}", object.model.name);
    }
}

#[test]
fn neighbours_that_shifted_are_neither_the_item_nor_in_its_way() {
    let planned = at_rest(&carton().model, 0, 0.4, 0.1, 0.21);
    for (x_m, y_m) in [(0.003, 0.0), (-0.002, 0.002)] {
        let inspection = inspected(carton(), &planned, &shifted(x_m, y_m));
        assert!(matches!(inspection, Missing(_)), "{inspection:?}");
    }
    let mut items = shifted(-0.002, -0.002);
    items.push((carton().model.clone(), planned));
    let inspection = inspected(carton(), &planned, &items);
    assert!(matches!(inspection, AsPlanned(_)), "{inspection:?}");
}

#[test]
fn an_item_on_top_of_a_neighbour_has_moved() {
    let planned = at_rest(&bracket().model, 0, 0.4, 0.1, 0.17);
    let below = carton().model.mesh.transformed(&content()[0].1);
    let height_m = below.bounds().unwrap().highest.z;
    let truth =
        Translation3::new(0.0, 0.0, height_m) * at_rest(&bracket().model, 0, 0.4, 0.09, 0.08);
    assert_found(bracket(), &planned, &truth, |told, lying| {
        matches!(told, Moved(_)) && (lying.rise_m - height_m).abs() < 0.003
    });
}

#[test]
fn a_pen_that_stands_on_its_end_is_found() {
    let pen = object_of("pen", cuboid(0.13, 0.016, 0.014));
    let planned = at_rest(&pen.model, 0, 0.4, 0.12, 0.21);
    let on_end = about(Vector3::y_axis(), FRAC_PI_2);
    let truth = centred_at(&pen, on_end, [0.17, 0.19, 0.065]);
    let inspection = inspected(&pen, &planned, &with(&pen, truth));
    let stands = matches!(inspection, Toppled(lying) if (lying.tilt_rad - FRAC_PI_2).abs() < 0.1);
    assert!(stands, "{inspection:?}");
}

#[test]
fn a_ball_that_rolled_in_place_lies_as_planned() {
    let ball = object_of("ball", ball(0.035, 48, 24));
    let planned = at_rest(&ball.model, 0, 0.0, 0.1, 0.21);
    let roll = about(Vector3::x_axis(), 1.4);
    let truth = Isometry3::rotation_wrt_point(roll, planned * ball.centre_m) * planned;
    assert_found(&ball, &planned, &truth, |told, lying| {
        matches!(told, AsPlanned(_)) && lying.tilt_rad == 0.0
    });
}

#[test]
fn an_item_over_the_rim_is_not_inside() {
    let board = object_of("board", cuboid(0.2, 0.08, 0.03));
    let planned = at_rest(&board.model, 0, 0.0, 0.15, 0.2);
    let turned = about(Vector3::y_axis(), 0.5) * planned.rotation;
    let truth = centred_at(&board, turned, [0.025, 0.2, CONTAINER.z_m + 0.04]);
    let inspection = inspected(&board, &planned, &with(&board, truth));
    if let Some(lying) = inspection.lying() {
        assert!(!lying.is_inside, "{inspection:?}");
        assert_right(&board, &truth, &inspection);
    }
    assert!(!matches!(inspection, Missing(_) | AsPlanned(_)));
}

#[test]
fn another_object_is_not_the_item() {
    let planned = at_rest(&can().model, upright(), 0.4, 0.1, 0.21);
    let stranger = at_rest(&bracket().model, 0, 0.4, 0.1, 0.21);
    let inspection = inspected(can(), &planned, &with(bracket(), stranger));
    assert!(matches!(inspection, Unclear(_)), "{inspection:?}");
}

fn reason(inspection: &Inspection) -> UnclearReason {
    match inspection {
        Unclear(unclear) => unclear.reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn where_little_or_nothing_is_seen_nothing_is_said() {
    let planned = at_rest(&carton().model, 0, 0.4, 0.1, 0.21);
    let of = |points_m: &[Point3<f64>]| reason(&told(carton(), &planned, points_m));
    let nan = Point3::new(f64::NAN, 0.1, 0.1);
    let far = Point3::new(0.1, f64::INFINITY, 1e300);
    let all = seen(&content(), 4);
    let kept = |is_kept: fn(&Point3<f64>) -> bool| -> Vec<_> {
        all.iter().copied().filter(is_kept).collect()
    };
    for points_m in [
        vec![],
        vec![nan; 1000],
        vec![far; 1000],
        vec![Point3::new(0.1, 0.1, 0.01); 1000],
        kept(|point| point.x < 0.15),
    ] {
        assert!(matches!(of(&points_m), UnclearReason::LittleSeen(_)));
    }
    // A strip without points that the item fits into.
    let without = kept(|point| point.y < 0.17 || point.y > 0.26);
    assert_eq!(of(&without), UnclearReason::CouldHide);
    let steps = [
        (0.754_877_666, 0.32),
        (0.569_840_291, 0.32),
        (0.438_312_7, 0.3),
    ];
    let scattered = (0..200_000).map(|index| {
        let part = |(step, side_m): (f64, f64)| (f64::from(index) * step).fract() * side_m;
        Point3::from(steps.map(part))
    });
    let scattered: Vec<_> = scattered.collect();
    assert_eq!(of(&scattered), UnclearReason::DoesNotFit);
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
        assert_eq!(reason(&inspection), UnclearReason::Unusable);
    }
    let coarse = Surface::from_metres(2, 2, 0.16, vec![0.0; 4]).unwrap();
    told(&planned, &coarse, EYE, CONTAINER);
    let beside = Point3::new(900.0, -900.0, 0.21);
    told(&planned, &before, beside, CONTAINER);
}
