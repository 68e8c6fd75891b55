//! Errors of a source of objects.

/// Why a file or a mesh is no object that can be packed, and what to do, in a line for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ObjectError(pub(crate) String);

/// Why a catalogue could not be made, for people; where files are bad, a line for each.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CatalogueError(pub(crate) String);
