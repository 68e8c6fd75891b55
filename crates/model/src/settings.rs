//! How networks are trained and run.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::architecture::Architecture;

/// What training minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Loss {
    /// The optimal placements rank above all others by a margin, per yaw and over all yaws.
    #[default]
    Ranking,
    /// The scores approximate the heuristic's values.
    Mse,
}

/// Where a network runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Device {
    /// The processor, one thread for inference.
    #[default]
    Cpu,
    /// The first CUDA device.
    Cuda,
}

/// How a network is trained. Two trainings with equal settings on the same data give the same weights on one machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingSettings {
    /// The network.
    pub architecture: Architecture,
    /// What is minimised.
    pub loss: Loss,
    /// Passes over the training split.
    pub epochs: usize,
    /// Packing steps per batch; each has up to a buffer of candidates.
    pub batch: usize,
    /// The learning rate at its peak: it rises over the first steps and falls to 0 as a cosine.
    pub learning_rate: f64,
    /// AdamW's decay of the weights.
    pub weight_decay: f64,
    /// `D_loc`, the margin of the ranking loss within a yaw; over all yaws it is twice that.
    pub margin: f64,
    /// Whether the problem's symmetries (mirror images and quarter turns) augment the data.
    pub augment: bool,
    /// Seeds the initial weights and the order of the data.
    pub seed: u64,
    /// Sequences of the training split that are used; all where it is not given.
    pub sequences: Option<usize>,
}

impl Default for TrainingSettings {
    fn default() -> Self {
        Self {
            architecture: Architecture::default(),
            loss: Loss::Ranking,
            epochs: 25,
            batch: 16,
            learning_rate: 2e-3,
            weight_decay: 1e-2,
            margin: 1.0,
            augment: true,
            seed: 0,
            sequences: None,
        }
    }
}

/// What training works on, and where it leaves its results.
#[derive(Debug, Clone)]
pub struct TrainingRequest {
    /// The dataset's folder.
    pub dataset: PathBuf,
    /// Where the model, its card and the checkpoint are written.
    pub folder: PathBuf,
    /// How to train.
    pub settings: TrainingSettings,
    /// Where to train.
    pub device: Device,
    /// Threads of the training's arithmetic on the processor.
    pub threads: usize,
    /// Whether to go on from the checkpoint in the folder.
    pub resume: bool,
}
