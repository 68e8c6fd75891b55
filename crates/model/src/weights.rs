//! Files of weights, checked before they are used.

use std::collections::{BTreeMap, HashMap};
use std::fmt::Display;
use std::path::Path;

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensorError, SafeTensors};

use crate::card::{FORMAT, ModelCard};

/// Maximum size of a weights' file that is read, in bytes: no network of this architecture comes
/// near.
const MAX_BYTES: u64 = 1 << 30;

/// Why a model cannot be used, with the file or the origin of the model, for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ModelError(String);

/// A tensor of weights, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct WeightTensor {
    /// Its dimensions.
    pub shape: Vec<usize>,
    /// Its values.
    pub values: Vec<f32>,
}

/// A model: checked weights and their card.
#[derive(Debug, Clone)]
pub struct Model {
    origin: String,
    card: ModelCard,
    tensors: BTreeMap<String, WeightTensor>,
}

impl Model {
    /// Reads a model: a `.safetensors` file and the `.json` card of the same name beside it.
    ///
    /// # Errors
    /// [`ModelError`] where one of them cannot be read or they do not belong together.
    pub fn read(weights: &Path) -> Result<Self, ModelError> {
        let card_path = weights.with_extension("json");
        let read = |path: &Path| {
            let with = "a model is a .safetensors file with its .json card beside it";
            let unread = |error| {
                ModelError(format!(
                    "{} cannot be read: {error}; {with}",
                    path.display()
                ))
            };
            std::fs::read(path).map_err(unread)
        };
        let bytes = std::fs::metadata(weights).map_or(0, |metadata| metadata.len());
        if bytes > MAX_BYTES {
            return Err(ModelError(format!(
                "{} has {bytes} bytes, too many for weights of a placement proposal network",
                weights.display()
            )));
        }
        let (weights_bytes, card_bytes) = (read(weights)?, read(&card_path)?);
        let card = card(&card_path.display(), &card_bytes)?;
        Self::new(&weights.display().to_string(), &weights_bytes, card)
    }

    /// Reads the model that ships with this software.
    ///
    /// # Errors
    /// [`ModelError`] where it was damaged before it was built in.
    pub fn shipped() -> Result<Self, ModelError> {
        let origin = "the shipped model";
        let card = card(&origin, include_bytes!("../shipped/ppn.json"))?;
        Self::new(origin, include_bytes!("../shipped/ppn.safetensors"), card)
    }

    /// Makes a model from its parts; `origin` names it in errors.
    ///
    /// # Errors
    /// [`ModelError`] where the parts do not belong together.
    pub fn new(origin: &str, weights: &[u8], card: ModelCard) -> Result<Self, ModelError> {
        let wrong = |why: String| ModelError(format!("{origin}: {why}"));
        if card.format != FORMAT {
            return Err(wrong(format!(
                "the model has format {}, but this version reads {FORMAT}; train it again",
                card.format
            )));
        }
        let valid = card.architecture.validate();
        valid.map_err(|error| wrong(error.to_string()))?;
        let found = blake3::hash(weights).to_hex().to_string();
        if found != card.weights_blake3 {
            return Err(wrong(format!(
                "the weights' hash is {found}, but the card says {}: the file is damaged, or not the card's; fetch both again",
                card.weights_blake3
            )));
        }
        Ok(Self {
            origin: origin.to_owned(),
            card,
            tensors: tensors(origin, weights)?,
        })
    }

    /// Names the origin of the model, for messages.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// Gives the model's card.
    pub fn card(&self) -> &ModelCard {
        &self.card
    }

    /// Gives the weights by name.
    pub fn tensors(&self) -> &BTreeMap<String, WeightTensor> {
        &self.tensors
    }
}

fn card(path: &dyn Display, bytes: &[u8]) -> Result<ModelCard, ModelError> {
    let card = serde_json::from_slice(bytes);
    card.map_err(|error| ModelError(format!("{path} is no model card: {error}")))
}

/// Reads named tensors of finite 32-bit floats from the bytes of a `.safetensors` file.
///
/// # Errors
/// [`ModelError`] where the bytes are damaged or hold something else.
pub fn tensors(origin: &str, bytes: &[u8]) -> Result<BTreeMap<String, WeightTensor>, ModelError> {
    let damaged = |error| ModelError(format!("{origin}: the weights are damaged: {error}"));
    let file = SafeTensors::deserialize(bytes).map_err(damaged)?;
    let mut tensors = BTreeMap::new();
    for (name, view) in file.iter() {
        if view.dtype() != Dtype::F32 {
            let why = format!("{origin}: tensor {name} is not of 32-bit floats");
            return Err(ModelError(why));
        }
        let (values, _) = view.data().as_chunks();
        let values: Vec<f32> = values.iter().copied().map(f32::from_le_bytes).collect();
        if values.iter().any(|value| !value.is_finite()) {
            let why = format!("{origin}: tensor {name} has a value that is not finite");
            return Err(ModelError(why));
        }
        let shape = view.shape().to_vec();
        tensors.insert(name.to_owned(), WeightTensor { shape, values });
    }
    Ok(tensors)
}

/// Gives the bytes of a `.safetensors` file of named tensors, with a named text beside them where
/// one is given.
///
/// # Errors
/// [`SafeTensorError`] for names and shapes that the format does not allow.
pub fn to_bytes(
    tensors: &BTreeMap<String, WeightTensor>,
    text: Option<(&str, String)>,
) -> Result<Vec<u8>, SafeTensorError> {
    let bytes = tensors.values().map(|tensor| {
        let values = tensor.values.iter();
        values.flat_map(|value| value.to_le_bytes()).collect()
    });
    let bytes: Vec<Vec<u8>> = bytes.collect();
    let views = tensors.iter().zip(&bytes).map(|((name, tensor), bytes)| {
        let view = TensorView::new(Dtype::F32, tensor.shape.clone(), bytes)?;
        Ok((name, view))
    });
    let views = views.collect::<Result<Vec<_>, SafeTensorError>>()?;
    let text = text.map(|(name, text)| HashMap::from([(name.to_owned(), text)]));
    safetensors::serialize(views, text)
}
