//! Checks that a mesh is a closed solid of a sensible size, and repairs what can be repaired.

mod faces;
mod holes;
mod junctions;
mod orientation;
mod weld;

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::ObjectError;
use crate::mesh::Mesh;
use crate::unit::LengthUnit;

pub(crate) use self::weld::weld;
/// The most triangles of a mesh.
pub const MAX_TRIANGLES: usize = 1_000_000;

/// The least greatest extent of an object, in metres.
const MIN_SIZE_M: f64 = 0.001;

/// The greatest extent of an object, in metres.
const MAX_SIZE_M: f64 = 5.0;

/// A solid is at least this thick on average, in metres: twice its volume over its surface.
const MIN_THICKNESS_M: f64 = 1e-5;

/// Something about a mesh that was put right, or that is to be looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Repair {
    /// Vertices in the same place became one.
    Welded(usize),
    /// Vertices that no triangle names were removed.
    UnusedVertices(usize),
    /// Triangles without area were removed.
    Degenerate(usize),
    /// Triangles that lie on another were removed.
    Duplicate(usize),
    /// Triangles that wound against their neighbours, or inwards, were turned.
    Turned(usize),
    /// Small flat holes were closed.
    Capped(usize),
    /// Triangles were cut where a vertex of others lies on their side.
    Cut(usize),
    /// Shells inside others, facing outwards like them, were left out.
    Nested(usize),
    /// Percent of the volume that parts share, and that is counted once.
    Shared(usize),
    /// Nothing was put right: it is larger or heavier than what is packed.
    Unlikely {
        /// Greatest extent, in millimetres.
        size_mm: u32,
        /// Mass, in kilograms.
        mass_kg: u32,
        /// Unit in which it was taken to be drawn.
        unit: LengthUnit,
    },
}

impl Repair {
    /// Whether the object may be another than the one that was meant.
    pub fn is_doubt(&self) -> bool {
        matches!(
            self,
            Self::Nested(_) | Self::Shared(_) | Self::Unlikely { .. }
        )
    }
}

impl fmt::Display for Repair {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Welded(count) => write!(formatter, "{count} vertices welded to others"),
            Self::UnusedVertices(count) => write!(formatter, "{count} unused vertices removed"),
            Self::Degenerate(count) => write!(formatter, "{count} triangles without area removed"),
            Self::Duplicate(count) => write!(formatter, "{count} triangles on others removed"),
            Self::Turned(count) => write!(formatter, "{count} triangles turned to face outwards"),
            Self::Capped(count) => write!(formatter, "{count} small flat holes closed"),
            Self::Cut(count) => write!(
                formatter,
                "{count} triangles cut at vertices on their sides"
            ),
            Self::Nested(count) => write!(formatter, "{count} shells inside others left out"),
            Self::Shared(percent) => write!(
                formatter,
                "parts overlap: {percent} % of the volume counted once, unite them in the drawing"
            ),
            Self::Unlikely {
                size_mm,
                mass_kg,
                unit,
            } => {
                let size_m = f64::from(*size_mm) / 1000.0;
                write!(
                    formatter,
                    "{size_m} m long and {mass_kg} kg is not likely: it was read in {unit}"
                )?;
                match likely_units(size_m / unit.metres()) {
                    units if units.is_empty() => Ok(()),
                    units => write!(formatter, "; give {units} as its unit if it was drawn so"),
                }
            }
        }
    }
}

/// The closed solid that a mesh is, and what was repaired to make it one.
///
/// In the result every edge is passed as often in one direction as in the other, triangles wind
/// counter-clockwise seen from outside, and every vertex is used. Triangles without area stay
/// where the surface would have a crack without them. `unit` is the unit in which the mesh was
/// drawn; it only serves to suggest another.
///
/// # Errors
/// [`ObjectError`] where the mesh is no solid of a sensible size and cannot be made one.
pub fn repaired(mut mesh: Mesh, unit: LengthUnit) -> Result<(Mesh, Vec<Repair>), ObjectError> {
    checked_numbers(&mesh)?;
    checked_size(&mesh, unit)?;
    let [mut welded, mut degenerate, mut duplicate, mut turned] = [0; 4];
    let size_m = mesh
        .bounds()
        .map_or(0.0, |bounds| bounds.extents_m().norm());
    for tolerance_m in [0.0, 1e-5 * size_m] {
        welded += weld::weld(&mut mesh, tolerance_m);
        degenerate += faces::without_collapsed(&mut mesh);
        duplicate += faces::without_duplicates(&mut mesh);
        turned += orientation::align(&mut mesh)?;
        if orientation::open_edges(&mesh) == 0 {
            break;
        }
    }
    let cut = junctions::cut(&mut mesh, 1e-5 * size_m);
    if cut > 0 {
        turned += orientation::align(&mut mesh)?;
    }
    let capped = holes::cap(&mut mesh, size_m);
    let edges = orientation::open_edges(&mesh);
    if edges > 0 {
        return Err(ObjectError(format!(
            "is not closed: {edges} edges lack a neighbour. Close the holes in a mesh editor (\"make manifold\", \
             \"fill holes\")"
        )));
    }
    degenerate += faces::without_slivers(&mut mesh);
    let (inward, nested) = orientation::face_outwards(&mut mesh);
    turned += inward;
    let unused = weld::without_unused(&mut mesh);
    checked_thickness(&mesh)?;
    checked_size(&mesh, unit)?;
    type Kind = fn(usize) -> Repair;
    let repairs: [(Kind, usize); 8] = [
        (Repair::Welded, welded),
        (Repair::UnusedVertices, unused),
        (Repair::Degenerate, degenerate),
        (Repair::Duplicate, duplicate),
        (Repair::Turned, turned),
        (Repair::Capped, capped),
        (Repair::Cut, cut),
        (Repair::Nested, nested),
    ];
    let done = repairs.into_iter().filter(|(_, count)| *count > 0);
    Ok((mesh, done.map(|(repair, count)| repair(count)).collect()))
}

fn empty() -> ObjectError {
    ObjectError("has no triangles: export the object as a surface mesh".to_owned())
}

fn checked_numbers(mesh: &Mesh) -> Result<(), ObjectError> {
    let triangles = mesh.triangles.len();
    if triangles == 0 {
        return Err(empty());
    }
    if triangles > MAX_TRIANGLES {
        return Err(ObjectError(format!(
            "has {triangles} triangles where {MAX_TRIANGLES} are possible: reduce them, some thousands are enough"
        )));
    }
    let finite = |point: &nalgebra::Point3<f64>| point.iter().all(|at| at.is_finite());
    if let Some(vertex) = mesh.vertices.iter().position(|vertex| !finite(vertex)) {
        return Err(ObjectError(format!(
            "has a vertex (number {vertex}) that is not finite: export it again"
        )));
    }
    let vertices = mesh.vertices.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(vertex) = corners.iter().find(|corner| **corner as usize >= vertices) {
            return Err(ObjectError(format!(
                "has a triangle (number {triangle}) that names vertex {vertex} of {vertices}: export it again"
            )));
        }
    }
    Ok(())
}

fn checked_size(mesh: &Mesh, unit: LengthUnit) -> Result<(), ObjectError> {
    // Of the triangles, since a stray vertex that no triangle names does not count.
    let corners: Vec<_> = mesh.corners().flatten().collect();
    let bounds = crate::mesh::Bounds::of(&corners).ok_or_else(empty)?;
    let size_m = bounds.extents_m().max();
    if (MIN_SIZE_M..=MAX_SIZE_M).contains(&size_m) {
        return Ok(());
    }
    let drawn = size_m / unit.metres();
    let likely = |range: std::ops::RangeInclusive<f64>| {
        let mut units = LengthUnit::ALL.into_iter().rev();
        units.find(|unit| range.contains(&(drawn * unit.metres())))
    };
    let unit = likely(LIKELY_M).or_else(|| likely(MIN_SIZE_M..=MAX_SIZE_M));
    let suggestion = match unit {
        Some(unit) => format!("it is likely drawn in {unit}; give that as its unit"),
        None => "give the unit in which it is drawn".to_owned(),
    };
    let size_m = (size_m * 1e6).round() / 1e6;
    Err(ObjectError(format!(
        "is {size_m} m long, outside {MIN_SIZE_M} to {MAX_SIZE_M} m: {suggestion}"
    )))
}

/// Greatest extents of objects that are packed, in metres.
const LIKELY_M: std::ops::RangeInclusive<f64> = 0.01..=1.0;

/// Objects heavier than this are not likely, in kilograms.
const MAX_LIKELY_KG: f64 = 200.0;

/// Doubts an object that is larger or heavier than what is packed.
pub(crate) fn doubted(mesh: &Mesh, mass_kg: f64, unit: LengthUnit) -> Option<Repair> {
    let size_m = mesh.bounds()?.extents_m().max();
    (size_m > *LIKELY_M.end() || mass_kg > MAX_LIKELY_KG).then_some(Repair::Unlikely {
        size_mm: (size_m * 1000.0) as u32,
        mass_kg: mass_kg as u32,
        unit,
    })
}

/// The units in which an object so many units long has a likely size.
fn likely_units(drawn: f64) -> String {
    let units = LengthUnit::ALL.into_iter();
    let likely = units.filter(|unit| LIKELY_M.contains(&(drawn * unit.metres())));
    let names: Vec<String> = likely.map(|unit| unit.to_string()).collect();
    names.join(" or ")
}

fn checked_thickness(mesh: &Mesh) -> Result<(), ObjectError> {
    let volume_m3 = mesh.signed_volume_m3();
    let area_m2: f64 = mesh
        .corners()
        .map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0)
        .sum();
    if volume_m3 * 2.0 > MIN_THICKNESS_M * area_m2 {
        Ok(())
    } else {
        // The sum of no triangles is -0.
        let volume_m3 = volume_m3 + 0.0;
        Err(ObjectError(format!(
            "has no thickness: it encloses {volume_m3:.3e} m^3. Give its walls a thickness"
        )))
    }
}

#[cfg(test)]
mod tests;
