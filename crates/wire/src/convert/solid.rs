//! Solids: the geometry of objects, as recordings have it.

use nalgebra::{Matrix3, Point3};
use ppnpack_packing::scene::model::mesh::Mesh;
use ppnpack_packing::scene::model::{ConvexPiece, MassProperties, Model};

use super::pose;
use crate::error::{WireError, needed};
use crate::limits::{at_least_zero, coordinate_m, name};
use crate::v1;

/// Reads a solid. It has no resting poses: nothing that is planned looks at them.
///
/// # Errors
/// [`WireError`] where a number is not possible, or a triangle names a vertex that is not there.
pub fn read(message: &v1::Solid) -> Result<Model, WireError> {
    let vertices = read_points("solid.vertices_m", &message.vertices_m)?;
    let triangles = read_triangles(&message.triangles, vertices.len())?;
    let pieces = message.pieces.iter().map(|piece| {
        let vertices = read_points("solid.pieces.vertices_m", &piece.vertices_m)?;
        Ok(ConvexPiece { vertices })
    });
    let field = "solid.centre_of_mass";
    let centre = pose::read_vector(field, needed(field, message.centre_of_mass.as_ref())?)?;
    let carries_kg = message.carries_kg;
    let carries_kg = carries_kg.map(|carries_kg| at_least_zero("solid.carries_kg", carries_kg));
    Ok(Model {
        name: name("solid.name", &message.name)?.to_owned(),
        mesh: Mesh {
            vertices,
            triangles,
        },
        volume_m3: at_least_zero("solid.volume_m3", message.volume_m3)?,
        pieces: pieces.collect::<Result<_, WireError>>()?,
        mass: MassProperties {
            mass_kg: at_least_zero("solid.mass_kg", message.mass_kg)?,
            centre_of_mass_m: Point3::from(centre),
            inertia_kg_m2: read_inertia(&message.inertia_kg_m2)?,
        },
        carries_kg: carries_kg.transpose()?,
        resting_poses: Vec::new(),
    })
}

/// Splits numbers or indices into threes.
fn threes<'a, T>(field: &'static str, all: &'a [T]) -> Result<&'a [[T; 3]], WireError> {
    let (threes, rest) = all.as_chunks();
    let refused =
        || WireError::invalid(field, format_args!("{} is no multiple of three", all.len()));
    rest.is_empty().then_some(threes).ok_or_else(refused)
}

fn read_points(field: &'static str, numbers: &[f64]) -> Result<Vec<Point3<f64>>, WireError> {
    let points = threes(field, numbers)?;
    for number in numbers {
        coordinate_m(field, *number)?;
    }
    Ok(points.iter().map(|point| Point3::from(*point)).collect())
}

fn read_triangles(indices: &[u32], vertices: usize) -> Result<Vec<[u32; 3]>, WireError> {
    let field = "solid.triangles";
    let triangles = threes(field, indices)?;
    match indices.iter().find(|index| **index as usize >= vertices) {
        Some(index) => {
            let reason = format_args!("vertex {index} of {vertices}");
            Err(WireError::invalid(field, reason))
        }
        None => Ok(triangles.to_vec()),
    }
}

fn read_inertia(numbers: &[f64]) -> Result<Matrix3<f64>, WireError> {
    let field = "solid.inertia_kg_m2";
    if numbers.len() != 9 || !numbers.iter().all(|number| number.is_finite()) {
        return Err(WireError::invalid(field, "nine finite numbers are needed"));
    }
    Ok(Matrix3::from_column_slice(numbers))
}

/// Writes a solid.
pub fn write(model: &Model) -> v1::Solid {
    let MassProperties {
        mass_kg,
        centre_of_mass_m,
        inertia_kg_m2,
    } = model.mass;
    let pieces = model.pieces.iter().map(|piece| v1::ConvexPiece {
        vertices_m: write_points(&piece.vertices),
    });
    v1::Solid {
        name: model.name.clone(),
        vertices_m: write_points(&model.mesh.vertices),
        triangles: model.mesh.triangles.iter().flatten().copied().collect(),
        volume_m3: model.volume_m3,
        pieces: pieces.collect(),
        mass_kg,
        centre_of_mass: Some(pose::write_vector(&centre_of_mass_m.coords)),
        inertia_kg_m2: inertia_kg_m2.as_slice().to_vec(),
        carries_kg: model.carries_kg,
    }
}

fn write_points(points: &[Point3<f64>]) -> Vec<f64> {
    points
        .iter()
        .flat_map(|point| <[f64; 3]>::from(*point))
        .collect()
}
