//! Views against a ray caster written as the definition reads, and the noise's statistics.

#![cfg(test)]

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, CameraError, DepthCamera, Intrinsics, NoiseModel};
use proptest::prelude::*;

const FLOOR: [Point3<f64>; 4] = [
    Point3::new(-3.0, -3.0, 0.0),
    Point3::new(3.0, -3.0, 0.0),
    Point3::new(3.0, 3.0, 0.0),
    Point3::new(-3.0, 3.0, 0.0),
];
const QUAD: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

fn floor_at(height_m: f64) -> Body<'static> {
    Body {
        vertices: &FLOOR,
        triangles: &QUAD,
        world_from_body: Isometry3::translation(0.0, 0.0, height_m),
    }
}

fn above(height_m: f64) -> DepthCamera {
    let intrinsics = Intrinsics::centred(160, 120, 150.0).unwrap();
    DepthCamera::looking_down(intrinsics, Point3::new(0.1, -0.2, height_m))
}

/// The depth that a ray meets first, by solving for each triangle (Moeller and Trumbore).
fn cast(camera: &DepthCamera, bodies: &[Body<'_>], u: usize, v: usize) -> Option<f64> {
    let camera_from_world = camera.world_from_camera.inverse();
    let ray = camera.intrinsics.ray(u as f64, v as f64);
    let mut nearest: Option<f64> = None;
    for body in bodies {
        let pose = camera_from_world * body.world_from_body;
        for triangle in body.triangles {
            let [a, b, c] = triangle.map(|corner| pose * body.vertices[corner as usize]);
            let columns = Matrix3::from_columns(&[b - a, c - a, -ray]);
            let Some(solution) = columns.lu().solve(&-a.coords) else {
                continue;
            };
            let (s, t, depth_m) = (solution.x, solution.y, solution.z);
            let is_inside = s >= 0.0 && t >= 0.0 && s + t <= 1.0;
            let is_seen = depth_m >= camera.near_m && depth_m <= camera.far_m;
            if is_inside && is_seen {
                nearest = Some(nearest.map_or(depth_m, |other_m| depth_m.min(other_m)));
            }
        }
    }
    nearest
}

/// What a perfect sensor measures.
fn seen(camera: &DepthCamera, bodies: &[Body<'_>]) -> Vec<Point3<f32>> {
    camera.see(bodies, &NoiseModel::none(), 3).unwrap()
}

/// What a sensor 0.9 m above the floor measures of it.
fn noisy(noise: &NoiseModel, seed: u64) -> Vec<Point3<f32>> {
    above(0.9).see(&[floor_at(0.0)], noise, seed).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn every_pixel_sees_what_its_ray_meets_first(
        corners in prop::collection::vec(prop::array::uniform3(-0.4..0.4_f64), 30),
        eye in prop::array::uniform3(-0.5..0.5_f64),
        turn in prop::array::uniform3(-3.0..3.0_f64),
    ) {
        let vertices: Vec<Point3<f64>> = corners.into_iter().map(Point3::from).collect();
        let triangles: Vec<[u32; 3]> = (0..5).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]).collect();
        let pose = Isometry3::from_parts(
            Translation3::new(0.1, 0.0, 0.0),
            UnitQuaternion::from_scaled_axis(Vector3::from(turn)),
        );
        let bodies = [
            Body { vertices: &vertices[..15], triangles: &triangles, world_from_body: pose },
            Body { vertices: &vertices[15..], triangles: &triangles, world_from_body: pose.inverse() },
        ];
        let intrinsics = Intrinsics { width: 24, height: 18, fx: 20.0, fy: 23.0, cx: 10.3, cy: 9.1 };
        // The eye is among the triangles, so that some reach behind it.
        let camera = DepthCamera::looking_at(intrinsics, Point3::from(eye), &Point3::origin());
        let points = seen(&camera, &bodies);
        let mut differing = 0;
        for v in 0..intrinsics.height {
            for u in 0..intrinsics.width {
                let seen = f64::from(points[v * intrinsics.width + u].z);
                let is_same = match cast(&camera, &bodies, u, v) {
                    Some(depth_m) => (seen - depth_m).abs() < 1e-4 * depth_m.max(1.0),
                    None => seen.is_nan(),
                };
                differing += usize::from(!is_same);
            }
        }
        // Rays within rounding of an edge may fall on either side.
        prop_assert!(differing <= 1, "{differing} pixels differ");
    }
}

#[test]
fn a_floor_is_seen_at_its_depth_everywhere() {
    let camera = above(0.9);
    let points = seen(&camera, &[floor_at(0.0)]);
    assert!(points.iter().all(|point| (point.z - 0.9).abs() < 1e-6));
    for point in camera.in_world_m(&points) {
        assert!(point.z.abs() < 1e-6);
    }
}

#[test]
fn what_is_nearer_hides_what_is_behind() {
    let plate: Vec<_> = FLOOR.iter().map(|corner| corner / 30.0).collect();
    let plate = Body {
        vertices: &plate,
        triangles: &QUAD,
        world_from_body: Isometry3::translation(0.1, -0.2, 0.3),
    };
    for bodies in [[floor_at(0.0), plate], [plate, floor_at(0.0)]] {
        let points = seen(&above(0.9), &bodies);
        let is_at = |depth_m: f32| move |point: &&Point3<f32>| (point.z - depth_m).abs() < 1e-6;
        // 0.2 m at 150 px and 0.6 m of depth.
        let count = points.iter().filter(is_at(0.6)).count();
        assert!((2400..=2601).contains(&count), "{count}");
        let behind = points.iter().filter(is_at(0.9)).count();
        assert_eq!(count + behind, 160 * 120);
    }
}

/// Image coordinates of a point of the camera frame.
fn projected(intrinsics: &Intrinsics, point: &Point3<f64>) -> [f64; 2] {
    let Intrinsics { fx, fy, cx, cy, .. } = intrinsics;
    [fx * point.x / point.z + cx, fy * point.y / point.z + cy]
}

#[test]
fn an_upright_camera_has_up_above() {
    let intrinsics = Intrinsics::centred(100, 80, 100.0).unwrap();
    let camera = DepthCamera::looking_at(intrinsics, Point3::new(1.0, 0.0, 1.0), &Point3::origin());
    let camera_from_world = camera.world_from_camera.inverse();
    let at = |y, z| projected(&intrinsics, &(camera_from_world * Point3::new(0.0, y, z)));
    let middle = at(0.0, 0.0);
    assert!((middle[0] - 49.5).abs() < 1e-9 && (middle[1] - 39.5).abs() < 1e-9);
    assert!(at(0.0, 0.1)[1] < middle[1] && at(0.1, 0.0)[0] > middle[0]);
}

#[test]
fn a_framed_rectangle_is_within_the_image_and_nearly_fills_it() {
    for (width, height) in [(400, 400), (640, 480), (300, 700)] {
        let intrinsics = Intrinsics::framing(width, height, [0.4, 0.3], 0.9).unwrap();
        let [u, v] = projected(&intrinsics, &Point3::new(0.2, 0.15, 0.9));
        let right = (u - intrinsics.cx) / (width as f64 / 2.0);
        let down = (v - intrinsics.cy) / (height as f64 / 2.0);
        assert!((right.max(down) - 0.95).abs() < 1e-9, "{right} {down}");
    }
    assert!(Intrinsics::framing(64, 64, [0.4, 0.3], -0.1).is_err());
    assert!(Intrinsics::framing(64, 64, [0.0, 0.3], 0.9).is_err());
}

#[test]
fn noise_has_the_deviation_and_dropouts_asked_for() {
    let points = noisy(&NoiseModel::default(), 3);
    let truth = noisy(&NoiseModel::none(), 3);
    let mut errors_m = Vec::new();
    for (point, truth) in points.iter().zip(&truth) {
        if !point.z.is_nan() {
            errors_m.push(f64::from(point.coords.norm() - truth.coords.norm()));
            // Points stay on their rays.
            assert!(point.coords.cross(&truth.coords).norm() < 1e-6);
        }
    }
    let count = errors_m.len() as f64;
    let dropped = 1.0 - count / points.len() as f64;
    assert!((dropped - 0.05).abs() < 0.006, "{dropped}");
    let mean_m = errors_m.iter().sum::<f64>() / count;
    assert!(mean_m.abs() < 5e-5, "{mean_m}");
    let squares = errors_m.iter().map(|error_m| (error_m - mean_m).powi(2));
    let sigma_m = (squares.sum::<f64>() / count).sqrt();
    assert!((sigma_m / 0.001 - 1.0).abs() < 0.03, "{sigma_m}");
}

#[test]
fn noise_follows_from_the_seed_alone() {
    let bits = |seed| -> Vec<u32> {
        let points = noisy(&NoiseModel::default(), seed).into_iter();
        points.map(|point| point.z.to_bits()).collect()
    };
    assert_eq!(bits(1), bits(1));
    assert_ne!(bits(1), bits(2));
    let steps = NoiseModel {
        step_m: 0.007,
        ..NoiseModel::none()
    };
    let mut stepped = noisy(&steps, 3).into_iter();
    assert!(stepped.all(|point| (point.z - 0.903).abs() < 1e-6));
}

#[test]
fn impossible_cameras_and_noise_are_refused() {
    for focal in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            Intrinsics::centred(10, 10, focal),
            Err(CameraError::Setting(error)) if error.name == "fx"
        ));
    }
    assert!(Intrinsics::centred(0, 10, 1.0).is_err());
    assert!(Intrinsics::centred(10, 10_000, 1.0).is_err());
    let mut camera = above(0.9);
    let none = NoiseModel::none();
    camera.world_from_camera.translation.x = f64::NAN;
    let refused = camera.see(&[], &none, 1);
    assert!(matches!(refused, Err(CameraError::Pose)));
    let mut camera = above(0.9);
    camera.far_m = 0.05;
    assert!(camera.see(&[], &none, 1).is_err());
    let points = seen(&above(0.9), &[]);
    assert!(points.iter().all(|point| point.z.is_nan()));
    let refused = |change: fn(&mut NoiseModel)| {
        let mut noise = NoiseModel::default();
        change(&mut noise);
        above(0.9).see(&[], &noise, 1).is_err()
    };
    assert!(refused(|noise| noise.dropout = 1.5));
    assert!(refused(|noise| noise.sigma_m = f64::NAN));
    assert!(refused(|noise| noise.step_m = -0.1));
}

#[test]
fn damaged_meshes_are_seen_as_far_as_they_are_sound() {
    let mut vertices = FLOOR.to_vec();
    vertices.push(Point3::new(f64::NAN, 0.0, 0.0));
    vertices.push(Point3::new(f64::INFINITY, 0.0, 1e300));
    let triangles = [[0, 1, 2], [0, 1, 99], [0, 4, 2], [5, 1, 2], [2, 2, 2]];
    let body = Body {
        vertices: &vertices,
        triangles: &triangles,
        world_from_body: Isometry3::identity(),
    };
    let mut points = seen(&above(0.9), &[body]);
    points.retain(|point| !point.z.is_nan());
    assert!(!points.is_empty() && points.iter().all(|point| (point.z - 0.9).abs() < 1e-6));
}
