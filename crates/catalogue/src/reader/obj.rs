//! Wavefront OBJ: positions and faces; materials, normals and texture coordinates are left out.

use nalgebra::Point3;
use tobj::{LoadError, LoadOptions};

use super::error::ReadError;
use crate::mesh::Mesh;

pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let options = LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..LoadOptions::default()
    };
    let mut content = bytes;
    let loaded = tobj::load_obj_buf(&mut content, &options, |_| Err(LoadError::OpenFileFailed));
    let (models, _) = loaded.map_err(|error| ReadError::malformed("OBJ", error))?;
    let mut mesh = Mesh::default();
    for model in models {
        let offset = u32::try_from(mesh.vertices.len())
            .map_err(|_| ReadError::malformed("OBJ", "it has too many vertices"))?;
        let (positions, _) = model.mesh.positions.as_chunks::<3>();
        let vertices = positions
            .iter()
            .map(|position| Point3::from(*position).cast());
        mesh.vertices.extend(vertices);
        let (triangles, _) = model.mesh.indices.as_chunks::<3>();
        let moved = |corners: &[u32; 3]| corners.map(|corner| corner.saturating_add(offset));
        mesh.triangles.extend(triangles.iter().map(moved));
    }
    Ok(mesh)
}
