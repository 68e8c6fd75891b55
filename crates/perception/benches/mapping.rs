//! How long a cloud takes to become a scene.
#![allow(clippy::unwrap_used, missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Isometry3, Point3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_perception::mapper::Mapper;
use ppnpack_perception::settings::MapperSettings;

/// Points as a camera above sees them, row by row: boxes of many heights on a floor, with a
/// millimetre of noise.
fn cloud(count: u32) -> Vec<Point3<f32>> {
    let side = f64::from(count).sqrt().ceil() as u32;
    let place = |index: u32| 0.32 * (f64::from(index) + 0.5) / f64::from(side);
    let height_m = |x_m: f64, y_m: f64| {
        let (column, row) = ((x_m / 0.05).floor(), (y_m / 0.07).floor());
        let noise_m =
            0.001 * ((7919.0 * x_m + 3571.0 * y_m).sin() + (2207.0 * x_m - 9349.0 * y_m).sin());
        0.02 * ((3.0 * column + 5.0 * row) % 7.0) + noise_m
    };
    (0..side)
        .flat_map(|row| (0..side).map(move |column| (place(column), place(row))))
        .map(|(x_m, y_m)| Point3::new(x_m, y_m, height_m(x_m, y_m)).cast())
        .collect()
}

/// Gives the cloud of a camera 0.9 m above a packed container: some 300,000 points, a tenth of the
/// surface in shadows.
fn seen() -> (Vec<Point3<f32>>, Isometry3<f64>) {
    let side = 0.32;
    let mut meshes: Vec<Mesh> = (0..36_u8)
        .map(|number| {
            let (column, row) = (f64::from(number % 6), f64::from(number / 6));
            let height_m = 0.03 * ((3.0 * column + 5.0 * row) % 7.0) + 0.01;
            let [x, y] = [column, row].map(|at| 0.052 * at + 0.006);
            Mesh::cuboid([x, y, 0.0], [x + 0.045, y + 0.045, height_m])
        })
        .collect();
    meshes.push(Mesh::cuboid([0.0, 0.0, -0.01], [side, side, 0.0]));
    meshes.push(Mesh::cuboid([-0.01, -0.01, 0.0], [0.0, side, 0.3]));
    meshes.push(Mesh::cuboid([side, 0.0, 0.0], [side + 0.01, side, 0.3]));
    meshes.push(Mesh::cuboid([0.0, -0.01, 0.0], [side, 0.0, 0.3]));
    meshes.push(Mesh::cuboid([0.0, side, 0.0], [side, side + 0.01, 0.3]));
    let bodies = meshes.iter().map(|mesh| Body {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        world_from_body: Isometry3::identity(),
    });
    let intrinsics = Intrinsics::framing(576, 576, [side, side], 0.6).unwrap();
    let camera = DepthCamera::looking_down(intrinsics, Point3::new(0.16, 0.16, 0.9));
    let points = camera.see(&bodies.collect::<Vec<_>>(), &NoiseModel::default(), 1);
    (points.unwrap(), camera.world_from_camera)
}

fn bounding(criterion: &mut Criterion) {
    let (points, pose) = seen();
    let measured = points.iter().filter(|point| !point.z.is_nan()).count();
    let resolution = Resolution::new(0.0025, 0.002, Yaws::half_turn(4).unwrap()).unwrap();
    let grid = Grid::new(ContainerSize::REFERENCE, resolution).unwrap();
    let mut mapper = Mapper::new(&grid, MapperSettings::of_camera(0.001)).unwrap();
    let name = format!("{measured} points of a camera, with bounds");
    criterion.bench_function(&name, |bencher| {
        bencher.iter(|| mapper.map(points.iter().copied(), &pose).unwrap());
    });
}

fn mapping(criterion: &mut Criterion) {
    let noisy = MapperSettings {
        noise_m: 0.001,
        point_radius_m: 0.001,
        largest_hole_m: 0.005,
        ..MapperSettings::default()
    };
    for (sensor, settings) in [("exact", MapperSettings::default()), ("noisy", noisy)] {
        let mut mapper = Mapper::new(&Grid::reference(), settings).unwrap();
        for count in [300_000, 2_000_000] {
            let (points, pose) = (cloud(count), Isometry3::identity());
            criterion.bench_function(&format!("{count} points, {sensor} sensor"), |bencher| {
                bencher.iter(|| mapper.map(points.iter().copied(), &pose).unwrap());
            });
        }
    }
}

criterion_group!(benches, bounding, mapping);
criterion_main!(benches);
