//! The fields of points that are kept, and the places of their numbers.

use super::message::{PointCloud2, PointField, datatype};
use crate::convert::cloud::MAX_FIELDS;
use crate::error::WireError;
use crate::v1;
use crate::v1::NumericType;

/// The fields that a point cannot be without.
const COORDINATES: [&str; 3] = ["x", "y", "z"];

/// The place of a number within a point, in bytes from its beginning.
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
        let fields = message.fields.iter();
        let (coordinates, others): (Vec<_>, Vec<_>) =
            fields.partition(|field| is_coordinate(field));
        let mut kept = Self::default();
        for field in coordinates.into_iter().chain(others) {
            if kept.packed.len() < MAX_FIELDS {
                kept.add(field, message.is_bigendian)?;
            }
        }
        Ok(kept)
    }

    /// Keeps a field, if it can be: a single number of a type that the workspace's clouds have.
    fn add(&mut self, field: &PointField<'_>, is_bigendian: bool) -> Result<(), WireError> {
        let Some((bytes, Some(kind))) = layout(field.datatype).filter(|_| field.count <= 1) else {
            return Ok(());
        };
        let offset = usize::try_from(field.offset).unwrap_or(usize::MAX);
        let number = Number { offset, bytes };
        let is_shared = self.numbers.iter().any(|own| own.shares_bytes_with(number));
        if is_shared && is_coordinate(field) {
            let reason = format_args!("'{}' shares bytes with another coordinate", field.name);
            return Err(WireError::invalid("PointCloud2.fields.offset", reason));
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

/// Gives the bytes of a number of a type, and its type in the workspace's clouds, if any.
fn layout(datatype: u8) -> Option<(usize, Option<NumericType>)> {
    Some(match datatype {
        datatype::INT8 => (1, Some(NumericType::Int8)),
        datatype::UINT8 => (1, Some(NumericType::Uint8)),
        datatype::BOOLEAN => (1, None),
        datatype::INT16 => (2, Some(NumericType::Int16)),
        datatype::UINT16 => (2, Some(NumericType::Uint16)),
        datatype::INT32 => (4, Some(NumericType::Int32)),
        datatype::UINT32 => (4, Some(NumericType::Uint32)),
        datatype::FLOAT32 => (4, Some(NumericType::Float32)),
        datatype::FLOAT64 => (8, Some(NumericType::Float64)),
        datatype::INT64 | datatype::UINT64 => (8, None),
        _ => return None,
    })
}

/// Checks a field, whether it is kept or not.
fn check(field: &PointField<'_>, point_step: u32) -> Result<(), WireError> {
    let (name, datatype, count) = (field.name, field.datatype, field.count);
    let Some((bytes, _)) = layout(datatype) else {
        let reason = format_args!("{datatype} of '{name}' is no type that is known");
        return Err(WireError::invalid("PointCloud2.fields.datatype", reason));
    };
    if count > 1 && is_coordinate(field) {
        let reason = format_args!("'{name}' has {count} elements where 1 is needed");
        return Err(WireError::invalid("PointCloud2.fields.count", reason));
    }
    let end = u64::from(field.offset) + u64::from(count.max(1)) * bytes as u64;
    if end > u64::from(point_step) {
        let reason = format_args!("'{name}' ends at byte {end} of a point of {point_step}");
        return Err(WireError::invalid("PointCloud2.fields.offset", reason));
    }
    Ok(())
}
