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
    /// The scores approximate by how much the heuristic's values exceed the candidate's optimum.
    Mse,
}

/// Which placements of a candidate the loss is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LossOver {
    /// All placements, as in the paper: the network also learns what does not fit.
    All,
    /// Those that fit; the others are left out of the proposals, whatever their scores.
    #[default]
    Fitting,
}

/// How the learning rate changes during a training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// Not at all, as in the paper.
    Constant,
    /// It rises linearly over the first 3 % of the batches, then falls to 0 as a cosine.
    #[default]
    WarmUpAndCosine,
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
    /// Which placements it is over.
    pub loss_over: LossOver,
    /// How much a placement that does not fit counts in a loss over all, against one that fits. With less than 1 the network
    /// learns where nothing fits, and spends less on it than on the order of what the planner chooses among.
    pub misfit_weight: f64,
    /// Up to where regression tells its targets apart, in units of the objective; what does not fit or is not valid has this
    /// target. The bulk of a container's placements lies far above the optimum: told apart too, it would be most of the
    /// squared error.
    pub cut_off: f64,
    /// Passes over the training split.
    pub epochs: usize,
    /// Packing steps per batch; each has up to a buffer of candidates.
    pub batch: usize,
    /// The learning rate at its peak.
    pub learning_rate: f64,
    /// How the learning rate changes.
    pub schedule: Schedule,
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
    /// How many tenths of all sequences are held out of the training split for validation: those whose number ends in
    /// 8, in 7, and so on. Without any, the last epoch's weights are kept instead of the best epoch's.
    pub validation_tenths: u32,
}

/// Tenths of the sequences that can be held out for validation: one of the training split's nine is left to train on.
pub const MOST_VALIDATION_TENTHS: u32 = 8;

impl TrainingSettings {
    /// Whether a sequence of the training split is held out for validation.
    pub fn is_validation(&self, sequence: u32) -> bool {
        let digit = sequence % 10;
        digit < 9 && digit + self.validation_tenths >= 9
    }
}

impl Default for TrainingSettings {
    fn default() -> Self {
        Self {
            architecture: Architecture::default(),
            loss: Loss::Ranking,
            loss_over: LossOver::Fitting,
            misfit_weight: 1.0,
            cut_off: 10.0,
            epochs: 25,
            batch: 16,
            learning_rate: 2e-3,
            schedule: Schedule::WarmUpAndCosine,
            weight_decay: 1e-2,
            margin: 1.0,
            augment: true,
            seed: 0,
            sequences: None,
            validation_tenths: 1,
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
    /// Threads on the processor: of the training's arithmetic there, or of what prepares batches for another device.
    pub threads: usize,
    /// Whether to go on from the checkpoint in the folder.
    pub resume: bool,
    /// Whether to look at the test split when the training has ended. Whoever compares trainings does so for the one
    /// that validation has chosen alone.
    pub look_at_test: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn validation_takes_whole_sequences_from_the_end_of_each_ten_but_the_test_split() {
        let held_out = |tenths| {
            let settings = TrainingSettings {
                validation_tenths: tenths,
                ..TrainingSettings::default()
            };
            let sequences = (0..20).filter(|sequence| settings.is_validation(*sequence));
            sequences.collect::<Vec<u32>>()
        };
        assert!(held_out(0).is_empty());
        assert_eq!(held_out(1), [8, 18]);
        assert_eq!(held_out(3), [6, 7, 8, 16, 17, 18]);
        assert_eq!(held_out(MOST_VALIDATION_TENTHS).len(), 16);
    }
}
