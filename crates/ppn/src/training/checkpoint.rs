//! Checkpoints: everything that a training needs to go on as if it had not been interrupted.

use std::path::{Path, PathBuf};

use ppnpack_files::write_whole;
use ppnpack_model::report::EpochReport;
use ppnpack_model::settings::TrainingSettings;
use ppnpack_model::weights::{tensors, to_bytes};
use safetensors::SafeTensors;
use serde::{Deserialize, Serialize};

use super::optimiser::AdamW;
use crate::error::NetworkError;
use crate::files::{all_to_plain, copy_into};
use crate::network::Parameters;

const STATE: &str = "state";

/// The file of a training's checkpoint.
pub const CHECKPOINT_FILE: &str = "checkpoint.safetensors";

/// Where a training is.
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

pub(crate) fn path(folder: &Path) -> PathBuf {
    folder.join(CHECKPOINT_FILE)
}

/// Writes a checkpoint in place of the last.
pub(crate) fn save(
    folder: &Path,
    state: &State,
    parameters: &Parameters,
    optimiser: &AdamW,
) -> Result<(), NetworkError> {
    let path = path(folder);
    let weights = parameters.tensors().iter();
    let weights = weights.map(|(name, tensor)| (format!("weight/{name}"), tensor));
    let moments = optimiser.moments.iter().flat_map(|(name, moments)| {
        let mean = (format!("mean/{name}"), &moments.mean);
        [mean, (format!("square/{name}"), &moments.square)]
    });
    let tensors = all_to_plain(weights.chain(moments))?;
    let text = serde_json::to_string(state).map_err(|error| damaged(&path, &error))?;
    let bytes = to_bytes(&tensors, Some((STATE, text)))?;
    Ok(write_whole(&path, &bytes)?)
}

/// Takes a checkpoint's tensors over, and gives its state.
pub(crate) fn load(
    folder: &Path,
    expected: &State,
    parameters: &Parameters,
    optimiser: &mut AdamW,
) -> Result<State, NetworkError> {
    let path = path(folder);
    let bytes = std::fs::read(&path).map_err(|source| NetworkError::Read {
        path: path.clone(),
        source,
    })?;
    let (_, header) = SafeTensors::read_metadata(&bytes).map_err(|error| damaged(&path, &error))?;
    let texts = header.metadata().as_ref();
    let text = texts.and_then(|texts| texts.get(STATE));
    let text = text.ok_or_else(|| damaged(&path, &"it has no state"))?;
    let state: State = serde_json::from_str(text).map_err(|error| damaged(&path, &error))?;
    if let Some(difference) = difference(&state, expected) {
        return Err(NetworkError::OtherTraining { path, difference });
    }
    let origin = path.display().to_string();
    let kept = tensors(&origin, &bytes).map_err(|error| damaged(&path, &error))?;
    let take = |name: String, tensor| match kept.get(&name) {
        Some(values) => copy_into(&origin, &name, values, tensor),
        None => Err(damaged(&path, &format_args!("it has no tensor {name}"))),
    };
    for (name, tensor) in parameters.tensors() {
        take(format!("weight/{name}"), tensor)?;
    }
    for (name, moments) in &optimiser.moments {
        take(format!("mean/{name}"), &moments.mean)?;
        take(format!("square/{name}"), &moments.square)?;
    }
    optimiser.updates = state.updates;
    Ok(state)
}

/// What keeps one training's checkpoint from being another's.
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
    NetworkError::Checkpoint {
        path: path.to_owned(),
        what: what.to_string(),
    }
}
