//! The schemas of messages, as recordings and viewers need them beside the bytes.

use std::collections::BTreeSet;

use prost::{DecodeError, Message, Name};
use prost_types::{FileDescriptorProto, FileDescriptorSet};

use crate::keys::Stream;
use crate::{schema, v1};

/// The schema of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MessageSchema {
    /// The message's full name, such as `ppnpack.v1.Decision`.
    pub name: String,
    /// The files that define it, as an encoded `google.protobuf.FileDescriptorSet`.
    pub descriptors: Vec<u8>,
}

impl MessageSchema {
    /// Gives the schema of a message of this protocol.
    ///
    /// # Errors
    /// Never on a schema that this crate was built with.
    pub fn of<M: Name>() -> Result<Self, DecodeError> {
        let all = schema()?;
        let mut files = BTreeSet::new();
        let defines = |file: &&FileDescriptorProto| {
            let mut messages = file.message_type.iter();
            file.package() == M::PACKAGE && messages.any(|message| message.name() == M::NAME)
        };
        if let Some(file) = all.file.iter().find(defines) {
            add_with_imports(&all, file, &mut files);
        }
        let mut needed = all;
        needed.file.retain(|file| files.contains(file.name()));
        Ok(Self {
            name: M::full_name(),
            descriptors: needed.encode_to_vec(),
        })
    }

    /// Gives the schema of a stream's messages.
    ///
    /// # Errors
    /// Never on a schema that this crate was built with.
    pub fn of_stream(stream: Stream) -> Result<Self, DecodeError> {
        match stream {
            Stream::Cloud | Stream::TrayCloud => Self::of::<v1::PointCloud>(),
            Stream::Heightmap => Self::of::<v1::Heightmap>(),
            Stream::State => Self::of::<v1::CellState>(),
            Stream::Outcome => Self::of::<v1::Outcome>(),
            Stream::Plan => Self::of::<v1::Decision>(),
            Stream::Session => Self::of::<v1::Session>(),
            Stream::Record => Self::of::<v1::PlanningRecord>(),
        }
    }
}

/// Adds a file and all that it imports, by their names.
fn add_with_imports(
    all: &FileDescriptorSet,
    file: &FileDescriptorProto,
    added: &mut BTreeSet<String>,
) {
    if !added.insert(file.name().to_owned()) {
        return;
    }
    for import in &file.dependency {
        if let Some(imported) = all.file.iter().find(|other| other.name() == import) {
            add_with_imports(all, imported, added);
        }
    }
}
