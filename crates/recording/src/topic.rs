//! The channels of a recording.

use std::fmt;

use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::schemas::MessageSchema;
use ppnpack_wire::v1;
use prost::DecodeError;

/// What the messages of a channel are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// What a cell publishes.
    Stream(Stream),
    /// Items and solids that records name.
    Shape,
}

/// A channel: what the messages are, and of which cell or container.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Topic {
    /// Of which cell or container.
    pub cell: Cell,
    /// What they are.
    pub kind: Kind,
}

impl Kind {
    const SHAPE: &str = "shape";

    /// As it stands in the channel's name.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Stream(stream) => stream.as_str(),
            Self::Shape => Self::SHAPE,
        }
    }

    /// The schema of its messages.
    ///
    /// # Errors
    /// Never on schemas that the program was built with.
    pub fn schema(self) -> Result<MessageSchema, DecodeError> {
        match self {
            Self::Stream(stream) => MessageSchema::of_stream(stream),
            Self::Shape => MessageSchema::of::<v1::Shape>(),
        }
    }
}

impl Topic {
    /// The channel of this name; `None` where it is none of a recording.
    pub fn parse(name: &str) -> Option<Self> {
        let (cell, kind) = name.strip_prefix('/')?.split_once('/')?;
        let mut streams = Stream::ALL.iter();
        let kind = match kind {
            Kind::SHAPE => Kind::Shape,
            kind => Kind::Stream(*streams.find(|stream| stream.as_str() == kind)?),
        };
        let cell = Cell::new(cell).ok()?;
        Some(Self { cell, kind })
    }
}

impl fmt::Display for Topic {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "/{}/{}", self.cell, self.kind.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_channel_says_what_it_is() {
        let streams = Stream::ALL.iter().copied().map(Kind::Stream);
        for kind in streams.chain([Kind::Shape]) {
            let cell = Cell::new("cell-1").unwrap();
            let topic = Topic { cell, kind };
            assert_eq!(Topic::parse(&topic.to_string()), Some(topic));
        }
        for other in [
            "",
            "/",
            "/cell-1",
            "/cell-1/else",
            "cell-1/plan",
            "/a b/plan",
        ] {
            assert_eq!(Topic::parse(other), None, "{other}");
        }
    }

    #[test]
    fn every_channel_has_a_schema_that_defines_its_message() {
        let streams = Stream::ALL.iter().copied().map(Kind::Stream);
        for kind in streams.chain([Kind::Shape]) {
            let schema = kind.schema().unwrap();
            let pool = prost_reflect::DescriptorPool::decode(schema.descriptors.as_slice());
            let message = pool.unwrap().get_message_by_name(&schema.name);
            assert!(message.is_some(), "{kind:?} has no {}", schema.name);
        }
    }
}
