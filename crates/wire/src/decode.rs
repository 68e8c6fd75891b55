//! Decoding of what comes from outside: bounded before it is looked at.

use prost::{Message, Name};

use crate::error::{WireError, check_size};
use crate::structure;

/// The largest message of all but the clouds, in bytes.
pub const MAX_MESSAGE_BYTES: usize = 16 << 20;

/// The largest cloud, in bytes.
pub const MAX_CLOUD_BYTES: usize = MAX_POINT_BYTES + (1 << 20);

/// The most bytes of points in a cloud.
pub(crate) const MAX_POINT_BYTES: usize = 128 << 20;

/// Decodes a message of at most `limit` bytes.
///
/// # Errors
/// [`WireError::TooLarge`], [`WireError::TooManyParts`] and [`WireError::Malformed`].
pub fn decode<M: Message + Name + Default>(payload: &[u8], limit: usize) -> Result<M, WireError> {
    check_size(M::NAME, payload.len(), limit)?;
    structure::check(M::NAME, payload)?;
    M::decode(payload).map_err(|error| WireError::malformed(M::NAME, error))
}

/// The encoding field that goes with a message, such as `application/protobuf;ppnpack.v1.Heightmap`.
pub fn encoding_of<M: Name>() -> String {
    format!("application/protobuf;{}", M::full_name())
}
