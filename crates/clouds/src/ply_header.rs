//! What the header of a PLY file announces, held against the file. Readers of meshes need it as well.

use ply_rs_bw::ply::{ElementDef, Encoding, PropertyType, ScalarType};

/// Whether a file of so many bytes can hold all of an element that its header announces. Ask before there is memory for
/// them.
pub fn can_hold(bytes: usize, element: &ElementDef, encoding: Encoding) -> bool {
    let least = least_bytes(element, encoding).max(1);
    // One byte more, since the last line of an ASCII file need not end.
    element.count.saturating_mul(least) <= bytes.saturating_add(1)
}

/// The fewest bytes that one element takes in the file.
fn least_bytes(element: &ElementDef, encoding: Encoding) -> usize {
    let bytes = |scalar: &ScalarType| match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let properties = element
        .properties
        .iter()
        .map(|(_, property)| match &property.data_type {
            // A digit and what separates it from the next.
            _ if encoding == Encoding::Ascii => 2,
            PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => bytes(scalar),
        });
    properties.sum()
}
