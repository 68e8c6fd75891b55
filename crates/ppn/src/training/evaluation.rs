//! Evaluation of a network on steps that it was not trained on.

use ppnpack_dataset::StepRecord;
use ppnpack_model::accuracy::Tally;
use ppnpack_model::report::Evaluation;
use ppnpack_model::settings::TrainingSettings;
use tch::no_grad;

use super::batch::Batch;
use super::forward;
use super::loader::{Loader, Preparation, in_order};
use super::loss::{loss, ranks};
use crate::error::NetworkError;
use crate::network::Network;

/// Number of steps that are looked at together.
const EVALUATION_BATCH: usize = 64;

/// Gives the network's loss and accuracy on these steps.
pub(crate) fn evaluate(
    network: &mut Network,
    device: tch::Device,
    settings: &TrainingSettings,
    preparation: &Preparation,
    steps: &[StepRecord],
) -> Result<Evaluation, NetworkError> {
    network.set_training(false);
    let plans = in_order(steps.len(), EVALUATION_BATCH);
    let mut tally = Tally::default();
    let mut loss_sum = 0.0;
    std::thread::scope(|scope| -> Result<(), NetworkError> {
        let mut loader = Loader::start(scope, preparation, steps, &plans);
        for _ in &plans {
            let batch = loader.next()?;
            let add = || add(network, device, settings, &batch, &mut tally);
            loss_sum += no_grad(add)? * batch.len() as f64;
        }
        Ok(())
    })?;
    Ok(Evaluation {
        loss: loss_sum / (steps.len() as f64).max(1.0),
        accuracies: tally.accuracies(),
    })
}

/// Counts a batch's ranks; gives its loss.
fn add(
    network: &Network,
    device: tch::Device,
    settings: &TrainingSettings,
    batch: &Batch,
    tally: &mut Tally,
) -> Result<f64, NetworkError> {
    let tensors = batch.to(device)?;
    let scores = forward(network, &tensors)?;
    let ranks = ranks(&scores, &tensors.labels)?;
    for (candidate, rank) in ranks.iter().enumerate() {
        if let (Some(sequence), Some(rank)) = (batch.sequence_of(candidate), rank) {
            tally.add(sequence, rank);
        }
    }
    let loss = loss(&scores, &tensors.labels, settings)?;
    Ok(loss.f_double_value(&[])?)
}
