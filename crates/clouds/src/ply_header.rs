//! Checks of a PLY file's header against the file. Readers of meshes need them as well.

use ply_rs_bw::ply::{ElementDef, Encoding, PropertyAccess, PropertyType, ScalarType};

/// An element that is read past.
#[derive(Debug)]
pub struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// Refuses more elements than a file of so many bytes can hold. Ask before there is memory for
/// them.
///
/// # Errors
/// What is wrong with the header.
pub fn check_length(bytes: usize, element: &ElementDef, encoding: Encoding) -> Result<(), String> {
    let least = least_bytes(element, encoding).max(1);
    // One byte more, since the last line of an ASCII file need not end.
    if element.count.saturating_mul(least) <= bytes.saturating_add(1) {
        return Ok(());
    }
    Err(format!(
        "its header announces {} elements '{}', more than its {bytes} bytes can hold",
        element.count, element.name
    ))
}

/// Gives the fewest bytes that one element takes in the file.
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
