//! Faults of a network.

use ppnpack_dataset::DatasetError;
use ppnpack_files::WriteError;
use ppnpack_model::architecture::ArchitectureError;
use tch::TchError;

/// A network that could not be made, trained or run. Faults of weights come with their origin,
/// those of a checkpoint with its path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// An operation that libtorch refused.
    #[error("libtorch: {0}")]
    Torch(#[from] TchError),
    /// Tensors that cannot be written in the safetensors format.
    #[error("safetensors: {0}")]
    Format(#[from] safetensors::SafeTensorError),
    /// An architecture that cannot be built.
    #[error(transparent)]
    Architecture(#[from] ArchitectureError),
    /// Data that cannot be used.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A file that cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Anything else, in a sentence for people.
    #[error("{0}")]
    Other(String),
}
