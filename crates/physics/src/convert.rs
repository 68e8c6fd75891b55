//! Conversions between metres in double precision and the engine's unit and single-precision types.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::math::{Pose, Rotation, Vector};

/// The engine counts lengths in decimetres.
///
/// Its tolerances are absolute: for the edges and gaps of household items in metres, its
/// penetration depths come out wrong by millimetres, and items sink into one another.
const UNITS_PER_M: f64 = 10.0;

/// A length, or anything else that grows with it, in the engine's unit.
pub(crate) fn engine_length(length_m: f64) -> f32 {
    (length_m * UNITS_PER_M) as f32
}

/// A length, or anything else that grows with it, of the engine, in metres.
pub(crate) fn metres(length: f32) -> f64 {
    f64::from(length) / UNITS_PER_M
}

/// A vector of lengths in the engine's unit.
pub(crate) fn engine_vector(vector_m: &Vector3<f64>) -> Vector {
    Vector::new(
        engine_length(vector_m.x),
        engine_length(vector_m.y),
        engine_length(vector_m.z),
    )
}

/// A rotation in the engine's precision.
pub(crate) fn engine_rotation(rotation: &UnitQuaternion<f64>) -> Rotation {
    let [x, y, z, w] = [rotation.i, rotation.j, rotation.k, rotation.w].map(|part| part as f32);
    Rotation::from_xyzw(x, y, z, w).normalize()
}

/// A pose in the engine's unit.
pub(crate) fn engine_pose(pose: &Isometry3<f64>) -> Pose {
    Pose::from_parts(
        engine_vector(&pose.translation.vector),
        engine_rotation(&pose.rotation),
    )
}

/// A point of the engine, in metres.
pub(crate) fn point_m(vector: Vector) -> Point3<f64> {
    Point3::new(metres(vector.x), metres(vector.y), metres(vector.z))
}

/// A pose of the engine, in metres.
pub(crate) fn isometry(pose: &Pose) -> Isometry3<f64> {
    let translation = Translation3::from(point_m(pose.translation).coords);
    let [x, y, z, w] = pose.rotation.to_array().map(f64::from);
    Isometry3::from_parts(
        translation,
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
    )
}

/// Principal inertias in the engine's unit.
pub(crate) fn engine_inertia(inertia_kg_m2: &Vector3<f64>) -> Vector {
    engine_vector(&(inertia_kg_m2 * UNITS_PER_M))
}
