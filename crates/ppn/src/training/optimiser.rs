//! AdamW, and the schedules of its learning rate.

use std::collections::BTreeMap;

use ppnpack_model::settings::Schedule;
use tch::{TchError, Tensor};

use crate::network::Parameters;

const DECAY_OF_MEAN: f64 = 0.9;
const DECAY_OF_SQUARE: f64 = 0.999;
const EPSILON: f64 = 1e-8;
/// The part of all batches in which the learning rate rises.
const RISING_SHARE: f64 = 0.03;

/// AdamW (Loshchilov and Hutter, 2019); its state is plain, so that a checkpoint can hold it;
/// the optimisers of `tch` do not give theirs away.
#[derive(Debug)]
pub(crate) struct AdamW {
    /// The state by the parameters' names.
    pub(crate) moments: BTreeMap<String, Moments>,
    weight_decay: f64,
    /// How often it changed the parameters.
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
        let moments = parameters.trained().map(|(name, tensor)| {
            let (mean, square) = (tensor.f_zeros_like()?, tensor.f_zeros_like()?);
            Ok((name.clone(), Moments { mean, square }))
        });
        Ok(Self {
            moments: moments.collect::<Result<_, TchError>>()?,
            weight_decay,
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
        let count = self.updates as f64;
        let of_mean = 1.0 - DECAY_OF_MEAN.powf(count);
        let of_square = 1.0 - DECAY_OF_SQUARE.powf(count);
        tch::no_grad(|| {
            for (name, tensor) in parameters.trained() {
                let gradient = tensor.f_grad()?;
                let Some(moments) = self.moments.get_mut(name) else {
                    continue;
                };
                if !gradient.defined() {
                    continue;
                }
                let Moments { mean, square } = moments;
                *mean = mean.f_lerp_(&gradient, 1.0 - DECAY_OF_MEAN)?;
                let addition = gradient.f_square()?.f_mul_scalar(1.0 - DECAY_OF_SQUARE)?;
                *square = square.f_mul_scalar_(DECAY_OF_SQUARE)?.f_add_(&addition)?;
                let deviation = square.f_div_scalar(of_square)?.f_sqrt()?;
                let change = mean.f_div(&deviation.f_add_scalar(EPSILON)?)?;
                // Biases and normalisation are not decayed.
                let is_decayed = tensor.dim() > 1;
                let decay = if is_decayed { self.weight_decay } else { 0.0 };
                let change = change.f_mul_scalar(learning_rate / of_mean)?;
                let mut tensor = tensor.shallow_clone();
                tensor = tensor.f_mul_scalar_(1.0 - learning_rate * decay)?;
                drop(tensor.f_sub_(&change)?);
                drop(gradient.shallow_clone().f_zero_()?);
            }
            Ok(())
        })
    }
}

/// The learning rate of a batch, counted from 0 over all epochs.
pub(crate) fn learning_rate(schedule: Schedule, peak: f64, batch: u64, batches: u64) -> f64 {
    match schedule {
        Schedule::Constant => peak,
        Schedule::WarmUpAndCosine => warm_up_and_cosine(peak, batch, batches),
    }
}

/// It rises linearly to `peak`, then falls to 0 as a cosine.
fn warm_up_and_cosine(peak: f64, batch: u64, batches: u64) -> f64 {
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
