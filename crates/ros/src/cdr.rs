//! Messages as bytes: plain CDR, after the four bytes that say so.
//!
//! What is written is little-endian; what is read may be of either order, as the first bytes say. Source: OMG DDS-XTypes 1.3, sections
//! 7.4.1 and 7.6.3.1.2.

use byteorder::{BigEndian, LittleEndian};
use serde::de::{DeserializeOwned, Deserializer, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use crate::description::{self, Message};
use crate::error::RosError;

/// Plain CDR, little-endian, without options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// The bytes of a message.
///
/// # Errors
/// [`RosError::Malformed`] where a sequence or a text is longer than CDR can say.
pub fn encode<M: Message>(message: &M) -> Result<Vec<u8>, RosError> {
    let mut payload = ENCAPSULATION.to_vec();
    // Alignment counts from the end of the encapsulation.
    let body =
        cdr_encoding::to_vec::<M, LittleEndian>(message).map_err(|error| malformed::<M>(&error))?;
    payload.extend_from_slice(&body);
    Ok(payload)
}

/// The message that bytes are. What follows it is not looked at: some pad.
///
/// # Errors
/// [`RosError::Malformed`] where they are no such message.
pub fn decode<M: Message>(payload: &[u8]) -> Result<M, RosError> {
    let Some((&[0, order, _, _], body)) = payload.split_first_chunk::<4>() else {
        return Err(malformed::<M>(&"plain CDR is needed"));
    };
    // Some leave the one byte of an empty message out.
    let body: &[u8] = match body {
        [] if description::is_empty::<M>() => &[0],
        body => body,
    };
    match order {
        0 => read::<M, BigEndian>(body),
        1 => read::<M, LittleEndian>(body),
        _ => Err(malformed::<M>(&"plain CDR is needed")),
    }
}

fn read<M: Message + DeserializeOwned, B: byteorder::ByteOrder>(
    body: &[u8],
) -> Result<M, RosError> {
    let read = cdr_encoding::from_bytes::<M, B>(body);
    read.map(|(message, _)| message)
        .map_err(|error| malformed::<M>(&error))
}

fn malformed<M: Message>(reason: &dyn std::fmt::Display) -> RosError {
    RosError::Malformed {
        type_name: M::type_name(),
        reason: reason.to_string(),
    }
}

/// A sequence of bytes, `uint8[]`, which is put into a payload and taken out of it as a whole.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Bytes(pub Vec<u8>);

impl Serialize for Bytes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&self.0)
    }
}

impl<'de> Deserialize<'de> for Bytes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Whole;

        impl Visitor<'_> for Whole {
            type Value = Bytes;

            fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str("bytes")
            }

            fn visit_bytes<E>(self, bytes: &[u8]) -> Result<Bytes, E> {
                Ok(Bytes(bytes.to_vec()))
            }

            fn visit_byte_buf<E>(self, bytes: Vec<u8>) -> Result<Bytes, E> {
                Ok(Bytes(bytes))
            }
        }

        deserializer.deserialize_byte_buf(Whole)
    }
}
