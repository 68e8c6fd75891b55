//! PLY, ASCII and binary: the points are the coordinates of its vertices.

use nalgebra::Point3;

use crate::cloud::Cloud;
use crate::error::FormatError;
use crate::ply_rows::{Element, Number, header};

pub(crate) fn parse(content: &[u8]) -> Result<Cloud, FormatError> {
    let (elements, mut body) = header(content).map_err(FormatError::ply)?;
    let mut points_m = Vec::new();
    for element in &elements {
        if element.name != "vertex" {
            body.rows(element, |_| ()).map_err(FormatError::ply)?;
            continue;
        }
        FormatError::check_points(element.count)?;
        let places = [
            coordinate(element, "x")?,
            coordinate(element, "y")?,
            coordinate(element, "z")?,
        ];
        body.rows(element, |row| {
            let value = |place: usize| row.get(place).and_then(|values| values.first());
            let sides_m = places.map(|place| value(place).map_or(f32::NAN, |side| *side as f32));
            points_m.push(Point3::from(sides_m));
        })
        .map_err(FormatError::ply)?;
        return Cloud::unorganised(points_m).map_err(FormatError::ply);
    }
    Err(FormatError::ply("it has no element 'vertex'"))
}

/// Gives the place of a coordinate among the properties.
fn coordinate(vertex: &Element, side: &str) -> Result<usize, FormatError> {
    let is_coordinate = |property: &crate::ply_rows::Property| {
        property.name == side
            && property.length.is_none()
            && matches!(property.number, Number::F32 | Number::F64)
    };
    vertex
        .properties
        .iter()
        .position(is_coordinate)
        .ok_or_else(|| {
            FormatError::ply(format_args!(
                "its vertices have no property '{side}' of type float or double"
            ))
        })
}
