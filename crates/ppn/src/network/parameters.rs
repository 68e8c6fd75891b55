//! The named tensors of a network.

use std::collections::BTreeMap;

use tch::{Device, Kind, TchError, Tensor};

/// Named tensors: those that training changes by gradients, and the running statistics.
#[derive(Debug)]
pub(crate) struct Parameters {
    device: Device,
    tensors: BTreeMap<String, Tensor>,
}

impl Parameters {
    pub(crate) fn new(device: Device) -> Self {
        Self {
            device,
            tensors: BTreeMap::new(),
        }
    }

    /// Adds a weight with uniformly distributed values for layers of `inputs` inputs (He et al.,
    /// 2015).
    pub(super) fn weight(
        &mut self,
        name: &str,
        shape: &[i64],
        inputs: i64,
    ) -> Result<Tensor, TchError> {
        let bound = (6.0 / inputs.max(1) as f64).sqrt();
        let tensor = Tensor::f_empty(shape, (Kind::Float, self.device))?;
        let tensor = tch::no_grad(|| tensor.shallow_clone().f_uniform_(-bound, bound))?;
        Ok(self.add(name, tensor.f_set_requires_grad(true)?))
    }

    /// Adds a trained vector of one value.
    pub(super) fn constant(
        &mut self,
        name: &str,
        length: i64,
        value: f64,
    ) -> Result<Tensor, TchError> {
        let tensor = Tensor::f_full([length], value, (Kind::Float, self.device))?;
        Ok(self.add(name, tensor.f_set_requires_grad(true)?))
    }

    /// Adds a vector of one value that gradients do not change.
    pub(super) fn statistic(
        &mut self,
        name: &str,
        length: i64,
        value: f64,
    ) -> Result<Tensor, TchError> {
        let tensor = Tensor::f_full([length], value, (Kind::Float, self.device))?;
        Ok(self.add(name, tensor))
    }

    fn add(&mut self, name: &str, tensor: Tensor) -> Tensor {
        self.tensors.insert(name.to_owned(), tensor.shallow_clone());
        tensor
    }

    pub(crate) fn tensors(&self) -> &BTreeMap<String, Tensor> {
        &self.tensors
    }

    /// Gives the tensors that gradients change, by name.
    pub(crate) fn trained(&self) -> impl Iterator<Item = (&String, &Tensor)> {
        let tensors = self.tensors.iter();
        tensors.filter(|(_, tensor)| tensor.requires_grad())
    }
}
