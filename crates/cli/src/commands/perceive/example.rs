//! Clouds to try the commands on: a container, empty and with some objects, before a simulated
//! camera.

use std::path::Path;

use nalgebra::{Isometry3, Point3, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::catalogue::NamedMesh;
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_clouds::{Cloud, to_pcd};
use ppnpack_files::StagedFolder;
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_perception::doubts::DoubtSettings;
use ppnpack_perception::settings::MapperSettings;

use crate::failure::{OrRun, Outcome};
use crate::output::print_line;

/// The standard deviation of the camera's usual noise, in metres.
const NOISE_M: f64 = 0.001;

/// The thickness of walls and bottom, in metres.
const WALL_M: f64 = 0.008;

/// Objects of the built-in set, and the places of their middles, as shares of the floor.
const CONTENT: [(&str, [f64; 2]); 5] = [
    ("mug", [0.22, 0.22]),
    ("tuna_can", [0.75, 0.25]),
    ("puzzle_cube", [0.5, 0.55]),
    ("soda_can", [0.2, 0.8]),
    ("tennis_ball", [0.8, 0.8]),
];

/// Writes the clouds, and says what to do with them.
pub(super) fn write(folder: &Path) -> Outcome {
    let container = container(ContainerSize::REFERENCE);
    let mut files = StagedFolder::new(folder)?;
    let empty = seen(&container, 1)?;
    files.add("empty.pcd", &to_pcd(&empty))?;
    let content = content(ContainerSize::REFERENCE);
    let packed = seen(&[container, content].concat(), 2)?;
    files.add("packed.pcd", &to_pcd(&packed))?;
    let mapper = MapperSettings {
        doubts: DoubtSettings {
            wall_thickness_m: WALL_M,
            ..DoubtSettings::default()
        },
        ..MapperSettings::of_camera(NOISE_M)
    };
    let mapper = toml::to_string(&mapper).or_run()?;
    files.add("mapper.toml", mapper.as_bytes())?;
    files.publish()?;
    let names = ["empty.pcd", "packed.pcd", "calibration.toml", "mapper.toml"];
    let [empty, packed, calibration, mapper] =
        names.map(|name| folder.join(name).display().to_string());
    print_line(&format!(
        "Clouds of a simulated camera with 1 mm of noise: {empty} and {packed}. Try\n\n  \
         ppnpack calibrate {empty} --out {calibration}\n  \
         ppnpack perceive {packed} --container-from-sensor {calibration} --mapper {mapper}"
    ))?;
    Ok(())
}

/// Measures meshes in the container's frame with the camera.
fn seen(meshes: &[Mesh], seed: u64) -> Outcome<Cloud> {
    let ContainerSize { x_m, y_m, z_m, .. } = ContainerSize::REFERENCE;
    let middle = Point3::new(x_m / 2.0, y_m / 2.0, z_m / 2.0);
    let intrinsics = Intrinsics::centred(640, 480, 570.0).or_run()?;
    let at = middle + Vector3::new(0.08, -0.15, 0.85);
    let camera = DepthCamera::looking_at(intrinsics, at, &middle);
    let bodies = meshes.iter().map(|mesh| Body {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        world_from_body: Isometry3::identity(),
    });
    let bodies: Vec<Body<'_>> = bodies.collect();
    let points_m = camera.see(&bodies, &NoiseModel::default(), seed).or_run()?;
    Cloud::organised(intrinsics.width, points_m).or_run()
}

/// Makes a container on a table.
fn container(size: ContainerSize) -> Vec<Mesh> {
    let ContainerSize { x_m, y_m, z_m, .. } = size;
    let (low, x, y) = (-WALL_M, x_m + WALL_M, y_m + WALL_M);
    [
        ([-2.0, -2.0, low - 0.01], [2.0, 2.0, low]),
        ([low, low, low], [x, y, 0.0]),
        ([low, low, 0.0], [0.0, y, z_m]),
        ([x_m, low, 0.0], [x, y, z_m]),
        ([0.0, low, 0.0], [x_m, 0.0, z_m]),
        ([0.0, y_m, 0.0], [x_m, y, z_m]),
    ]
    .map(|(lowest, highest)| Mesh::cuboid(lowest, highest))
    .into()
}

/// Places objects on the floor.
fn content(size: ContainerSize) -> Vec<Mesh> {
    let place = |object: &NamedMesh| {
        let (_, [x, y]) = CONTENT.iter().find(|(name, _)| *name == object.name)?;
        // They stand on the ground, in the middle.
        let to = Isometry3::translation(x * size.x_m, y * size.y_m, 0.0);
        Some(object.mesh.transformed(&to))
    };
    let objects = ppnpack_household::OBJECTS.iter();
    objects.filter_map(place).collect()
}
