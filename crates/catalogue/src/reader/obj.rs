//! Wavefront OBJ: positions and faces; materials, normals and texture coordinates are left out.

use nalgebra::Point3;
use tobj::{LoadError, LoadOptions};

use super::error::ReadError;
use crate::mesh::Mesh;

pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let malformed = |reason: String| ReadError::malformed("OBJ", &reason);
    let options = LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..LoadOptions::default()
    };
    let mut content = bytes;
    let loaded = tobj::load_obj_buf(&mut content, &options, |_| Err(LoadError::OpenFileFailed));
    let (models, _) = loaded.map_err(|error| malformed(error.to_string()))?;
    let mut mesh = Mesh::default();
    for model in models {
        let offset = u32::try_from(mesh.vertices.len())
            .map_err(|_| malformed("it has too many vertices".to_owned()))?;
        let positions = model.mesh.positions.chunks_exact(3);
        mesh.vertices
            .extend(positions.filter_map(|position| match position {
                [x, y, z] => Some(Point3::new(f64::from(*x), f64::from(*y), f64::from(*z))),
                _ => None,
            }));
        let corners = model.mesh.indices.chunks_exact(3);
        mesh.triangles
            .extend(corners.filter_map(|corners| match corners {
                [a, b, c] => Some([
                    a.saturating_add(offset),
                    b.saturating_add(offset),
                    c.saturating_add(offset),
                ]),
                _ => None,
            }));
    }
    Ok(mesh)
}
