//! Iterative closest points: a pose that brings a surface to points. Written here, as the pose is
//! held to its support while it is aligned, which libraries for point clouds do not offer.

use nalgebra::{Isometry3, Matrix6, Point3, Translation3, UnitQuaternion, Vector3, Vector6};

use crate::moments::centroid;
use crate::nearest::NearestSurface;

/// Maximum distance at which the direction to the surface is its normal, in metres.
const ON_SURFACE_M: f64 = 1e-4;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AlignSettings {
    pub(crate) rounds: usize,
    /// Distances, at first and at the end, much beyond which points count little, in metres.
    pub(crate) scale_m: (f64, f64),
    /// Hold of the pose to the support; `None` where it is free.
    pub(crate) hold: Option<Hold>,
}

impl AlignSettings {
    pub(crate) const fn new(rounds: usize, scale_m: (f64, f64), hold: Option<Hold>) -> Self {
        Self {
            rounds,
            scale_m,
            hold,
        }
    }
}

/// Deviations of a pose on a support from resting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hold {
    /// Standard deviation of the tilt, in radians.
    pub(crate) tilt_rad: f64,
    /// Standard deviation of the height, in metres.
    pub(crate) height_m: f64,
}

/// Standard deviation of one point's distance, in metres.
const POINT_DEVIATION_M: f64 = 0.001;

/// Moves a surface from a pose (`target_from_surface`) to where it is near points of the target
/// frame.
///
/// Each round linearises the distance of every point along the direction to its nearest surface
/// point (point-to-plane where that lies inside a face, point-to-point beyond a border: Chen and
/// Medioni 1991, Besl and McKay 1992), weighs it by Geman and McClure's function with a scale that
/// shrinks, and solves for the six degrees of freedom.
pub(crate) fn align(
    surface: &NearestSurface,
    points: &[Point3<f64>],
    start: &Isometry3<f64>,
    settings: &AlignSettings,
) -> Isometry3<f64> {
    let Some(centre) = centroid(points) else {
        return *start;
    };
    let mut pose = *start;
    for round in 0..settings.rounds {
        let share = round as f64 / (settings.rounds.max(2) - 1) as f64;
        let (wide_m, narrow_m) = settings.scale_m;
        let scale_m = wide_m * (narrow_m / wide_m).powf(share);
        let poses = [&pose, start];
        let Some(step) = step(surface, points, poses, &centre, scale_m, settings.hold) else {
            break;
        };
        pose = moved(&pose, &step, &centre);
        if step.norm() < 1e-5 && round > 2 {
            break;
        }
    }
    pose
}

/// Gives one Gauss-Newton step: rotation about the centre and translation.
fn step(
    surface: &NearestSurface,
    points: &[Point3<f64>],
    [pose, start]: [&Isometry3<f64>; 2],
    centre: &Point3<f64>,
    scale_m: f64,
    hold: Option<Hold>,
) -> Option<Vector6<f64>> {
    let inverse = pose.inverse();
    let (turn_back, shift_back) = (inverse.rotation.to_rotation_matrix(), inverse.translation);
    let turn = pose.rotation.to_rotation_matrix();
    let mut normal_matrix = Matrix6::zeros();
    let mut right_side = Vector6::zeros();
    for point in points {
        let local = turn_back * point + shift_back.vector;
        let nearest = surface.nearest(&local);
        let distance_m = nearest.distance_m;
        let (direction, distance_m) = if distance_m > ON_SURFACE_M {
            ((local - nearest.foot) / distance_m, distance_m)
        } else {
            (nearest.normal, (local - nearest.foot).dot(&nearest.normal))
        };
        let ratio = distance_m / scale_m;
        let weight = 1.0 / (1.0 + ratio * ratio).powi(2);
        let direction = turn * direction;
        let arm = (point - centre).cross(&direction);
        let row = Vector6::new(arm.x, arm.y, arm.z, direction.x, direction.y, direction.z);
        normal_matrix.syger(weight, &row, &row, 1.0);
        right_side += row * (weight * distance_m);
    }
    if let Some(hold) = hold {
        let tilted = (pose.rotation * start.rotation.inverse()).scaled_axis();
        let raised_m = (pose * start.inverse() * centre).z - centre.z;
        let variance = POINT_DEVIATION_M * POINT_DEVIATION_M;
        let pulls = [
            (0, variance / hold.tilt_rad.powi(2), tilted.x),
            (1, variance / hold.tilt_rad.powi(2), tilted.y),
            (5, variance / hold.height_m.powi(2), raised_m),
        ];
        for (axis, weight, deviation) in pulls {
            if let (Some(diagonal), Some(right)) = (
                normal_matrix.get_mut((axis, axis)),
                right_side.get_mut(axis),
            ) {
                *diagonal += weight;
                *right -= weight * deviation;
            }
        }
    }
    // What the points say nothing about stays as it is.
    for (axis, damping) in [1e-9, 1e-9, 1e-9, 1e-5, 1e-5, 1e-5].into_iter().enumerate() {
        if let Some(diagonal) = normal_matrix.get_mut((axis, axis)) {
            *diagonal += damping * points.len() as f64 + 1e-12;
        }
    }
    let step = normal_matrix.cholesky()?.solve(&right_side);
    step.iter().all(|value| value.is_finite()).then_some(step)
}

/// Turns a pose about a centre and shifts it.
pub(crate) fn moved(
    pose: &Isometry3<f64>,
    step: &Vector6<f64>,
    centre: &Point3<f64>,
) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(step.x, step.y, step.z));
    let shift = Vector3::new(step.w, step.a, step.b);
    let about = Isometry3::rotation_wrt_point(rotation, *centre);
    Translation3::from(shift) * about * pose
}
