//! Lookups, symmetries, twins and unknown items against what is known of simple shapes.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::TriMesh;
use ppnpack_camera::NoiseModel;
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::kernel::grid::{ABSENT, Resolution};
use ppnpack_recognition::library::{Library, LibrarySettings};
use ppnpack_recognition::nearest::NearestSurface;
use ppnpack_recognition::samples::surface_points;
use ppnpack_recognition::segmentation::Cluster;
use ppnpack_recognition::symmetry::Symmetry;
use ppnpack_recognition::unknown_item::{UnknownItemError, unknown_item};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::common::{at_rest, bracket, cuboid, cylinder, made, segmented};

fn library(models: &[Arc<Model>]) -> Library {
    Library::new(models, LibrarySettings::default()).unwrap()
}

/// The distance to a mesh, triangle by triangle.
fn oracle_m(mesh: &Mesh, point: &Point3<f64>) -> f64 {
    let vector = |point: &Point3<f64>| Vector::new(point.x as f32, point.y as f32, point.z as f32);
    let vertices = mesh.vertices.iter().map(vector).collect();
    let shape = TriMesh::new(vertices, mesh.triangles.clone()).unwrap();
    f64::from(shape.distance_to_local_point(vector(point), false))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_nearest_point_is_the_nearest(x in -0.01..0.08_f64, y in -0.01..0.12_f64, z in -0.01..0.05_f64) {
        let mesh = bracket();
        let surface = NearestSurface::of(&mesh).unwrap();
        let point = Point3::new(x, y, z);
        let nearest = surface.nearest(&point);
        prop_assert!((nearest.distance_m - nalgebra::distance(&point, &nearest.foot)).abs() < 1e-9);
        let excess_m = nearest.distance_m - oracle_m(&mesh, &point);
        // Two half diagonals of a cell of 2.3 mm.
        prop_assert!((-1e-5..0.004).contains(&excess_m), "{excess_m}");
    }
}

#[test]
fn near_the_surface_lookups_are_exact() {
    let mesh = bracket();
    let surface = NearestSurface::of(&mesh).unwrap();
    let points = surface_points(&mesh, 400);
    let exact = points.iter().filter(|on_surface| {
        let lifted = on_surface.point + on_surface.normal * 0.001;
        (surface.nearest(&lifted).distance_m - oracle_m(&mesh, &lifted)).abs() < 1e-5
    });
    assert!(exact.count() >= 395);
    for on_surface in &points {
        assert!(surface.nearest(&on_surface.point).distance_m < 0.001);
    }
}

#[test]
fn meshes_without_a_surface_are_refused() {
    assert!(NearestSurface::of(&Mesh::default()).is_none());
    let flat = Mesh {
        vertices: vec![Point3::origin(); 3],
        triangles: vec![[0, 1, 2], [7, 8, 9]],
    };
    assert!(NearestSurface::of(&flat).is_none());
}

#[test]
fn symmetries_are_those_of_the_shapes() {
    let library = library(&[
        made("bracket", bracket()),
        made("box", cuboid(0.12, 0.07, 0.04)),
        made("square", cuboid(0.08, 0.08, 0.03)),
        made("cube", cuboid(0.05, 0.05, 0.05)),
        made("can", cylinder(0.03, 0.1)),
    ]);
    let turns = |index: usize| match &library.objects[index].symmetry {
        Symmetry::Turns(turns) => turns.len(),
        other => panic!("{other:?}"),
    };
    // The bracket is the same upside down about the line between its legs only if they are equal.
    assert_eq!((turns(0), turns(1), turns(2), turns(3)), (1, 4, 8, 24));
    let can = &library.objects[4].symmetry;
    let is_round =
        matches!(can, Symmetry::Axis { axis, is_reversible: true } if axis.z.abs() > 0.999);
    assert!(is_round, "{can:?}");
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 1.0);
    let roll = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.3);
    assert!(can.angle_between(&yaw, &UnitQuaternion::identity()) < 0.02);
    assert!((can.angle_between(&(roll * yaw), &UnitQuaternion::identity()) - 0.3).abs() < 0.02);
}

#[test]
fn twins_are_found_with_the_transform_between_them() {
    let turned = Isometry3::new(Vector3::new(0.3, -0.1, 0.2), Vector3::new(0.4, 1.1, -0.3));
    let library = library(&[
        made("bracket", bracket()),
        made("can", cylinder(0.03, 0.1)),
        made("blue bracket", bracket().transformed(&turned)),
    ]);
    let are_alike = [(0, 2), (2, 0), (0, 1), (1, 2)].map(|(a, b)| library.are_alike(a, b));
    assert_eq!(are_alike, [true, true, false, false]);
    let truth = Isometry3::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.0, 0.5, 0.0));
    let error = library.pose_error(0, &truth, 2, &(truth * turned.inverse()));
    let error = error.unwrap();
    assert!(error.is_within(0.0005, 0.01), "{error:?}");
    let off = truth * Isometry3::new(Vector3::new(0.002, 0.0, 0.0), Vector3::new(0.0, 0.0, 0.05));
    let error = library.pose_error(0, &truth, 0, &off).unwrap();
    assert!((error.angle_rad - 0.05).abs() < 0.005, "{error:?}");
    assert!((0.001..0.006).contains(&error.position_m), "{error:?}");
    assert_eq!(library.pose_error(0, &truth, 1, &truth), None);
}

#[test]
fn an_unknown_item_is_full_below_what_is_seen() {
    let model = made("bracket", bracket());
    let truth = at_rest(&model, 0, 0.3, 0.05, 0.02);
    let clusters = segmented(&[(&model, truth)], &NoiseModel::default()).clusters;
    let resolution = Resolution::reference();
    let unknown = unknown_item("stranger", &clusters[0], &resolution).unwrap();
    assert_eq!(unknown.item.views().len(), resolution.yaws().count());
    let highest_m = clusters[0].extents_m().z;
    for (view, yaw_rad) in unknown.item.views().iter().zip(resolution.yaws().radians()) {
        let mut bottom = view.bottom().iter();
        assert!(bottom.all(|bottom| [0, ABSENT].contains(bottom)));
        assert_eq!(view.height(), resolution.units_above(highest_m));
        // Every point lies within the item.
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *yaw_rad);
        let support_from_item = clusters[0].world_from_support.inverse() * unknown.world_from_item;
        for point in &clusters[0].points_m {
            let point_m = support_from_item.inverse() * point;
            let in_view = (turn * point_m + view.origin_from_corner_m()) / resolution.cell_m();
            let (x, y) = (in_view.x as usize, in_view.y as usize);
            let at = x.min(view.nx() - 1) * view.ny() + y.min(view.ny() - 1);
            assert_eq!(view.bottom()[at], 0);
            assert!(f64::from(view.top()[at]) * resolution.height_unit_m() > point.z - 1e-6);
        }
    }
    // The bracket fills 0.11 x 0.03 + 0.04 x 0.03 m of floor; noise and cells inflate it.
    let volume_m3 = unknown.item.mesh_volume_m3();
    assert!((1.7e-4..4.5e-4).contains(&volume_m3), "{volume_m3}");
}

#[test]
fn unknown_items_of_nothing_or_too_much_are_refused() {
    let cluster = |points_m| Cluster {
        points_m,
        surroundings_m: Vec::new(),
        eye_m: Point3::new(0.0, 0.0, 1.0),
        world_from_support: Isometry3::identity(),
    };
    let make = |points| unknown_item("none", &cluster(points), &Resolution::reference());
    for nothing in [vec![], vec![Point3::new(f64::NAN, 0.0, 0.0)]] {
        assert!(matches!(make(nothing), Err(UnknownItemError::NoPoints)));
    }
    let wide = vec![Point3::origin(), Point3::new(100.0, 0.0, 0.1)];
    assert!(matches!(make(wide), Err(UnknownItemError::TooLarge(_))));
    let tall = vec![Point3::origin(), Point3::new(0.0, 0.0, 1e9)];
    assert!(matches!(make(tall), Err(UnknownItemError::TooLarge(_))));
    let one = make(vec![Point3::new(0.1, 0.2, 0.03)]).unwrap();
    assert_eq!(one.item.views()[0].voxel_count(), 15);
}
