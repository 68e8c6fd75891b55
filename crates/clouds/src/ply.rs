//! PLY, ASCII and binary: the points are the coordinates of its vertices.

use nalgebra::Point3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use crate::cloud::Cloud;
use crate::error::FormatError;
use crate::ply_header::{self, Skipped};
use crate::text::{number, points};

struct Vertex(Point3<f32>);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self(Point3::new(f32::NAN, f32::NAN, f32::NAN))
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        let side_m = match key {
            "x" => &mut self.0.x,
            "y" => &mut self.0.y,
            "z" => &mut self.0.z,
            _ => return PropertyAccessResult::Ignored,
        };
        *side_m = match property {
            Property::Float(value) => value,
            Property::Double(value) => value as f32,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

pub(crate) fn parse(content: &[u8]) -> Result<Cloud, FormatError> {
    let mut reader = Reader::new(content);
    let vertices = Parser::<Vertex>::new();
    let header = vertices
        .read_header(&mut reader)
        .map_err(FormatError::ply)?;
    let vertex = header
        .elements
        .get("vertex")
        .ok_or_else(|| FormatError::ply("it has no element 'vertex'"))?;
    FormatError::check_points(vertex.count)?;
    check_coordinates(vertex)?;
    for (name, element) in &header.elements {
        ply_header::check_length(content.len(), element, header.encoding)
            .map_err(FormatError::ply)?;
        if name == "vertex" {
            break;
        }
        Parser::<Skipped>::new()
            .read_payload_for_element(&mut reader, element, &header)
            .map_err(FormatError::ply)?;
    }
    let points_m = if header.encoding == Encoding::Ascii {
        // The parser knows no NaN.
        let words = ["vertex", "vertices"];
        let point = |line: &str| ascii_point(line, vertex);
        points(reader.into_inner(), vertex.count, words, point).map_err(FormatError::ply)?
    } else {
        let read = vertices
            .read_payload_for_element(&mut reader, vertex, &header)
            .map_err(FormatError::ply)?;
        read.into_iter().map(|vertex| vertex.0).collect()
    };
    Cloud::unorganised(points_m).map_err(FormatError::ply)
}

/// Reads a vertex that has all of its properties and nothing else.
fn ascii_point(line: &str, vertex: &ElementDef) -> Option<Point3<f32>> {
    let mut words = line.split_ascii_whitespace();
    let mut point = Vertex::new();
    for (name, property) in &vertex.properties {
        let word = words.next()?;
        match property.data_type {
            PropertyType::Scalar(_) => {
                point.set_float(name, number(word)?);
            }
            PropertyType::List(..) => {
                for _ in 0..word.parse::<usize>().ok()? {
                    words.next()?;
                }
            }
        }
    }
    words.next().is_none().then_some(point.0)
}

fn check_coordinates(vertex: &ElementDef) -> Result<(), FormatError> {
    for side in ["x", "y", "z"] {
        use ScalarType::{Double, Float};
        let kind = vertex.properties.get(side).map(|found| &found.data_type);
        if !matches!(kind, Some(PropertyType::Scalar(Float | Double))) {
            return Err(FormatError::ply(format_args!(
                "its vertices have no property '{side}' of type float or double"
            )));
        }
    }
    Ok(())
}
