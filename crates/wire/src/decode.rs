//! Decoding of messages from outside: bounded before anything is read.

use prost::{Message, Name};

use crate::error::{WireError, check_size};
use crate::structure;

/// Maximum size of all messages but the clouds, in bytes.
pub const MAX_MESSAGE_BYTES: usize = 16 << 20;

/// Maximum size of a cloud, in bytes.
pub const MAX_CLOUD_BYTES: usize = MAX_POINT_BYTES + (1 << 20);

/// Maximum size of the points in a cloud, in bytes.
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

/// Gives the encoding field of a message, such as `application/protobuf;ppnpack.v1.Heightmap`.
pub fn encoding_of<M: Name>() -> String {
    format!("application/protobuf;{}", M::full_name())
}
