//! AdamW, and the schedules of its learning rate.

use std::borrow::Borrow;
use std::collections::BTreeMap;

use ppnpack_model::settings::Schedule;
use tch::{TchError, Tensor};

use crate::network::Parameters;

const DECAY_OF_MEAN: f64 = 0.9;
const DECAY_OF_SQUARE: f64 = 0.999;
const EPSILON: f64 = 1e-8;
/// Share of all batches in which the learning rate rises.
const RISING_SHARE: f64 = 0.03;

/// AdamW (Loshchilov and Hutter, 2019); its state is plain, so that a checkpoint can hold it; the
/// optimisers of `tch` do not give theirs away. All parameters are changed as one long vector: a
/// step of one operation per parameter is most of a small network's time on a graphics processor.
#[derive(Debug)]
pub(crate) struct AdamW {
    /// The state by the parameters' names: views of `all`.
    pub(crate) moments: BTreeMap<String, Moments>,
    all: Moments,
    /// The decay of each weight; biases and normalisation are not decayed.
    decay: Tensor,
    /// Number of weights of each parameter, by the order of the names.
    sizes: Vec<i64>,
    /// Number of changes of the parameters.
    pub(crate) updates: u64,
}

/// Running means of a gradient and of its square.
#[derive(Debug)]
pub(crate) struct Moments {
    pub(crate) mean: Tensor,
    pub(crate) square: Tensor,
}

impl AdamW {
    pub(crate) fn new(parameters: &Parameters, weight_decay: f64) -> Result<Self, TchError> {
        let trained: Vec<&Tensor> = parameters.trained().map(|(_, tensor)| tensor).collect();
        let sizes: Vec<i64> = trained.iter().map(|tensor| tensor.numel() as i64).collect();
        let decays = trained.iter().map(|tensor| {
            let is_decayed = tensor.dim() > 1;
            tensor.f_full_like(if is_decayed { weight_decay } else { 0.0 })
        });
        let decays: Vec<Tensor> = decays.collect::<Result<_, _>>()?;
        let decay = as_vector(&decays)?.f_detach()?;
        let all = Moments {
            mean: decay.f_zeros_like()?,
            square: decay.f_zeros_like()?,
        };
        let means = all.mean.f_split_with_sizes(&sizes[..], 0)?;
        let squares = all.square.f_split_with_sizes(&sizes[..], 0)?;
        let pieces = parameters.trained().zip(means.iter().zip(&squares));
        let moments = pieces.map(|((name, tensor), (mean, square))| {
            let (mean, square) = (mean.f_view_as(tensor)?, square.f_view_as(tensor)?);
            Ok((name.clone(), Moments { mean, square }))
        });
        Ok(Self {
            moments: moments.collect::<Result<_, TchError>>()?,
            all,
            decay,
            sizes,
            updates: 0,
        })
    }

    /// Changes the parameters by their gradients, and forgets those.
    pub(crate) fn update(
        &mut self,
        parameters: &Parameters,
        learning_rate: f64,
    ) -> Result<(), TchError> {
        self.updates += 1;
        tch::no_grad(|| {
            let trained: Vec<&Tensor> = parameters.trained().map(|(_, tensor)| tensor).collect();
            let gradients: Vec<Tensor> = trained.iter().map(gradient).collect::<Result<_, _>>()?;
            let change = self.change(&as_vector(&gradients)?, learning_rate)?;
            let kept = self.decay.f_mul_scalar(-learning_rate)?.f_add_scalar(1.0)?;
            let changed = as_vector(&trained)?.f_mul_(&kept)?.f_sub_(&change)?;
            let changed = changed.f_split_with_sizes(&self.sizes[..], 0)?;
            for (tensor, changed) in trained.iter().zip(changed) {
                tensor
                    .shallow_clone()
                    .f_copy_(&changed.f_view_as(tensor)?)?;
            }
            for mut gradient in gradients {
                drop(gradient.f_zero_()?);
            }
            Ok(())
        })
    }

    /// Gives the change that this gradient takes off the weights, beside their decay.
    fn change(&mut self, gradient: &Tensor, learning_rate: f64) -> Result<Tensor, TchError> {
        let count = self.updates as f64;
        let of_mean = 1.0 - DECAY_OF_MEAN.powf(count);
        let of_square = 1.0 - DECAY_OF_SQUARE.powf(count);
        let Moments { mean, square } = &mut self.all;
        drop(mean.f_lerp_(gradient, 1.0 - DECAY_OF_MEAN)?);
        let addition = gradient.f_square()?.f_mul_scalar(1.0 - DECAY_OF_SQUARE)?;
        drop(square.f_mul_scalar_(DECAY_OF_SQUARE)?.f_add_(&addition)?);
        let deviation = square.f_div_scalar(of_square)?.f_sqrt()?;
        let change = mean.f_div(&deviation.f_add_scalar(EPSILON)?)?;
        change.f_mul_scalar(learning_rate / of_mean)
    }
}

/// Gives the gradient of a parameter; zeros where nothing has depended on it.
fn gradient(parameter: &&Tensor) -> Result<Tensor, TchError> {
    let gradient = parameter.f_grad()?;
    if gradient.defined() {
        Ok(gradient)
    } else {
        parameter.f_zeros_like()
    }
}

/// Joins all values in one row.
fn as_vector<T: Borrow<Tensor>>(tensors: &[T]) -> Result<Tensor, TchError> {
    let rows = tensors
        .iter()
        .map(|tensor| tensor.borrow().f_flatten(0, -1));
    let rows: Vec<Tensor> = rows.collect::<Result<_, _>>()?;
    Tensor::f_cat(&rows, 0)
}

/// Gives the learning rate of a batch, counted from 0 over all epochs.
pub(crate) fn learning_rate(schedule: Schedule, peak: f64, batch: u64, batches: u64) -> f64 {
    if schedule == Schedule::Constant {
        return peak;
    }
    let (at, all) = (batch as f64 + 1.0, batches.max(1) as f64);
    let rising = (all * RISING_SHARE).max(1.0);
    if at <= rising {
        return peak * at / rising;
    }
    let fallen = (at - rising) / (all - rising).max(1.0);
    peak * 0.5 * (1.0 + (std::f64::consts::PI * fallen).cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_learning_rate_rises_and_falls() {
        let rates: Vec<f64> = (0..100)
            .map(|batch| learning_rate(Schedule::WarmUpAndCosine, 1.0, batch, 100))
            .collect();
        assert!((rates[0] - 1.0 / 3.0).abs() < 1e-9 && (rates[2] - 1.0).abs() < 1e-9);
        assert!(rates[2..].windows(2).all(|pair| pair[1] < pair[0]));
        assert!(rates[99].abs() < 1e-9);
        let mut constant = (0..100).map(|batch| learning_rate(Schedule::Constant, 0.5, batch, 100));
        assert!(constant.all(|rate| rate == 0.5));
    }
}
