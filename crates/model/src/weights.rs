//! Files of weights, checked before they are used.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensorError, SafeTensors};

use crate::architecture::ArchitectureError;
use crate::card::{FORMAT, ModelCard};

/// Maximum size of a weights' file that is read, in bytes: no network of this architecture comes
/// near.
const MAX_BYTES: u64 = 1 << 30;

/// A model that cannot be used; each fault comes with the file or the origin of the model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A file that cannot be read.
    #[error("{} cannot be read: {1}; a model is a .safetensors file with its .json card beside it", .0.display())]
    Read(PathBuf, #[source] std::io::Error),
    /// A file of weights that is larger than any network, with its bytes.
    #[error("{} has {1} bytes, too many for weights of a placement proposal network", .0.display())]
    TooLarge(PathBuf, u64),
    /// A card that is no model card.
    #[error("{} is no model card: {1}", .0.display())]
    Card(PathBuf, #[source] serde_json::Error),
    /// A card of another format than this version reads.
    #[error("{0}: the model has format {1}, but this version reads {FORMAT}; train it again")]
    Format(String, u32),
    /// A card that names a network that cannot be built.
    #[error("{0}: {1}")]
    Architecture(String, #[source] ArchitectureError),
    /// Weights with another hash than the card says.
    #[error(
        "{origin}: the weights' hash is {found}, but the card says {expected}: the file is damaged, or not the card's; \
         fetch both again"
    )]
    Hash {
        /// The origin of the model.
        origin: String,
        /// The card's hash.
        expected: String,
        /// The file's hash.
        found: String,
    },
    /// Damaged weights.
    #[error("{0}: the weights are damaged: {1}")]
    Weights(String, #[source] SafeTensorError),
    /// A tensor, by name, that is not of 32-bit floats.
    #[error("{0}: tensor {1} is not of 32-bit floats")]
    Kind(String, String),
    /// A tensor, by name, with a value that is no number.
    #[error("{0}: tensor {1} has a value that is not finite")]
    NotFinite(String, String),
}

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
            std::fs::read(path).map_err(|error| ModelError::Read(path.to_owned(), error))
        };
        let bytes = std::fs::metadata(weights).map_or(0, |metadata| metadata.len());
        if bytes > MAX_BYTES {
            return Err(ModelError::TooLarge(weights.to_owned(), bytes));
        }
        let (weights_bytes, card_bytes) = (read(weights)?, read(&card_path)?);
        let no_card = |error| ModelError::Card(card_path, error);
        let card = serde_json::from_slice(&card_bytes).map_err(no_card)?;
        Self::new(&weights.display().to_string(), &weights_bytes, card)
    }

    /// Reads the model that ships with this software.
    ///
    /// # Errors
    /// [`ModelError`] where it was damaged before it was built in.
    pub fn shipped() -> Result<Self, ModelError> {
        let origin = "the shipped model";
        let no_card = |error| ModelError::Card(origin.into(), error);
        let card = serde_json::from_slice(include_bytes!("../shipped/ppn.json"));
        let weights = include_bytes!("../shipped/ppn.safetensors");
        Self::new(origin, weights, card.map_err(no_card)?)
    }

    /// Makes a model from its parts; `origin` names it in errors.
    ///
    /// # Errors
    /// [`ModelError`] where the parts do not belong together.
    pub fn new(origin: &str, weights: &[u8], card: ModelCard) -> Result<Self, ModelError> {
        let origin = origin.to_owned();
        if card.format != FORMAT {
            return Err(ModelError::Format(origin, card.format));
        }
        if let Err(error) = card.architecture.validate() {
            return Err(ModelError::Architecture(origin, error));
        }
        let found = blake3::hash(weights).to_hex().to_string();
        if found != card.weights_blake3 {
            return Err(ModelError::Hash {
                origin,
                expected: card.weights_blake3,
                found,
            });
        }
        let tensors = tensors(&origin, weights)?;
        Ok(Self {
            origin,
            card,
            tensors,
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

/// Reads named tensors of finite 32-bit floats from the bytes of a `.safetensors` file.
///
/// # Errors
/// [`ModelError`] where the bytes are damaged or hold something else.
pub fn tensors(origin: &str, bytes: &[u8]) -> Result<BTreeMap<String, WeightTensor>, ModelError> {
    let damaged = |error| ModelError::Weights(origin.to_owned(), error);
    let file = SafeTensors::deserialize(bytes).map_err(damaged)?;
    let mut tensors = BTreeMap::new();
    for (name, view) in file.iter() {
        if view.dtype() != Dtype::F32 {
            return Err(ModelError::Kind(origin.to_owned(), name.to_owned()));
        }
        let (values, _) = view.data().as_chunks();
        let values: Vec<f32> = values.iter().copied().map(f32::from_le_bytes).collect();
        if values.iter().any(|value| !value.is_finite()) {
            return Err(ModelError::NotFinite(origin.to_owned(), name.to_owned()));
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
