//! The channels of a recording.

use std::fmt;

use ppnpack_wire::keys::{ALL_CELLS, Cell, Stream};
use ppnpack_wire::schemas::MessageSchema;
use ppnpack_wire::v1;
use prost::DecodeError;

/// A channel: the kind of its messages, and their cell or container.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// A stream of a cell or a container.
    Stream(Cell, Stream),
    /// Items and solids that the records of a cell name.
    Shape(Cell),
    /// The services' answers to requests for their health.
    Health,
}

impl Topic {
    const SHAPE: &str = "shape";
    /// The word in the channel's name, and in the options that leave it out.
    pub const HEALTH: &str = "health";

    /// Reads the name of a channel; `None` where a recording has no such channel.
    pub fn parse(name: &str) -> Option<Self> {
        let (cell, kind) = name.strip_prefix('/')?.split_once('/')?;
        match (cell, kind) {
            (ALL_CELLS, Self::HEALTH) => Some(Self::Health),
            (cell, Self::SHAPE) => Some(Self::Shape(Cell::new(cell).ok()?)),
            (cell, kind) => {
                let mut streams = Stream::ALL.iter();
                let stream = *streams.find(|stream| stream.as_str() == kind)?;
                Some(Self::Stream(Cell::new(cell).ok()?, stream))
            }
        }
    }

    /// Gives its cell or container; `None` where it has none.
    pub fn cell(&self) -> Option<&Cell> {
        match self {
            Self::Stream(cell, _) | Self::Shape(cell) => Some(cell),
            Self::Health => None,
        }
    }

    /// Gives the schema of its messages.
    ///
    /// # Errors
    /// Never on schemas that the program was built with.
    pub fn schema(&self) -> Result<MessageSchema, DecodeError> {
        match self {
            Self::Stream(_, stream) => MessageSchema::of_stream(*stream),
            Self::Shape(_) => MessageSchema::of::<v1::Shape>(),
            Self::Health => MessageSchema::of::<v1::HealthReply>(),
        }
    }
}

impl fmt::Display for Topic {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cell = self.cell().map_or(ALL_CELLS, Cell::as_str);
        let kind = match self {
            Self::Stream(_, stream) => stream.as_str(),
            Self::Shape(_) => Self::SHAPE,
            Self::Health => Self::HEALTH,
        };
        write!(formatter, "/{cell}/{kind}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> impl Iterator<Item = Topic> {
        let cell = Cell::new("cell-1").unwrap();
        let of = cell.clone();
        let streams = Stream::ALL.iter().copied();
        let streams = streams.map(move |stream| Topic::Stream(of.clone(), stream));
        streams.chain([Topic::Shape(cell), Topic::Health])
    }

    #[test]
    fn the_name_of_a_channel_says_what_it_is() {
        for topic in all() {
            assert_eq!(Topic::parse(&topic.to_string()), Some(topic));
        }
        for other in [
            "",
            "/",
            "/cell-1",
            "/cell-1/else",
            "cell-1/plan",
            "/a b/plan",
            "/cell-1/health",
            "/all/plan",
            "/all/shape",
        ] {
            assert_eq!(Topic::parse(other), None, "{other}");
        }
    }

    #[test]
    fn every_channel_has_a_schema_that_defines_its_message() {
        for topic in all() {
            let schema = topic.schema().unwrap();
            let pool = prost_reflect::DescriptorPool::decode(schema.descriptors.as_slice());
            let message = pool.unwrap().get_message_by_name(&schema.name);
            assert!(message.is_some(), "{topic} has no {}", schema.name);
        }
    }
}
