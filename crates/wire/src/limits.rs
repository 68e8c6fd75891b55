//! How much the fields of a message may hold, where their type alone does not say it.

use std::ops::RangeInclusive;

use crate::error::WireError;

/// The longest side of a container, in metres.
pub(crate) const MAX_LENGTH_M: f64 = 1000.0;

/// The greatest coordinate, in metres.
pub(crate) const MAX_COORDINATE_M: f64 = 1e6;

/// The most placements in a message.
pub(crate) const MAX_PLACEMENTS: usize = 1 << 22;

/// The most candidates of a request.
pub(crate) const MAX_CANDIDATES: usize = 1000;

/// The longest name of an object, in bytes.
const MAX_NAME_BYTES: usize = 256;

/// Checks how many of something there are.
pub(crate) fn count(
    field: &'static str,
    found: usize,
    possible: RangeInclusive<usize>,
) -> Result<(), WireError> {
    if possible.contains(&found) {
        Ok(())
    } else {
        let (least, most) = (possible.start(), possible.end());
        Err(WireError::invalid(
            field,
            format_args!("{found} where {least} to {most} are possible"),
        ))
    }
}

/// The name of an object.
pub fn name<'a>(field: &'static str, name: &'a str) -> Result<&'a str, WireError> {
    if (1..=MAX_NAME_BYTES).contains(&name.len()) {
        Ok(name)
    } else {
        Err(WireError::invalid(
            field,
            format_args!(
                "{} bytes where 1 to {MAX_NAME_BYTES} are possible",
                name.len()
            ),
        ))
    }
}

/// An index, below `end`.
pub(crate) fn index(field: &'static str, value: u32, end: usize) -> Result<usize, WireError> {
    usize::try_from(value)
        .ok()
        .filter(|value| *value < end)
        .ok_or_else(|| {
            WireError::invalid(
                field,
                format_args!("{value} where 0 to {} is possible", end.saturating_sub(1)),
            )
        })
}

/// An index as it stands in a message; those of the domain are far below the greatest that it can hold.
pub(crate) fn to_index(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

/// A number of at least 0.
pub(crate) fn at_least_zero(field: &'static str, value: f64) -> Result<f64, WireError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(WireError::invalid(
            field,
            format_args!("{value} where a finite number of at least 0 is needed"),
        ))
    }
}

/// A length above 0 and at most [`MAX_LENGTH_M`].
pub(crate) fn length_m(field: &'static str, value: f64) -> Result<f64, WireError> {
    if value > 0.0 && value <= MAX_LENGTH_M {
        Ok(value)
    } else {
        Err(WireError::invalid(
            field,
            format_args!("{value} where metres above 0 and at most {MAX_LENGTH_M} are needed"),
        ))
    }
}

/// A coordinate of at most [`MAX_COORDINATE_M`] in either direction.
pub(crate) fn coordinate_m(field: &'static str, value: f64) -> Result<f64, WireError> {
    if value.abs() <= MAX_COORDINATE_M {
        Ok(value)
    } else {
        Err(WireError::invalid(
            field,
            format_args!(
                "the coordinate {value} where metres from -{MAX_COORDINATE_M} to {MAX_COORDINATE_M} are possible"
            ),
        ))
    }
}
