//! Checkpoints: everything that a training needs to go on as if it had not been interrupted.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ppnpack_files::write_whole;
use ppnpack_model::accuracy::Question;
use ppnpack_model::report::EpochReport;
use ppnpack_model::settings::TrainingSettings;
use ppnpack_model::weights::{WeightTensor, tensors, to_bytes};
use safetensors::SafeTensors;
use serde::{Deserialize, Serialize};

use super::optimiser::AdamW;
use crate::error::NetworkError;
use crate::files::{all_to_plain, copy_into};
use crate::network::Parameters;

const STATE: &str = "state";

/// Name of the file of a training's checkpoint.
pub const CHECKPOINT_FILE: &str = "checkpoint.safetensors";

/// The state of a training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    pub(crate) settings: TrainingSettings,
    pub(crate) data_hash: String,
    /// Epochs done, and batches done of the next.
    pub(crate) epoch: usize,
    pub(crate) batch: usize,
    pub(crate) updates: u64,
    /// The sum of the losses of the batches done of the epoch under way.
    pub(crate) loss_sum: f64,
    pub(crate) epochs: Vec<EpochReport>,
    pub(crate) training_s: f64,
}

impl State {
    /// Gives the epoch that does best on the validation split by the question that the network is
    /// trained for, the first of equals; none without such a split.
    pub(crate) fn best_epoch(&self) -> Option<usize> {
        let question = Question::of_loss(self.settings.loss_over);
        let found = self.epochs.iter().filter_map(|report| {
            let accuracies = &report.validation.as_ref()?.accuracies;
            Some((report.epoch, accuracies.decisive(question)))
        });
        let best = found.reduce(|best, next| if next.1 > best.1 { next } else { best });
        best.map(|(epoch, _)| epoch)
    }
}

/// Prefixes of tensors' names in a checkpoint, by what they are part of.
const WEIGHT: &str = "weight/";
const BEST: &str = "best/";

pub(crate) fn path(folder: &Path) -> PathBuf {
    folder.join(CHECKPOINT_FILE)
}

/// Writes a checkpoint in place of the last; `best` has the weights of the best epoch, if there is
/// one.
pub(crate) fn save(
    folder: &Path,
    state: &State,
    parameters: &Parameters,
    optimiser: &AdamW,
    best: Option<&BTreeMap<String, WeightTensor>>,
) -> Result<(), NetworkError> {
    let path = path(folder);
    let weights = parameters.tensors().iter();
    let weights = weights.map(|(name, tensor)| (format!("{WEIGHT}{name}"), tensor));
    let moments = optimiser.moments.iter().flat_map(|(name, moments)| {
        let mean = (format!("mean/{name}"), &moments.mean);
        [mean, (format!("square/{name}"), &moments.square)]
    });
    let mut tensors = all_to_plain(weights.chain(moments))?;
    let best = best.into_iter().flatten();
    tensors.extend(best.map(|(name, values)| (format!("{BEST}{name}"), values.clone())));
    let text = serde_json::to_string(state).map_err(|error| damaged(&path, &error))?;
    let bytes = to_bytes(&tensors, Some((STATE, text)))?;
    Ok(write_whole(&path, &bytes)?)
}

/// Takes a checkpoint's tensors over; gives its state and the weights of its best epoch, if it has
/// one.
pub(crate) fn load(
    folder: &Path,
    expected: &State,
    parameters: &Parameters,
    optimiser: &mut AdamW,
) -> Result<(State, Option<BTreeMap<String, WeightTensor>>), NetworkError> {
    let path = path(folder);
    let bytes = std::fs::read(&path).map_err(|error| {
        NetworkError::Other(format!("{} cannot be read: {error}", path.display()))
    })?;
    let (_, header) = SafeTensors::read_metadata(&bytes).map_err(|error| damaged(&path, &error))?;
    let texts = header.metadata().as_ref();
    let text = texts.and_then(|texts| texts.get(STATE));
    let text = text.ok_or_else(|| damaged(&path, &"it has no state"))?;
    let state: State = serde_json::from_str(text).map_err(|error| damaged(&path, &error))?;
    if let Some(difference) = difference(&state, expected) {
        return Err(NetworkError::Other(format!(
            "{} is the checkpoint of another training ({difference}): choose another --out, or give the same settings",
            path.display()
        )));
    }
    let origin = path.display().to_string();
    let kept = tensors(&origin, &bytes).map_err(|error| damaged(&path, &error))?;
    let take = |name: String, tensor| match kept.get(&name) {
        Some(values) => copy_into(&origin, &name, values, tensor),
        None => Err(damaged(&path, &format_args!("it has no tensor {name}"))),
    };
    for (name, tensor) in parameters.tensors() {
        take(format!("{WEIGHT}{name}"), tensor)?;
    }
    for (name, moments) in &optimiser.moments {
        take(format!("mean/{name}"), &moments.mean)?;
        take(format!("square/{name}"), &moments.square)?;
    }
    optimiser.updates = state.updates;
    let of_best = |(name, values): (&String, &WeightTensor)| {
        let name = name.strip_prefix(BEST)?;
        Some((name.to_owned(), values.clone()))
    };
    let best: BTreeMap<_, _> = kept.iter().filter_map(of_best).collect();
    let is_whole = best.len() == parameters.tensors().len();
    if state.best_epoch().is_some() && !is_whole {
        return Err(damaged(&path, &"it has not all weights of the best epoch"));
    }
    Ok((state, is_whole.then_some(best)))
}

/// Says what keeps one training's checkpoint from being another's.
fn difference(found: &State, expected: &State) -> Option<String> {
    if found.data_hash != expected.data_hash {
        return Some("the data differ".to_owned());
    }
    let as_json = |state: &State| serde_json::to_value(&state.settings).unwrap_or_default();
    let (found, expected) = (as_json(found), as_json(expected));
    let (found, expected) = (found.as_object()?, expected.as_object()?);
    found.iter().find_map(|(name, value)| {
        let other = expected.get(name)?;
        (value != other).then(|| format!("{name} is {value}, not {other}"))
    })
}

pub(super) fn damaged(path: &Path, what: &dyn std::fmt::Display) -> NetworkError {
    let path = path.display();
    NetworkError::Other(format!(
        "{path} is damaged: {what}; delete it to train anew"
    ))
}

#[cfg(test)]
mod tests {
    use ppnpack_model::accuracy::{Rank, Tally};
    use ppnpack_model::report::Evaluation;
    use ppnpack_model::settings::LossOver;

    use super::*;

    /// An epoch after which the optimum has these placements before it, all of them fitting or
    /// none.
    fn report(epoch: usize, ranks: Option<(u64, u64)>) -> EpochReport {
        let validation = ranks.map(|(before, fitting_before)| {
            let mut tally = Tally::default();
            let rank = Rank {
                placements: 1000,
                fitting: 100,
                before,
                fitting_before,
            };
            tally.add(8, &rank);
            Evaluation {
                loss: 0.0,
                accuracies: tally.accuracies(),
            }
        });
        EpochReport {
            epoch,
            training_loss: 0.0,
            validation,
            training_s: 0.0,
            waiting_share: 0.0,
        }
    }

    fn best(over: LossOver, ranks: [Option<(u64, u64)>; 3]) -> Option<usize> {
        let epochs = ranks.into_iter().enumerate();
        let state = State {
            settings: TrainingSettings {
                loss_over: over,
                ..TrainingSettings::default()
            },
            data_hash: String::new(),
            epoch: 3,
            batch: 0,
            updates: 0,
            loss_sum: 0.0,
            epochs: epochs.map(|(at, ranks)| report(at + 1, ranks)).collect(),
            training_s: 0.0,
        };
        state.best_epoch()
    }

    #[test]
    fn the_best_epoch_is_the_first_that_validation_likes_most_by_the_question_trained_for() {
        let ranks = [Some((50, 50)), Some((50, 0)), Some((0, 0))];
        assert_eq!(best(LossOver::Fitting, ranks), Some(2));
        assert_eq!(best(LossOver::All, ranks), Some(3));
        assert_eq!(best(LossOver::All, [None; 3]), None);
    }
}
