//! PLY, ASCII and binary.

use std::fmt::Display;

use nalgebra::Point3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use ppnpack_clouds::ply_header::{self, Skipped};

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

fn malformed(reason: impl Display) -> ReadError {
    ReadError::malformed("PLY", reason)
}

pub(super) fn parse(bytes: &[u8]) -> Result<Mesh, ReadError> {
    let mut reader = Reader::new(bytes);
    let vertices = Parser::<Vertex>::new();
    let header = vertices.read_header(&mut reader).map_err(malformed)?;
    for (_, element) in &header.elements {
        ply_header::check_length(bytes.len(), element, header.encoding).map_err(malformed)?;
    }
    let mut mesh = Mesh::default();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                let read = vertices.read_payload_for_element(&mut reader, element, &header);
                let points = read.map_err(malformed)?.into_iter();
                mesh.vertices = points.map(|vertex| Point3::from(vertex.0)).collect();
            }
            "face" => {
                let faces = Parser::<Face>::new();
                let read = faces.read_payload_for_element(&mut reader, element, &header);
                let faces = read.map_err(malformed)?;
                mesh.triangles = faces.iter().flat_map(|face| fan(&face.0)).collect();
            }
            _ => {
                let skipped = Parser::<Skipped>::new();
                let read = skipped.read_payload_for_element(&mut reader, element, &header);
                read.map_err(malformed)?;
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
