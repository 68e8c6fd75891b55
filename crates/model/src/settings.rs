//! Settings of training and of running networks.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::architecture::Architecture;

/// A loss, which training minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Loss {
    /// The optimal placements rank above all others by a margin, per yaw and over all yaws.
    #[default]
    Ranking,
    /// The scores approximate by how much the heuristic's values exceed the candidate's optimum.
    Mse,
}

/// The placements of a candidate that the loss is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LossOver {
    /// All placements, as in the paper: the network also learns what does not fit.
    All,
    /// Placements that fit; the others are left out of the proposals, whatever their scores.
    #[default]
    Fitting,
}

/// A schedule of the learning rate during a training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// The same rate throughout, as in the paper.
    Constant,
    /// A linear rise over the first 3 % of the batches, then a fall to 0 as a cosine.
    #[default]
    WarmUpAndCosine,
}

/// A device that a network runs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Device {
    /// The processor, one thread for inference.
    #[default]
    Cpu,
    /// The first CUDA device.
    Cuda,
}

/// Settings of a training. Two trainings with equal settings on the same data give the same weights
/// on one machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingSettings {
    /// The network.
    pub architecture: Architecture,
    /// The loss that is minimised.
    pub loss: Loss,
    /// The placements that the loss is over.
    pub loss_over: LossOver,
    /// Weight of a placement that does not fit in a loss over all, against one that fits. With less
    /// than 1 the network spends less on where nothing fits than on the order of what does.
    pub misfit_weight: f64,
    /// Maximum of regression's targets, in units of the objective, and the target of what does not
    /// fit or is not valid. Most placements of a container lie far above the optimum: told apart
    /// too, they would be most of the squared error.
    pub cut_off: f64,
    /// Passes over the training split.
    pub epochs: usize,
    /// Packing steps per batch; each has up to a buffer of candidates.
    pub batch: usize,
    /// The learning rate at its peak.
    pub learning_rate: f64,
    /// The schedule of the learning rate.
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
    /// Tenths of all sequences that are held out of the training split for validation: those whose
    /// number ends in 8, in 7, and so on. Without any, the last epoch's weights are kept instead of
    /// the best epoch's.
    pub validation_tenths: u32,
}

/// Maximum of the tenths that can be held out for validation: one of the training split's nine is
/// left to train on.
pub const MOST_VALIDATION_TENTHS: u32 = 8;

impl TrainingSettings {
    /// Says whether a sequence of the training split is held out for validation.
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

/// A request to train: the data, the settings and the folder of the results.
#[derive(Debug, Clone)]
pub struct TrainingRequest {
    /// The dataset's folder.
    pub dataset: PathBuf,
    /// The folder that the model, its card and the checkpoint are written to.
    pub folder: PathBuf,
    /// Settings of the training.
    pub settings: TrainingSettings,
    /// The device to train on.
    pub device: Device,
    /// Threads on the processor: of the training's arithmetic there, or of what prepares batches
    /// for another device.
    pub threads: usize,
    /// Whether to go on from the checkpoint in the folder.
    pub resume: bool,
    /// Whether to look at the test split when the training has ended: of several trainings that are
    /// compared, only for the one that validation has chosen.
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
