//! How long a cloud takes to become a scene.
#![allow(clippy::unwrap_used, missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Isometry3, Point3};
use ppnpack_packing::grid::Grid;
use ppnpack_perception::mapper::Mapper;
use ppnpack_perception::settings::MapperSettings;

/// Points as a camera above sees them, row by row: boxes of many heights on a floor, with a millimetre of noise.
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
            let points = cloud(count);
            criterion.bench_function(&format!("{count} points, {sensor} sensor"), |bencher| {
                bencher.iter(|| {
                    mapper
                        .map(points.iter().copied(), &Isometry3::identity())
                        .unwrap()
                });
            });
        }
    }
}

criterion_group!(benches, mapping);
criterion_main!(benches);
