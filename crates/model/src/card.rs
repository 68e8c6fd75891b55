//! Model cards: what a file of weights is, where it comes from and how good it is.

use serde::{Deserialize, Serialize};

use crate::accuracy::{Accuracies, Accuracy};
use crate::architecture::Architecture;
use crate::settings::{Device, TrainingSettings};

/// The version of the card's and the weights' form; another one is refused.
pub const FORMAT: u32 = 1;

/// The data that a network was trained on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DataFacts {
    /// The dataset's hash.
    pub hash: String,
    /// The hash of the catalogue that it was made with.
    pub catalogue_hash: String,
    /// Length of a cell's edge, in metres.
    pub cell_m: f64,
    /// One unit of height, in metres.
    pub height_unit_m: f64,
    /// Number of yaws.
    pub yaws: usize,
    /// The container's inner lengths, in metres.
    pub container_m: [f64; 3],
    /// Candidates of the training split that have a valid placement.
    pub training_candidates: u64,
    /// Candidates of the validation split that have a valid placement; 0 where there is no such
    /// split.
    pub validation_candidates: u64,
    /// Candidates of the test split that have a valid placement.
    pub test_candidates: u64,
}

/// Versions of what made a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Versions {
    /// Version of this software.
    pub ppnpack: String,
    /// Version of libtorch.
    pub libtorch: String,
}

/// A model card.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelCard {
    /// [`FORMAT`].
    pub format: u32,
    /// The network.
    pub architecture: Architecture,
    /// Count of the numbers that were trained.
    pub parameters: u64,
    /// The blake3 hash of the weights' file, in hexadecimal.
    pub weights_blake3: String,
    /// The data that it was trained on.
    pub data: DataFacts,
    /// The settings that it was trained with.
    pub training: TrainingSettings,
    /// The device that it was trained on.
    pub device: Device,
    /// Time spent on training, in seconds.
    pub training_s: f64,
    /// The epoch, from 1, that the weights are from.
    pub epoch: usize,
    /// Accuracy of what the planner proposes on the test split, by increasing share; empty where
    /// the test split has not been looked at.
    pub accuracy: Vec<Accuracy>,
    /// Accuracy on the validation split, by every question; it chose the epoch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation: Option<Accuracies>,
    /// Accuracy on the test split, by every question.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test: Option<Accuracies>,
    /// Versions of the software that made it.
    pub versions: Versions,
}
