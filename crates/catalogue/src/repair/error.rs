//! Why a mesh is no object that can be packed.

use crate::unit::LengthUnit;

/// The most triangles of a mesh.
pub const MAX_TRIANGLES: usize = 1_000_000;

/// The least greatest extent of an object, in metres.
pub const MIN_SIZE_M: f64 = 0.001;

/// The greatest extent of an object, in metres.
pub const MAX_SIZE_M: f64 = 5.0;

/// Why a mesh is no object that can be packed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There is no triangle.
    #[error("has no triangles: export the object as a surface mesh")]
    Empty,
    /// There are more triangles than make sense.
    #[error(
        "has {triangles} triangles where {MAX_TRIANGLES} are possible: reduce them, some thousands are enough"
    )]
    TooManyTriangles {
        /// How many there are.
        triangles: usize,
    },
    /// A coordinate is missing, infinite or no number.
    #[error("has a vertex (number {vertex}) that is not finite: export it again")]
    NotFinite {
        /// The vertex, counted from 0.
        vertex: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error(
        "has a triangle (number {triangle}) that names vertex {vertex} of {vertices}: export it again"
    )]
    MissingVertex {
        /// The triangle, counted from 0.
        triangle: usize,
        /// The vertex that it names, counted from 0.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// The surface has holes that are too large or too ragged to close.
    #[error(
        "is not closed: {edges} edges lack a neighbour. Close the holes in a mesh editor (\"make manifold\", \"fill holes\")"
    )]
    Open {
        /// How many edges lack a neighbour.
        edges: usize,
    },
    /// The surface has no inside.
    #[error(
        "has no inside and outside, like a Moebius strip or with edges where walls meet: make it manifold in a mesh editor"
    )]
    NotOrientable,
    /// The surface encloses hardly any volume.
    #[error("has no thickness: it encloses {volume_m3:.3e} m^3. Give its walls a thickness")]
    NoThickness {
        /// The enclosed volume, in cubic metres.
        volume_m3: f64,
    },
    /// The object is smaller or larger than any that makes sense.
    #[error("is {} m long, outside {MIN_SIZE_M} to {MAX_SIZE_M} m{}", (.size_m * 1e6).round() / 1e6, suggestion(.unit))]
    Size {
        /// The greatest extent, in metres.
        size_m: f64,
        /// The unit of length in which the object would have a likely size.
        unit: Option<LengthUnit>,
    },
}

fn suggestion(unit: &Option<LengthUnit>) -> String {
    match unit {
        Some(unit) => format!(": it is likely drawn in {unit}; give that as its unit"),
        None => String::from(": give the unit in which it is drawn"),
    }
}
