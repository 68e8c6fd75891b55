//! How long an image takes: 20 objects of 2,000 triangles on a floor, 640 x 480.
#![allow(clippy::unwrap_used, missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Isometry3, Point3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};

/// A globe of 50 x 20 quadrilaterals.
fn globe(radius_m: f64) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let (around, rings) = (50, 21);
    let at = |ring: u32, step: u32| {
        let down = std::f64::consts::PI * f64::from(ring) / f64::from(rings - 1);
        let turn = std::f64::consts::TAU * f64::from(step) / f64::from(around);
        Point3::new(turn.cos() * down.sin(), turn.sin() * down.sin(), down.cos()) * radius_m
    };
    let vertices = (0..rings).flat_map(|ring| (0..around).map(move |step| at(ring, step)));
    let squares = (0..rings - 1).flat_map(|ring| (0..around).map(move |step| (ring, step)));
    let triangles = squares.flat_map(|(ring, step)| {
        let next = (step + 1) % around;
        let [a, b] = [ring * around + step, ring * around + next];
        [[a, b, a + around], [b, b + around, a + around]]
    });
    (vertices.collect(), triangles.collect())
}

fn render(criterion: &mut Criterion) {
    let (vertices, triangles) = globe(0.04);
    let corner = |x, y| Point3::new(x, y, 0.0);
    let floor = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    let mut bodies = vec![Body {
        vertices: &floor,
        triangles: &[[0, 1, 2], [0, 2, 3]],
        world_from_body: Isometry3::identity(),
    }];
    for index in 0..20 {
        let (x, y) = (
            f64::from(index % 5) * 0.1 - 0.2,
            f64::from(index / 5) * 0.1 - 0.15,
        );
        bodies.push(Body {
            vertices: &vertices,
            triangles: &triangles,
            world_from_body: Isometry3::translation(x, y, 0.04),
        });
    }
    let intrinsics = Intrinsics::centred(640, 480, 600.0).unwrap();
    let camera = DepthCamera::looking_down(intrinsics, Point3::new(0.0, 0.0, 0.9));
    criterion.bench_function("perfect view of 20 objects", |bencher| {
        bencher.iter(|| camera.see(&bodies).unwrap());
    });
    let view = camera.see(&bodies).unwrap();
    criterion.bench_function("noisy points of a view", |bencher| {
        bencher.iter(|| view.noisy_points(&NoiseModel::default(), 1).unwrap());
    });
}

criterion_group!(benches, render);
criterion_main!(benches);
