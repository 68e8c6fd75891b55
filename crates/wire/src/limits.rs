//! Limits of the fields of messages, where their type alone does not give them.

use std::fmt::Display;
use std::ops::RangeInclusive;

use crate::error::WireError;

/// Maximum side of a container, in metres.
pub(crate) const MAX_LENGTH_M: f64 = 1000.0;

pub(crate) const MAX_COORDINATE_M: f64 = 1e6;

pub(crate) const MAX_PLACEMENTS: usize = 1 << 22;

pub(crate) const MAX_CANDIDATES: usize = 1000;

/// Maximum size of an object's name, in bytes.
const MAX_NAME_BYTES: usize = 256;

/// Gives a value that is possible; refuses another, and says what is.
pub(crate) fn checked<T: Display>(
    field: &'static str,
    value: T,
    is_possible: bool,
    possible: impl Display,
) -> Result<T, WireError> {
    if is_possible {
        return Ok(value);
    }
    let reason = format_args!("{value} where {possible}");
    Err(WireError::invalid(field, reason))
}

pub(crate) fn count(
    field: &'static str,
    found: usize,
    possible: RangeInclusive<usize>,
) -> Result<(), WireError> {
    let (least, most) = (possible.start(), possible.end());
    let range = format_args!("{least} to {most} are possible");
    checked(field, found, possible.contains(&found), range).map(drop)
}

/// Checks the name of an object.
pub fn name<'a>(field: &'static str, name: &'a str) -> Result<&'a str, WireError> {
    let bytes = name.len();
    let is_possible = (1..=MAX_NAME_BYTES).contains(&bytes);
    let possible = format_args!("1 to {MAX_NAME_BYTES} are possible");
    checked(field, format_args!("{bytes} bytes"), is_possible, possible).map(|_| name)
}

/// Reads an index, below `end`.
pub(crate) fn index(field: &'static str, value: u32, end: usize) -> Result<usize, WireError> {
    let index = usize::try_from(value).unwrap_or(usize::MAX);
    let greatest = end.saturating_sub(1);
    let range = format_args!("0 to {greatest} is possible");
    checked(field, index, index < end, range)
}

/// Writes an index; those of the domain are far below the maximum of a message.
pub(crate) fn to_index(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

pub(crate) fn at_least_zero(field: &'static str, value: f64) -> Result<f64, WireError> {
    let is_possible = value.is_finite() && value >= 0.0;
    let possible = "a finite number of at least 0 is needed";
    checked(field, value, is_possible, possible)
}

/// Checks a length above 0 and at most [`MAX_LENGTH_M`].
pub(crate) fn length_m(field: &'static str, value: f64) -> Result<f64, WireError> {
    let is_possible = value > 0.0 && value <= MAX_LENGTH_M;
    let possible = format_args!("metres above 0 and at most {MAX_LENGTH_M} are needed");
    checked(field, value, is_possible, possible)
}

/// Checks a coordinate of at most [`MAX_COORDINATE_M`] in either direction.
pub(crate) fn coordinate_m(field: &'static str, value: f64) -> Result<f64, WireError> {
    let found = format_args!("the coordinate {value}");
    let is_possible = value.abs() <= MAX_COORDINATE_M;
    let possible =
        format_args!("metres from -{MAX_COORDINATE_M} to {MAX_COORDINATE_M} are possible");
    checked(field, found, is_possible, possible).map(|_| value)
}
