//! The fields of points: which are kept, and where their numbers lie.

use super::message::{PointCloud2, PointField, datatype};
use crate::convert::cloud::MAX_FIELDS;
use crate::error::WireError;
use crate::v1;
use crate::v1::NumericType;

/// The fields that a point cannot be without.
const COORDINATES: [&str; 3] = ["x", "y", "z"];

/// Where a number lies within a point, in bytes from its beginning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Number {
    pub(super) offset: usize,
    pub(super) bytes: usize,
}

impl Number {
    fn shares_bytes_with(self, other: Self) -> bool {
        self.offset < other.offset + other.bytes && other.offset < self.offset + self.bytes
    }
}

/// The fields of a cloud that are kept.
#[derive(Debug, Default)]
pub(super) struct Fields {
    pub(super) packed: Vec<v1::PackedField>,
    /// The numbers of the fields, each once. Those of big-endian points have no byte in common.
    pub(super) numbers: Vec<Number>,
}

impl Fields {
    pub(super) fn of(message: &PointCloud2<'_>) -> Result<Self, WireError> {
        for field in &message.fields {
            check(field, message.point_step)?;
        }
        let (coordinates, others): (Vec<_>, Vec<_>) = message
            .fields
            .iter()
            .partition(|field| is_coordinate(field));
        let mut kept = Self::default();
        for field in coordinates.into_iter().chain(others) {
            if kept.packed.len() < MAX_FIELDS {
                kept.add(field, message.is_bigendian)?;
            }
        }
        Ok(kept)
    }

    /// Keeps a field, if it can be.
    fn add(&mut self, field: &PointField<'_>, is_bigendian: bool) -> Result<(), WireError> {
        let Some(kind) = kind(field) else {
            return Ok(());
        };
        let number = Number {
            offset: usize::try_from(field.offset).unwrap_or(usize::MAX),
            bytes: size(field.datatype).unwrap_or_default(),
        };
        let is_shared = self.numbers.iter().any(|own| own.shares_bytes_with(number));
        if is_shared && is_coordinate(field) {
            let name = field.name;
            return Err(WireError::invalid(
                "PointCloud2.fields.offset",
                format_args!("'{name}' shares bytes with another coordinate"),
            ));
        }
        // A number that is turned round can only be seen as what it is turned round as.
        let is_known = self.numbers.contains(&number);
        if is_shared && is_bigendian && !is_known {
            return Ok(());
        }
        if !is_known {
            self.numbers.push(number);
        }
        self.packed.push(v1::PackedField {
            name: field.name.to_owned(),
            offset: field.offset,
            r#type: kind.into(),
        });
        Ok(())
    }
}

fn is_coordinate(field: &PointField<'_>) -> bool {
    COORDINATES.contains(&field.name)
}

/// The bytes of a number.
fn size(kind: u8) -> Option<usize> {
    match kind {
        datatype::INT8 | datatype::UINT8 | datatype::BOOLEAN => Some(1),
        datatype::INT16 | datatype::UINT16 => Some(2),
        datatype::INT32 | datatype::UINT32 | datatype::FLOAT32 => Some(4),
        datatype::FLOAT64 | datatype::INT64 | datatype::UINT64 => Some(8),
        _ => None,
    }
}

/// The type of a field that can be kept: a single number of a type that the workspace's clouds have.
fn kind(field: &PointField<'_>) -> Option<NumericType> {
    if field.count > 1 {
        return None;
    }
    match field.datatype {
        datatype::INT8 => Some(NumericType::Int8),
        datatype::UINT8 => Some(NumericType::Uint8),
        datatype::INT16 => Some(NumericType::Int16),
        datatype::UINT16 => Some(NumericType::Uint16),
        datatype::INT32 => Some(NumericType::Int32),
        datatype::UINT32 => Some(NumericType::Uint32),
        datatype::FLOAT32 => Some(NumericType::Float32),
        datatype::FLOAT64 => Some(NumericType::Float64),
        _ => None,
    }
}

/// Checks a field, whether it is kept or not.
fn check(field: &PointField<'_>, point_step: u32) -> Result<(), WireError> {
    let PointField {
        name,
        offset,
        datatype,
        count,
    } = *field;
    let Some(bytes) = size(datatype) else {
        return Err(WireError::invalid(
            "PointCloud2.fields.datatype",
            format_args!("{datatype} of '{name}' is no type that is known"),
        ));
    };
    if count > 1 && is_coordinate(field) {
        return Err(WireError::invalid(
            "PointCloud2.fields.count",
            format_args!("'{name}' has {count} elements where 1 is needed"),
        ));
    }
    let end = u64::from(offset) + u64::from(count.max(1)) * bytes as u64;
    if end > u64::from(point_step) {
        return Err(WireError::invalid(
            "PointCloud2.fields.offset",
            format_args!("'{name}' ends at byte {end} of a point of {point_step}"),
        ));
    }
    Ok(())
}
