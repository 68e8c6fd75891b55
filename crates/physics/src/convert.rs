//! Conversions between nalgebra in double precision and the engine's single-precision types.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::math::{Pose, Rotation, Vector};

pub(crate) fn upm() -> f64 { use std::sync::OnceLock; static S: OnceLock<f64> = OnceLock::new(); *S.get_or_init(|| std::env::var("SCALE").ok().and_then(|v| v.parse().ok()).unwrap_or(10.0)) }

/// A length, or anything else that grows with it, in the engine's unit.
pub(crate) fn engine_length(length_m: f64) -> f32 {
    (length_m * upm()) as f32
}

/// A length of the engine in metres.
pub(crate) fn metres(length: f32) -> f64 {
    f64::from(length) / upm()
}

pub(crate) fn engine_vector(vector_m: &Vector3<f64>) -> Vector {
    Vector::new(engine_length(vector_m.x), engine_length(vector_m.y), engine_length(vector_m.z))
}

pub(crate) fn engine_rotation(rotation: &UnitQuaternion<f64>) -> Rotation {
    let [x, y, z, w] = [rotation.i, rotation.j, rotation.k, rotation.w].map(|part| part as f32);
    Rotation::from_xyzw(x, y, z, w).normalize()
}

pub(crate) fn engine_pose(pose: &Isometry3<f64>) -> Pose {
    Pose::from_parts(engine_vector(&pose.translation.vector), engine_rotation(&pose.rotation))
}

pub(crate) fn point(vector: Vector) -> Point3<f64> {
    Point3::new(metres(vector.x), metres(vector.y), metres(vector.z))
}

pub(crate) fn isometry(pose: &Pose) -> Isometry3<f64> {
    let translation = Translation3::from(point(pose.translation).coords);
    let [x, y, z, w] = pose.rotation.to_array().map(f64::from);
    Isometry3::from_parts(translation, UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)))
}

/// Principal inertias in the engine's unit.
pub(crate) fn engine_inertia(inertia_kg_m2: &Vector3<f64>) -> Vector {
    engine_vector(&(inertia_kg_m2 * upm()))
}
