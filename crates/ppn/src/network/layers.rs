//! The layers of the network.

use tch::{TchError, Tensor};

use super::parameters::Parameters;

const MOMENTUM: f64 = 0.1;
const EPSILON: f64 = 1e-5;

/// Normalisation over the batch, per channel.
#[derive(Debug)]
pub(super) struct BatchNorm {
    scale: Tensor,
    shift: Tensor,
    mean: Tensor,
    variance: Tensor,
}

impl BatchNorm {
    /// Makes the normalisation of the layer of this name.
    fn of(parameters: &mut Parameters, layer: &str, channels: i64) -> Result<Self, TchError> {
        let name = |tensor: &str| format!("{layer}.normalisation.{tensor}");
        Ok(Self {
            scale: parameters.constant(&name("scale"), channels, 1.0)?,
            shift: parameters.constant(&name("shift"), channels, 0.0)?,
            mean: parameters.statistic(&name("mean"), channels, 0.0)?,
            variance: parameters.statistic(&name("variance"), channels, 1.0)?,
        })
    }

    fn forward(&self, input: &Tensor, training: bool) -> Result<Tensor, TchError> {
        input.f_batch_norm(
            Some(&self.scale),
            Some(&self.shift),
            Some(&self.mean),
            Some(&self.variance),
            training,
            MOMENTUM,
            EPSILON,
            true,
        )
    }

    /// Gives the factor and the offset of `factor * input + offset`, the same function per channel
    /// with the running statistics.
    fn affine(&self) -> Result<(Tensor, Tensor), TchError> {
        let deviation = self.variance.f_add_scalar(EPSILON)?;
        let factor = self.scale.f_mul(&deviation.f_rsqrt()?)?;
        let offset = self.shift.f_sub(&self.mean.f_mul(&factor)?)?;
        Ok((factor, offset))
    }
}

/// A 3 x 3 convolution, normalised.
#[derive(Debug)]
pub(super) struct Convolution {
    weight: Tensor,
    bias: Tensor,
    normalisation: Option<BatchNorm>,
}

impl Convolution {
    pub(super) fn new(
        parameters: &mut Parameters,
        name: &str,
        (inputs, outputs): (i64, i64),
    ) -> Result<Self, TchError> {
        let shape = [outputs, inputs, 3, 3];
        Ok(Self {
            weight: parameters.weight(&format!("{name}.weight"), &shape, inputs * 9)?,
            bias: parameters.constant(&format!("{name}.bias"), outputs, 0.0)?,
            normalisation: Some(BatchNorm::of(parameters, name, outputs)?),
        })
    }

    /// `[N, inputs, X, Y]` to `[N, outputs, X, Y]`.
    pub(super) fn forward(&self, input: &Tensor, training: bool) -> Result<Tensor, TchError> {
        let bias = Some(&self.bias);
        let output = input.f_conv2d(&self.weight, bias, [1, 1], [1, 1], [1, 1], 1)?;
        match &self.normalisation {
            Some(normalisation) => normalisation.forward(&output, training),
            None => Ok(output),
        }
    }

    /// The same function without a normalisation of its own, by the running statistics.
    pub(super) fn folded(&self) -> Result<Self, TchError> {
        let (mut weight, mut bias) = (self.weight.shallow_clone(), self.bias.shallow_clone());
        if let Some(normalisation) = &self.normalisation {
            let (factor, offset) = normalisation.affine()?;
            weight = weight.f_mul(&factor.f_view([-1, 1, 1, 1])?)?;
            bias = bias.f_mul(&factor)?.f_add(&offset)?;
        }
        Ok(Self {
            weight: weight.f_detach()?,
            bias: bias.f_detach()?,
            normalisation: None,
        })
    }
}

/// Normalises, then combines channels linearly: a 1 x 1 convolution.
///
/// Works on `[channels, M]`, all cells of all maps of a channel together: one matrix product.
#[derive(Debug)]
pub(super) struct Mixing {
    normalisation: Option<BatchNorm>,
    weight: Tensor,
    bias: Tensor,
}

impl Mixing {
    pub(super) fn new(
        parameters: &mut Parameters,
        name: &str,
        (inputs, outputs): (i64, i64),
    ) -> Result<Self, TchError> {
        let normalisation = BatchNorm::of(parameters, name, inputs)?;
        Ok(Self {
            normalisation: Some(normalisation),
            ..Self::plain(parameters, name, (inputs, outputs))?
        })
    }

    /// Without a normalisation.
    pub(super) fn plain(
        parameters: &mut Parameters,
        name: &str,
        (inputs, outputs): (i64, i64),
    ) -> Result<Self, TchError> {
        Ok(Self {
            normalisation: None,
            weight: parameters.weight(&format!("{name}.weight"), &[outputs, inputs], inputs)?,
            bias: parameters.constant(&format!("{name}.bias"), outputs, 0.0)?,
        })
    }

    /// `[inputs, M]` to `[outputs, M]`.
    pub(super) fn forward(&self, input: &Tensor, training: bool) -> Result<Tensor, TchError> {
        let bias = self.bias.f_unsqueeze(1)?;
        match &self.normalisation {
            Some(normalisation) => {
                let normalised = normalisation.forward(&input.f_unsqueeze(0)?, training)?;
                bias.f_addmm(&self.weight, &normalised.f_squeeze_dim(0)?)
            }
            None => bias.f_addmm(&self.weight, input),
        }
    }

    /// To one output: `[4, inputs, M]` to `[4, M]`, without normalisation.
    pub(super) fn forward_phases(&self, input: &Tensor) -> Result<Tensor, TchError> {
        let scores = self.weight.f_unsqueeze(0)?.f_expand([4, 1, -1], false)?;
        scores.f_bmm(input)?.f_squeeze_dim(1)?.f_add(&self.bias)
    }

    /// The same function without a normalisation of its own, by the running statistics.
    pub(super) fn folded(&self) -> Result<Self, TchError> {
        let (mut weight, mut bias) = (self.weight.shallow_clone(), self.bias.shallow_clone());
        if let Some(normalisation) = &self.normalisation {
            let (factor, offset) = normalisation.affine()?;
            bias = bias.f_add(&weight.f_mv(&offset)?)?;
            weight = weight.f_mul(&factor)?;
        }
        Ok(Self {
            normalisation: None,
            weight: weight.f_detach()?,
            bias: bias.f_detach()?,
        })
    }
}
