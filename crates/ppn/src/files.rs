//! Files of tensors.

use std::collections::BTreeMap;

use ppnpack_model::weights::{Model, WeightTensor};
use tch::{Device, Kind, TchError, Tensor};

use crate::error::NetworkError;
use crate::network::Network;

/// Copies a tensor's values to plain memory.
fn to_plain(tensor: &Tensor) -> Result<WeightTensor, TchError> {
    let flat = tensor
        .f_detach()?
        .f_to(Device::Cpu)?
        .f_to_kind(Kind::Float)?
        .f_contiguous()?
        .f_view(-1)?;
    Ok(WeightTensor {
        shape: tensor.size().iter().map(|side| *side as usize).collect(),
        values: Vec::try_from(flat)?,
    })
}

/// Copies named tensors to plain memory.
pub(crate) fn all_to_plain<'a, Name: Into<String>>(
    tensors: impl IntoIterator<Item = (Name, &'a Tensor)>,
) -> Result<BTreeMap<String, WeightTensor>, TchError> {
    let plain = |(name, tensor): (Name, _)| Ok((name.into(), to_plain(tensor)?));
    tensors.into_iter().map(plain).collect()
}

/// Makes the network of a model, whose weights must be those of its architecture.
pub(crate) fn network_of(model: &Model, device: Device) -> Result<Network, NetworkError> {
    let (network, parameters) = Network::new(&model.card().architecture, device)?;
    let (origin, given) = (model.origin(), model.tensors());
    for (name, tensor) in parameters.tensors() {
        let missing = || {
            NetworkError::Other(format!(
                "{origin}: the weights have no tensor {name}; they belong to another architecture"
            ))
        };
        copy_into(origin, name, given.get(name).ok_or_else(missing)?, tensor)?;
    }
    let is_unknown = |name: &&String| !parameters.tensors().contains_key(*name);
    match given.keys().find(is_unknown) {
        None => Ok(network),
        Some(name) => Err(NetworkError::Other(format!(
            "{origin}: the architecture has no tensor {name}; the weights belong to another one"
        ))),
    }
}

/// Takes values over into a tensor of the network; they must have its shape.
pub(crate) fn copy_into(
    origin: &str,
    name: &str,
    values: &WeightTensor,
    tensor: &Tensor,
) -> Result<(), NetworkError> {
    let found: Vec<i64> = values.shape.iter().map(|side| *side as i64).collect();
    if found != tensor.size() {
        return Err(NetworkError::Other(format!(
            "{origin}: tensor {name} has shape {found:?}, but the architecture needs {:?}",
            tensor.size()
        )));
    }
    let source = Tensor::f_from_slice(&values.values)?.f_view(found.as_slice())?;
    tch::no_grad(|| tensor.shallow_clone().f_copy_(&source))?;
    Ok(())
}
