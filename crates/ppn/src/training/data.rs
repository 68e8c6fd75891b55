//! The steps that a training works on, in three splits.

use std::cell::RefCell;

use ppnpack_dataset::{Dataset, Split, StepRecord};
use ppnpack_model::report::TrainingEvent;
use ppnpack_model::settings::{Loss, TrainingSettings};

use crate::error::NetworkError;

/// The steps of each split; no sequence is in two of them.
pub(crate) struct Data {
    /// Steps to learn from.
    pub(crate) training: Vec<StepRecord>,
    /// Steps that choose: the epoch here, settings between trainings.
    pub(crate) validation: Vec<StepRecord>,
    /// Steps that are looked at once, at the end.
    pub(crate) test: Vec<StepRecord>,
}

impl Data {
    pub(crate) fn load(
        dataset: &Dataset,
        settings: &TrainingSettings,
        watch: &mut dyn FnMut(TrainingEvent),
    ) -> Result<Self, NetworkError> {
        let watch = RefCell::new(watch);
        let progress = |done, total| watch.borrow_mut()(TrainingEvent::Reading { done, total });
        let with_values = settings.loss == Loss::Mse;
        let load = |split| dataset.load(split, with_values, &progress);
        let (validation, mut training): (Vec<_>, Vec<_>) = load(Split::Train)?
            .into_iter()
            .partition(|step| settings.is_validation(step.sequence));
        if let Some(sequences) = settings.sequences {
            keep_first(&mut training, sequences);
        }
        let data = Self {
            training,
            validation,
            test: load(Split::Test)?,
        };
        let asks_for_validation = settings.validation_tenths > 0;
        for (is_needed, steps, what) in [
            (true, &data.training, "training steps"),
            (asks_for_validation, &data.validation, "validation steps"),
            (true, &data.test, "test steps"),
        ] {
            if is_needed && count(steps) == 0 {
                let none = format!("the dataset has no {what} with a valid placement");
                return Err(NetworkError::Other(none));
            }
        }
        Ok(data)
    }
}

/// Keeps the steps of so many sequences, from the first; steps are in the order of their sequences.
fn keep_first(steps: &mut Vec<StepRecord>, sequences: usize) {
    let mut numbers: Vec<u32> = steps.iter().map(|step| step.sequence).collect();
    numbers.dedup();
    if let Some(limit) = numbers.get(sequences).copied() {
        steps.retain(|step| step.sequence < limit);
    }
}

/// Counts the candidates with a valid placement.
pub(crate) fn count(steps: &[StepRecord]) -> u64 {
    let candidates = steps.iter().flat_map(|step| &step.candidates);
    let valid = candidates.filter(|candidate| candidate.best_value().is_finite());
    valid.count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn so_many_sequences_are_kept_whole() {
        let step = |(sequence, step)| StepRecord {
            sequence,
            step,
            heightmap: Vec::new(),
            candidates: Vec::new(),
        };
        let all = [(0, 0), (0, 1), (2, 0), (2, 1), (5, 0)];
        let kept = |sequences| {
            let mut steps: Vec<StepRecord> = all.map(step).into();
            keep_first(&mut steps, sequences);
            steps.len()
        };
        assert_eq!([0, 1, 2, 3, 9].map(kept), [0, 2, 4, 5, 5]);
    }
}
