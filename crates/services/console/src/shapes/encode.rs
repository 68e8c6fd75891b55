//! Triangles as they are sent to pages.

use ppnpack_packing::model::mesh::Mesh;

/// A mesh in little-endian numbers: how many vertices and triangles there are (`u32`), x, y and z of each vertex in metres (`f32`), and
/// the three vertices of each triangle (`u32`).
pub(super) fn encode(mesh: &Mesh) -> Vec<u8> {
    let Mesh {
        vertices,
        triangles,
    } = mesh;
    let mut bytes = Vec::with_capacity(8 + 12 * (vertices.len() + triangles.len()));
    for count in [vertices.len(), triangles.len()] {
        // A message that a mesh comes in has room for far fewer.
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        bytes.extend(count.to_le_bytes());
    }
    for vertex in vertices {
        let coordinates = vertex.coords.iter();
        bytes.extend(coordinates.flat_map(|metres| (*metres as f32).to_le_bytes()));
    }
    for triangle in triangles {
        bytes.extend(triangle.iter().flat_map(|vertex| vertex.to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_takes_twelve_bytes_for_each_vertex_and_triangle() {
        let bytes = encode(&Mesh::cuboid([0.0; 3], [0.5, 1.0, 2.0]));
        assert_eq!(bytes.len(), 8 + 12 * (8 + 12));
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!((number(0), number(4)), (8, 12));
        // The second vertex is that of the greatest x.
        assert_eq!(f32::from_bits(number(8 + 12)), 0.5);
        let first_index = 8 + 12 * 8;
        assert!(
            (first_index..bytes.len())
                .step_by(4)
                .all(|at| number(at) < 8)
        );
    }
}
