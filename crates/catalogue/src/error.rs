//! Errors of a source of objects.

use std::path::PathBuf;

use crate::reader::ReadError;
use crate::repair::MeshError;
use crate::views::ViewError;

/// Why a file is no object that can be packed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjectError {
    /// It cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Its mesh is no solid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// It cannot be packed at the resolution.
    #[error(transparent)]
    View(#[from] ViewError),
}

/// A file that is no object that can be packed, and why.
#[derive(Debug, thiserror::Error)]
#[error("{} {error}", path.display())]
pub struct BadObject {
    /// The file, or the name of a mesh that was given.
    pub path: PathBuf,
    /// Reason.
    pub error: ObjectError,
}

/// Why a catalogue could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CatalogueError {
    /// The folder does not exist.
    #[error("{} is no folder: give the folder that holds the mesh files", folder.display())]
    MissingFolder {
        /// The folder given.
        folder: PathBuf,
    },
    /// The folder has no mesh file.
    #[error("{} holds no .ply, .obj, .stl, .glb or .3mf file", folder.display())]
    EmptyFolder {
        /// The folder given.
        folder: PathBuf,
    },
    /// The folder or its table cannot be read.
    #[error("{} cannot be read: {source}", folder.display())]
    Folder {
        /// The folder or the table.
        folder: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// A line of `objects.csv` is wrong.
    #[error("{}:{line}: {reason}", path.display())]
    Table {
        /// The table.
        path: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// Reason, and what to do.
        reason: String,
    },
    /// Two objects have the same name.
    #[error(
        "the name '{name}' stands for both {} and {}: rename one",
        first.display(),
        second.display()
    )]
    DuplicateName {
        /// The name.
        name: String,
        /// One file.
        first: PathBuf,
        /// The other file.
        second: PathBuf,
    },
    /// Some files are no objects that can be packed.
    #[error("{}", lines(bad))]
    Objects {
        /// Each such file, in the catalogue's order.
        bad: Vec<BadObject>,
    },
}

/// One file a line.
fn lines(bad: &[BadObject]) -> String {
    let lines: Vec<String> = bad.iter().map(ToString::to_string).collect();
    lines.join("\n")
}
