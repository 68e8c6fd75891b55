//! PLY, ASCII and binary.

use nalgebra::Point3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use ppnpack_clouds::ply_header;

use super::error::ReadError;
use crate::mesh::Mesh;

struct Vertex([f64; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        // A coordinate that the file does not give is found by the check for finite vertices.
        Self([f64::NAN; 3])
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        let [x, y, z] = &mut self.0;
        let coordinate = match key {
            "x" => x,
            "y" => y,
            "z" => z,
            _ => return PropertyAccessResult::Ignored,
        };
        let Some(value) = scalar(&property) else {
            return PropertyAccessResult::UnsupportedType;
        };
        *coordinate = value;
        PropertyAccessResult::Set
    }
}

struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        if !matches!(key, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        let Some(indices) = property.to_u32_list() else {
            return PropertyAccessResult::UnsupportedType;
        };
        self.0 = indices;
        PropertyAccessResult::Set
    }
}

/// An element that is read past.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

fn scalar(property: &Property) -> Option<f64> {
    match property {
        Property::Char(value) => Some(f64::from(*value)),
        Property::UChar(value) => Some(f64::from(*value)),
        Property::Short(value) => Some(f64::from(*value)),
        Property::UShort(value) => Some(f64::from(*value)),
        Property::Int(value) => Some(f64::from(*value)),
        Property::UInt(value) => Some(f64::from(*value)),
        Property::Float(value) => Some(f64::from(*value)),
        Property::Double(value) => Some(*value),
        _ => None,
    }
}

pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let malformed = |reason: String| ReadError::malformed("PLY", &reason);
    let mut reader = Reader::new(bytes);
    let vertices = Parser::<Vertex>::new();
    let header = vertices
        .read_header(&mut reader)
        .map_err(|error| malformed(error.to_string()))?;
    for (name, element) in &header.elements {
        if !ply_header::can_hold(bytes.len(), element, header.encoding) {
            return Err(malformed(format!(
                "its header announces {} elements '{name}', more than its {} bytes can hold",
                element.count,
                bytes.len()
            )));
        }
    }
    let mut mesh = Mesh::default();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                let read = vertices.read_payload_for_element(&mut reader, element, &header);
                let read = read.map_err(|error| malformed(error.to_string()))?;
                mesh.vertices = read
                    .into_iter()
                    .map(|vertex| Point3::from(vertex.0))
                    .collect();
            }
            "face" => {
                let faces = Parser::<Face>::new();
                let read = faces.read_payload_for_element(&mut reader, element, &header);
                let read = read.map_err(|error| malformed(error.to_string()))?;
                mesh.triangles = read.iter().flat_map(|face| fan(&face.0)).collect();
            }
            _ => {
                let read = Parser::<Skipped>::new().read_payload_for_element(
                    &mut reader,
                    element,
                    &header,
                );
                read.map_err(|error| malformed(error.to_string()))?;
            }
        }
    }
    Ok(mesh)
}

/// The triangles of a polygon, as a fan around its first corner.
fn fan(polygon: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let first = polygon.first().copied().unwrap_or_default();
    polygon
        .windows(2)
        .skip(1)
        .filter_map(move |edge| match edge {
            [from, to] => Some([first, *from, *to]),
            _ => None,
        })
}
