//! Made-up objects, and simulated views of them.

use std::path::Path;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::build::{ModelSettings, model};
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings, Source};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::Model;
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_recognition::library::{Library, LibraryObject, LibrarySettings};
use ppnpack_recognition::recognise::{Recogniser, RecognitionSettings};
use ppnpack_recognition::segmentation::{Region, Segmentation, SegmentationSettings, segment};

/// A prism over an outline (counter-clockwise, in metres) that its first corner sees all of.
pub(crate) fn prism(outline: &[[f64; 2]], height_m: f64) -> Mesh {
    let count = outline.len() as u32;
    let level = |z: f64| outline.iter().map(move |[x, y]| Point3::new(*x, *y, z));
    let ends = (1..count - 1).flat_map(|corner| {
        let top = [count, count + corner, count + corner + 1];
        [[0, corner + 1, corner], top]
    });
    let sides = (0..count).flat_map(|corner| {
        let next = (corner + 1) % count;
        let upper = [corner, count + next, count + corner];
        [[corner, next, count + next], upper]
    });
    let triangles = ends.chain(sides).collect();
    Mesh {
        vertices: level(0.0).chain(level(height_m)).collect(),
        triangles,
    }
}

pub(crate) fn cuboid(x: f64, y: f64, z: f64) -> Mesh {
    prism(&[[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]], z)
}

pub(crate) fn cylinder(radius_m: f64, height_m: f64) -> Mesh {
    let corner = |step: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(step) / 48.0).sin_cos();
        [radius_m * cos, radius_m * sin]
    };
    prism(&(0..48).map(corner).collect::<Vec<_>>(), height_m)
}

/// An angle with legs of two lengths: no turn makes it look the same.
pub(crate) fn bracket() -> Mesh {
    let (long, short, thick) = (0.11, 0.07, 0.03);
    let legs = [
        [thick, thick],
        [thick, long],
        [0.0, long],
        [0.0, 0.0],
        [short, 0.0],
    ];
    prism(&[&legs[..], &[[short, thick]]].concat(), 0.04)
}

pub(crate) fn wedge() -> Mesh {
    prism(&[[0.0, 0.0], [0.09, 0.0], [0.0, 0.05]], 0.06)
}

pub(crate) fn models() -> Vec<Arc<Model>> {
    let shapes = [
        ("bracket", bracket()),
        ("box", cuboid(0.12, 0.07, 0.04)),
        ("can", cylinder(0.033, 0.1)),
        ("wedge", wedge()),
        ("tile", cuboid(0.1, 0.1, 0.015)),
    ];
    shapes.map(|(name, mesh)| made(name, mesh)).into()
}

/// A model of a surface.
pub(crate) fn made(name: &str, mesh: Mesh) -> Arc<Model> {
    Arc::new(model(name, mesh, &ModelSettings::default()).unwrap().0)
}

/// The objects of a folder.
pub(crate) fn folder(path: &Path) -> Vec<Arc<Model>> {
    let settings = Settings {
        cache: CacheDir::Nowhere,
        ..Settings::default()
    };
    let source = Source::Folder(path.to_owned());
    let catalogue = Catalogue::load(&source, &settings, &Resolution::reference(), &|_, _| ());
    catalogue.unwrap().models()
}

pub(crate) fn recogniser(models: &[Arc<Model>]) -> Recogniser {
    let library = Library::new(models, LibrarySettings::default()).unwrap();
    Recogniser::new(Arc::new(library), RecognitionSettings::default())
}

/// A pose at rest with its centre of mass over a place.
pub(crate) fn at_rest(
    model: &Model,
    pose: usize,
    yaw_rad: f64,
    x_m: f64,
    y_m: f64,
) -> Isometry3<f64> {
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    let turned = yaw * model.resting_poses[pose].rotation;
    let heights_m = model.mesh.vertices.iter().map(|vertex| (turned * vertex).z);
    let lowest_m = heights_m.fold(f64::INFINITY, f64::min);
    let centre = turned * model.mass.centre_of_mass_m;
    Translation3::new(x_m - centre.x, y_m - centre.y, -lowest_m) * turned
}

pub(crate) fn body(mesh: &Mesh, world_from_body: Isometry3<f64>) -> Body<'_> {
    Body {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        world_from_body,
    }
}

/// What a camera above a tray sees of posed objects: points in the world, and where the camera is.
pub(crate) fn view(
    items: &[(&Model, Isometry3<f64>)],
    noise: &NoiseModel,
) -> (Vec<Point3<f64>>, Point3<f64>) {
    let tray = cuboid(4.0, 4.0, 0.1);
    let under = Isometry3::translation(-2.0, -2.0, -0.1);
    let items = items.iter().map(|(model, pose)| (&model.mesh, *pose));
    let bodies = std::iter::once((&tray, under)).chain(items);
    let bodies: Vec<_> = bodies.map(|(mesh, pose)| body(mesh, pose)).collect();
    let eye = Point3::new(0.03, -0.04, 0.9);
    let intrinsics = Intrinsics::centred(640, 480, 600.0).unwrap();
    let camera = DepthCamera::looking_at(intrinsics, eye, &Point3::origin());
    let points = camera.see(&bodies, noise, 11).unwrap();
    (camera.in_world_m(&points).collect(), eye)
}

pub(crate) fn region() -> Region {
    Region {
        lowest_m: Point3::new(-0.4, -0.3, -0.05),
        highest_m: Point3::new(0.4, 0.3, 0.5),
    }
}

/// The clusters that a camera sees of posed objects.
pub(crate) fn segmented(items: &[(&Model, Isometry3<f64>)], noise: &NoiseModel) -> Segmentation {
    let (points, eye) = view(items, noise);
    segment(points, &eye, &SegmentationSettings::of(region()))
}

/// One object, prepared.
pub(crate) fn object_of(name: &str, mesh: Mesh) -> LibraryObject {
    let library = Library::new(&[made(name, mesh)], LibrarySettings::default()).unwrap();
    library.objects.into_iter().next().unwrap()
}
