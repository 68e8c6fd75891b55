//! Faults of a network.

use std::path::PathBuf;

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
    /// CUDA was asked for and is not there.
    #[error(
        "there is no CUDA device that libtorch can use: run on the cpu, or name a full installation of torch 2.11 with \
         PPNPACK_TORCH"
    )]
    NoCuda,
    /// A tensor of the architecture, by name, that is not in the weights.
    #[error("{0}: the weights have no tensor {1}; they belong to another architecture")]
    MissingTensor(String, String),
    /// A tensor of another shape than the architecture's.
    #[error(
        "{origin}: tensor {tensor} has shape {found:?}, but the architecture needs {expected:?}"
    )]
    Shape {
        /// The origin of the weights.
        origin: String,
        /// The tensor's name.
        tensor: String,
        /// The architecture's shape.
        expected: Vec<i64>,
        /// The weights' shape.
        found: Vec<i64>,
    },
    /// A tensor of the weights, by name, that the architecture does not have.
    #[error("{0}: the architecture has no tensor {1}; the weights belong to another one")]
    UnknownTensor(String, String),
    /// An item, by name, with a score that is no number.
    #[error("the network's scores for item {0} are not finite")]
    NotFinite(String),
    /// A loss that is no number.
    #[error(
        "the loss of batch {batch} of epoch {epoch} is not finite; the batch is kept in {}: try a lower --learning-rate",
        kept.display()
    )]
    LossNotFinite {
        /// The epoch, from 1.
        epoch: usize,
        /// The batch, from 0.
        batch: usize,
        /// The file of the batch's tensors.
        kept: PathBuf,
    },
    /// A file that cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file that cannot be read.
    #[error("{path} cannot be read: {1}", path = .0.display())]
    Read(PathBuf, #[source] std::io::Error),
    /// A checkpoint of another training, with the settings that differ.
    #[error(
        "{path} is the checkpoint of another training ({1}): choose another --out, or give the same settings",
        path = .0.display()
    )]
    OtherTraining(PathBuf, String),
    /// A checkpoint in the folder of a training that was not asked to go on from it.
    #[error("{path} is the checkpoint of a training: go on with --resume, or choose another --out", path = .0.display())]
    Unfinished(PathBuf),
    /// A damaged checkpoint, with the fault.
    #[error("{path} is damaged: {1}; delete it to train anew", path = .0.display())]
    Checkpoint(PathBuf, String),
    /// Data with nothing to train on.
    #[error("the dataset has no {0} with a valid placement")]
    NoData(&'static str),
    /// Data without the values that regression needs.
    #[error("--loss mse needs a dataset with values: make it with `ppnpack dataset --values`")]
    NoValues,
    /// A thread that prepares batches and stopped.
    #[error("the thread that prepares batches stopped")]
    Loader,
}
