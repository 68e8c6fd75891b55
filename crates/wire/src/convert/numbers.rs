//! Many numbers as little-endian bytes.

use ppnpack_packing::kernel::grid::Units;

use crate::error::WireError;
use crate::limits::checked;

/// Reads heights in units: 16-bit integers.
pub(super) fn read_units(
    field: &'static str,
    bytes: &[u8],
    size: (usize, usize),
) -> Result<Vec<Units>, WireError> {
    let numbers = split(field, bytes, size)?;
    Ok(numbers.iter().copied().map(Units::from_le_bytes).collect())
}

/// Reads heights in metres: 32-bit floats.
pub(super) fn read_floats(
    field: &'static str,
    bytes: &[u8],
    size: (usize, usize),
) -> Result<Vec<f32>, WireError> {
    let numbers = split(field, bytes, size)?;
    Ok(numbers.iter().copied().map(f32::from_le_bytes).collect())
}

/// Splits a map of `nx` x `ny` into its numbers, once its size is checked: no memory is taken
/// before.
fn split<'a, const BYTES: usize>(
    field: &'static str,
    bytes: &'a [u8],
    (nx, ny): (usize, usize),
) -> Result<&'a [[u8; BYTES]], WireError> {
    let count = nx.checked_mul(ny);
    let is_possible = count.and_then(|count| count.checked_mul(BYTES)) == Some(bytes.len());
    let found = format_args!("{} bytes", bytes.len());
    let needed = format_args!("{nx} x {ny} numbers of {BYTES} bytes are needed");
    checked(field, found, is_possible, needed)?;
    Ok(bytes.as_chunks().0)
}

pub(super) fn write_units(values: &[Units]) -> Vec<u8> {
    join(values, |value| value.to_le_bytes())
}

pub(super) fn write_floats(values: &[f32]) -> Vec<u8> {
    join(values, |value| value.to_le_bytes())
}

/// Joins the bytes of numbers: memory is taken once, and the loop becomes a copy.
fn join<T: Copy, const BYTES: usize>(values: &[T], to_bytes: impl Fn(T) -> [u8; BYTES]) -> Vec<u8> {
    let mut bytes = vec![0; values.len() * BYTES];
    for (chunk, value) in bytes.as_chunks_mut().0.iter_mut().zip(values) {
        *chunk = to_bytes(*value);
    }
    bytes
}
