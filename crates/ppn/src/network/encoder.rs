//! The encoders: heightmaps to features at several resolutions.

use tch::{TchError, Tensor};

use ppnpack_model::architecture::Architecture;

use super::layers::Convolution;
use super::parameters::Parameters;

/// Blocks of two 3 x 3 convolutions and a 2 x 2 maximum pool.
#[derive(Debug)]
pub(super) struct Encoder {
    blocks: Vec<[Convolution; 2]>,
}

impl Encoder {
    pub(super) fn new(
        parameters: &mut Parameters,
        name: &str,
        inputs: i64,
        architecture: &Architecture,
    ) -> Result<Self, TchError> {
        let mut blocks = Vec::new();
        let mut channels = inputs;
        for (level, width) in architecture.widths.iter().enumerate() {
            let width = *width as i64;
            let mut convolution = |number: usize, inputs: i64| {
                let name = format!("{name}.{level}.{number}");
                Convolution::new(parameters, &name, (inputs, width))
            };
            blocks.push([convolution(0, channels)?, convolution(1, width)?]);
            channels = width;
        }
        Ok(Self { blocks })
    }

    /// `[N, inputs, X, Y]` to `[N, widths[i], X / 2^(i+1), Y / 2^(i+1)]` per block. Where a mask
    /// `[N, 1, X, Y]` is given, features outside of it are 0 at every layer, so that they do not
    /// depend on the canvas around it.
    pub(super) fn forward(
        &self,
        input: &Tensor,
        mask: Option<&Tensor>,
        training: bool,
    ) -> Result<Vec<Tensor>, TchError> {
        let mut mask = mask.map(Tensor::shallow_clone);
        let mut features: Vec<Tensor> = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let mut current = features.last().unwrap_or(input).shallow_clone();
            for convolution in block {
                current = convolution.forward(&current, training)?.f_relu_()?;
                if let Some(mask) = &mask {
                    current = current.f_mul(mask)?;
                }
            }
            features.push(halved(&current)?);
            mask = mask.as_ref().map(halved).transpose()?;
        }
        Ok(features)
    }

    pub(super) fn folded(&self) -> Result<Self, TchError> {
        let fold = |[first, second]: &[Convolution; 2]| Ok([first.folded()?, second.folded()?]);
        let blocks = self.blocks.iter().map(fold);
        Ok(Self {
            blocks: blocks.collect::<Result<_, TchError>>()?,
        })
    }
}

/// Half the resolution: the greatest of each 2 x 2 cells.
pub(super) fn halved(input: &Tensor) -> Result<Tensor, TchError> {
    input.f_max_pool2d([2, 2], [2, 2], [0, 0], [1, 1], false)
}
