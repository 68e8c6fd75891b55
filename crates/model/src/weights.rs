//! Files of weights, checked before they are used.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use safetensors::{Dtype, SafeTensors};

use crate::architecture::ArchitectureError;
use crate::card::{FORMAT, ModelCard};

/// Weights above this are refused unread: no network of this architecture comes near.
const MAX_BYTES: u64 = 1 << 30;

/// Why a model cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A file cannot be read.
    #[error("{} cannot be read: {source}; a model is a .safetensors file with its .json card beside it", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        source: std::io::Error,
    },
    /// The weights' file is larger than any network.
    #[error("{} has {bytes} bytes, too many for weights of a placement proposal network", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
    },
    /// The card is no model card.
    #[error("{} is no model card: {source}", path.display())]
    Card {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// The card has another form than this version reads.
    #[error(
        "{origin}: the model has format {found}, but this version reads {FORMAT}; train it again"
    )]
    Format {
        /// Where the model is from.
        origin: String,
        /// The card's format.
        found: u32,
    },
    /// The card names a network that cannot be built.
    #[error("{origin}: {source}")]
    Architecture {
        /// Where the model is from.
        origin: String,
        /// What is wrong.
        source: ArchitectureError,
    },
    /// The weights are not those that the card was written for.
    #[error(
        "{origin}: the weights' hash is {found}, but the card says {expected}: the file is damaged, or not the card's; \
         fetch both again"
    )]
    Hash {
        /// Where the model is from.
        origin: String,
        /// The card's hash.
        expected: String,
        /// The file's hash.
        found: String,
    },
    /// The weights' file is damaged.
    #[error("{origin}: the weights are damaged: {source}")]
    Weights {
        /// Where the model is from.
        origin: String,
        /// What is wrong.
        source: safetensors::SafeTensorError,
    },
    /// A tensor is not of 32-bit floats.
    #[error("{origin}: tensor {tensor} is not of 32-bit floats")]
    Kind {
        /// Where the model is from.
        origin: String,
        /// The tensor.
        tensor: String,
    },
    /// A weight is not a number.
    #[error("{origin}: tensor {tensor} has a value that is not finite")]
    NotFinite {
        /// Where the model is from.
        origin: String,
        /// The tensor.
        tensor: String,
    },
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
            std::fs::read(path).map_err(|source| ModelError::Read {
                path: path.to_owned(),
                source,
            })
        };
        let bytes = std::fs::metadata(weights).map_or(0, |metadata| metadata.len());
        if bytes > MAX_BYTES {
            let path = weights.to_owned();
            return Err(ModelError::TooLarge { path, bytes });
        }
        let (weights_bytes, card_bytes) = (read(weights)?, read(&card_path)?);
        let card = serde_json::from_slice(&card_bytes).map_err(|source| ModelError::Card {
            path: card_path,
            source,
        })?;
        Self::new(&weights.display().to_string(), &weights_bytes, card)
    }

    /// The model that ships with this software.
    ///
    /// # Errors
    /// [`ModelError`] where it was damaged before it was built in.
    pub fn shipped() -> Result<Self, ModelError> {
        let card = include_bytes!("../shipped/ppn.json");
        let card = serde_json::from_slice(card).map_err(|source| ModelError::Card {
            path: "the shipped model".into(),
            source,
        })?;
        let weights = include_bytes!("../shipped/ppn.safetensors");
        Self::new("the shipped model", weights, card)
    }

    /// A model from its parts; `origin` names it in errors.
    ///
    /// # Errors
    /// [`ModelError`] where the parts do not belong together.
    pub fn new(origin: &str, weights: &[u8], card: ModelCard) -> Result<Self, ModelError> {
        let origin = origin.to_owned();
        if card.format != FORMAT {
            let found = card.format;
            return Err(ModelError::Format { origin, found });
        }
        if let Err(source) = card.architecture.validate() {
            return Err(ModelError::Architecture { origin, source });
        }
        let found = blake3::hash(weights).to_hex().to_string();
        if found != card.weights_blake3 {
            let expected = card.weights_blake3;
            return Err(ModelError::Hash {
                origin,
                expected,
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

    /// Where the model is from, for messages.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// The model's card.
    pub fn card(&self) -> &ModelCard {
        &self.card
    }

    /// The weights by name.
    pub fn tensors(&self) -> &BTreeMap<String, WeightTensor> {
        &self.tensors
    }
}

/// Reads named tensors of finite 32-bit floats from the bytes of a `.safetensors` file.
///
/// # Errors
/// [`ModelError`] where the bytes are damaged or hold something else.
pub fn tensors(origin: &str, bytes: &[u8]) -> Result<BTreeMap<String, WeightTensor>, ModelError> {
    let file = SafeTensors::deserialize(bytes).map_err(|source| ModelError::Weights {
        origin: origin.to_owned(),
        source,
    })?;
    let mut tensors = BTreeMap::new();
    for (name, view) in file.iter() {
        if view.dtype() != Dtype::F32 {
            return Err(ModelError::Kind {
                origin: origin.to_owned(),
                tensor: name.to_owned(),
            });
        }
        let values = view.data().chunks_exact(4);
        let values: Vec<f32> = values
            .filter_map(|bytes| Some(f32::from_le_bytes(bytes.try_into().ok()?)))
            .collect();
        if values.iter().any(|value| !value.is_finite()) {
            return Err(ModelError::NotFinite {
                origin: origin.to_owned(),
                tensor: name.to_owned(),
            });
        }
        let shape = view.shape().to_vec();
        tensors.insert(name.to_owned(), WeightTensor { shape, values });
    }
    Ok(tensors)
}

/// The bytes of a `.safetensors` file of named tensors, with a named text beside them where one is given.
///
/// # Errors
/// What the format does not allow.
pub fn to_bytes(
    tensors: &BTreeMap<String, WeightTensor>,
    text: Option<(&str, String)>,
) -> Result<Vec<u8>, safetensors::SafeTensorError> {
    let bytes: BTreeMap<&String, Vec<u8>> = tensors
        .iter()
        .map(|(name, tensor)| {
            let values = tensor.values.iter().flat_map(|value| value.to_le_bytes());
            (name, values.collect())
        })
        .collect();
    let views = tensors.iter().filter_map(|(name, tensor)| {
        let data = bytes.get(name)?;
        Some((name, tensor.shape.clone(), data))
    });
    let views = views
        .map(|(name, shape, data)| {
            let view = safetensors::tensor::TensorView::new(Dtype::F32, shape, data)?;
            Ok((name, view))
        })
        .collect::<Result<Vec<_>, safetensors::SafeTensorError>>()?;
    let text = text.map(|(name, text)| HashMap::from([(name.to_owned(), text)]));
    safetensors::serialize(views, text)
}
