//! Reports of a training.

use serde::{Deserialize, Serialize};

use crate::accuracy::Accuracies;

/// One epoch of a training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EpochReport {
    /// Its number, from 1.
    pub epoch: usize,
    /// The mean loss over the epoch's batches.
    pub training_loss: f64,
    /// Loss and accuracy on the validation split, where there is one.
    pub validation: Option<Evaluation>,
    /// Time spent on training until here, in seconds.
    pub training_s: f64,
    /// The part of the time in which training waited for data.
    pub waiting_share: f64,
}

/// Loss and accuracy of a network on sequences that it was not trained on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// The mean loss over the steps.
    pub loss: f64,
    /// Accuracy, by every question.
    pub accuracies: Accuracies,
}

/// An event in the progress of a training.
#[derive(Debug, Clone)]
pub enum TrainingEvent {
    /// The data is being read.
    Reading {
        /// Parts done.
        done: usize,
        /// All parts.
        total: usize,
    },
    /// A batch is done.
    Batch {
        /// Batches done, over all epochs.
        done: u64,
        /// All batches, over all epochs.
        total: u64,
        /// The mean loss of the epoch so far.
        loss: f64,
    },
    /// An epoch is done; those before an interruption are told again.
    Epoch(EpochReport),
}
