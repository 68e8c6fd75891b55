//! What can go wrong with a network.

use std::path::PathBuf;

use ppnpack_dataset::DatasetError;
use ppnpack_files::WriteError;
use ppnpack_model::architecture::ArchitectureError;
use tch::TchError;

/// Why a network could not be made, trained or run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// libtorch refused an operation.
    #[error("libtorch: {0}")]
    Torch(#[from] TchError),
    /// Tensors cannot be written in the safetensors format.
    #[error("safetensors: {0}")]
    Format(#[from] safetensors::SafeTensorError),
    /// The architecture cannot be built.
    #[error(transparent)]
    Architecture(#[from] ArchitectureError),
    /// The data cannot be used.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// CUDA was asked for and is not there.
    #[error(
        "there is no CUDA device that libtorch can use: run on the cpu, or name a full installation of torch 2.11 with \
         PPNPACK_TORCH"
    )]
    NoCuda,
    /// A tensor that the architecture has is not in the weights.
    #[error("{origin}: the weights have no tensor {tensor}; they belong to another architecture")]
    MissingTensor {
        /// Where the weights are from.
        origin: String,
        /// The tensor.
        tensor: String,
    },
    /// A tensor has another shape than the architecture's.
    #[error(
        "{origin}: tensor {tensor} has shape {found:?}, but the architecture needs {expected:?}"
    )]
    Shape {
        /// Where the weights are from.
        origin: String,
        /// The tensor.
        tensor: String,
        /// The architecture's shape.
        expected: Vec<i64>,
        /// The weights' shape.
        found: Vec<i64>,
    },
    /// The weights have a tensor that the architecture does not.
    #[error("{origin}: the architecture has no tensor {tensor}; the weights belong to another one")]
    UnknownTensor {
        /// Where the weights are from.
        origin: String,
        /// The tensor.
        tensor: String,
    },
    /// A score is not a number.
    #[error("the network's scores for item {item} are not finite")]
    NotFinite {
        /// The item's name.
        item: String,
    },
    /// A loss is not a number.
    #[error(
        "the loss of batch {batch} of epoch {epoch} is not finite; the batch is kept in {}: try a lower --learning-rate",
        kept.display()
    )]
    LossNotFinite {
        /// The epoch, from 1.
        epoch: usize,
        /// The batch, from 0.
        batch: usize,
        /// Where the batch's tensors are.
        kept: PathBuf,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file cannot be read.
    #[error("{} cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        source: std::io::Error,
    },
    /// The folder has the checkpoint of another training.
    #[error(
        "{} is the checkpoint of another training ({difference}): choose another --out, or give the same settings",
        path.display()
    )]
    OtherTraining {
        /// The checkpoint.
        path: PathBuf,
        /// What differs.
        difference: String,
    },
    /// The folder has a checkpoint, but the training was not asked to go on from it.
    #[error(
        "{} is the checkpoint of a training: go on with --resume, or choose another --out",
        path.display()
    )]
    Unfinished {
        /// The checkpoint.
        path: PathBuf,
    },
    /// A checkpoint is damaged.
    #[error("{} is damaged: {what}; delete it to train anew", path.display())]
    Checkpoint {
        /// The checkpoint.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The data has nothing to train on.
    #[error("the dataset has no {0} with a valid placement")]
    NoData(&'static str),
    /// Regression needs values that the data does not have.
    #[error("--loss mse needs a dataset with values: make it with `ppnpack dataset --values`")]
    NoValues,
    /// The thread that prepares batches stopped.
    #[error("the thread that prepares batches stopped")]
    Loader,
}
