//! What a training reports of its epochs.

use serde::{Deserialize, Serialize};

use crate::card::Accuracy;

/// One epoch of a training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EpochReport {
    /// Its number, from 1.
    pub epoch: usize,
    /// The mean loss over the epoch's batches.
    pub training_loss: f64,
    /// The mean loss on the test split.
    pub test_loss: f64,
    /// Accuracy on the test split, by increasing share.
    pub accuracy: Vec<Accuracy>,
    /// Time spent on training until here, in seconds.
    pub training_s: f64,
    /// The part of the time in which training waited for data.
    pub waiting_share: f64,
}
