//! A look at a message's structure before it is decoded.
//!
//! Two bytes on the wire can become hundreds in memory: an empty message in a list takes as much as
//! a full one. So the parts of a message are counted, by its schema, before memory is taken for
//! them.

use std::sync::LazyLock;

use prost::encoding::{DecodeContext, WireType, decode_key, decode_varint, skip_field};
use prost::{DecodeError, Message};
use prost_types::FileDescriptorSet;

use crate::error::WireError;

/// Maximum number of messages, strings and byte strings within one message. Each takes at most some
/// hundred bytes.
const MAX_PARTS: usize = 200_000;

/// Maximum depth of messages within messages; that of the schema is less.
const MAX_DEPTH: usize = 16;

const DESCRIPTORS: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/descriptors.binpb"));

/// Reads the schema of all messages.
///
/// # Errors
/// Never on a schema that this crate was built with.
pub fn schema() -> Result<FileDescriptorSet, DecodeError> {
    FileDescriptorSet::decode(DESCRIPTORS)
}

/// A message, and the messages that its fields hold, by their numbers.
struct Shape {
    name: String,
    nested: Vec<(u32, usize)>,
}

static SHAPES: LazyLock<Vec<Shape>> = LazyLock::new(|| {
    let files = schema().map(|set| set.file).unwrap_or_default();
    let messages: Vec<_> = files.iter().flat_map(|file| &file.message_type).collect();
    let shapes = messages.iter().map(|message| {
        let nested = message.field.iter().filter_map(|field| {
            let number = u32::try_from(field.number()).ok()?;
            // Empty for fields that hold no message.
            let inner = field.type_name().rsplit('.').next()?;
            let mut names = messages.iter().map(|message| message.name());
            Some((number, names.position(|name| name == inner)?))
        });
        Shape {
            name: message.name().to_owned(),
            nested: nested.collect(),
        }
    });
    shapes.collect()
});

/// Refuses a message with too many parts, or one that cannot be read to its end.
pub(crate) fn check(message: &'static str, payload: &[u8]) -> Result<(), WireError> {
    let shape = SHAPES.iter().find(|shape| shape.name == message);
    let mut walk = Walk { message, parts: 0 };
    walk.through(shape, payload, 0)
}

/// A walk through a message.
struct Walk {
    message: &'static str,
    parts: usize,
}

impl Walk {
    fn through(
        &mut self,
        shape: Option<&Shape>,
        payload: &[u8],
        depth: usize,
    ) -> Result<(), WireError> {
        let message = self.message;
        let malformed = |error: DecodeError| WireError::malformed(message, error);
        if depth > MAX_DEPTH {
            return Err(WireError::malformed(message, "nested too deeply"));
        }
        let nested = shape.map_or(&[][..], |shape| &shape.nested);
        let mut rest = payload;
        while !rest.is_empty() {
            let (number, wire_type) = decode_key(&mut rest).map_err(malformed)?;
            if wire_type != WireType::LengthDelimited {
                let context = DecodeContext::default();
                skip_field(wire_type, number, &mut rest, context).map_err(malformed)?;
                continue;
            }
            self.parts += 1;
            if self.parts > MAX_PARTS {
                let limit = MAX_PARTS;
                return Err(WireError::TooManyParts { message, limit });
            }
            let length = decode_varint(&mut rest).map_err(malformed)?;
            let (inner, after) = usize::try_from(length)
                .ok()
                .and_then(|length| rest.split_at_checked(length))
                .ok_or_else(|| WireError::malformed(message, "it ends early"))?;
            if let Some((_, inner_shape)) = nested.iter().find(|(known, _)| *known == number) {
                self.through(SHAPES.get(*inner_shape), inner, depth + 1)?;
            }
            rest = after;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::v1;

    #[test]
    fn many_empty_parts_are_refused_before_memory_is_taken_for_them() {
        // Field 2 (views), length 0, over and over.
        let payload = [0x12_u8, 0x00].repeat(MAX_PARTS + 1);
        let item = crate::decode::<v1::Item>(&payload, usize::MAX);
        assert!(matches!(item, Err(WireError::TooManyParts { .. })));
        // The same one level down: items (4) of a request for an evaluation.
        let mut request = vec![0x22];
        prost::encoding::encode_varint(payload.len() as u64, &mut request);
        request.extend(&payload);
        let request = crate::decode::<v1::EvaluateRequest>(&request, usize::MAX);
        assert!(matches!(request, Err(WireError::TooManyParts { .. })));
    }

    #[test]
    fn what_cannot_be_read_to_its_end_is_malformed() {
        for payload in [&[0x12, 0x05, 0x00][..], &[0x12], &[0xff; 12], &[0x0b]] {
            let item = crate::decode::<v1::Item>(payload, usize::MAX);
            assert!(matches!(item, Err(WireError::Malformed { .. })));
        }
    }
}
