//! The decoder: fused features back to a score per cell.

use tch::{TchError, Tensor};

use ppnpack_model::architecture::{Architecture, Finest, Normalisation};

use super::fusion::fused_width;
use super::layers::Mixing;
use super::parameters::Parameters;

/// Channels that the resting heights give to the head: above the floor, and above the item's lowest.
pub(crate) const RESTING_CHANNELS: i64 = 2;

/// Blocks of a normalisation, a 2 x 2 de-convolution of stride 2 and the concatenation with the next finer features,
/// from the coarsest; then a hidden layer and the score.
///
/// Each output cell of such a de-convolution has one input cell, so it is a [`Mixing`] to four times the channels,
/// spread over the four output cells. At the container's resolution nothing mixes neighbours any more, so the four
/// are left apart as *phases*: cell `(2 x + dx, 2 y + dy)` is cell `(x, y)` of phase `2 dx + dy`. Where the finest features are at
/// that resolution already, the hidden layer is taken apart so.
#[derive(Debug)]
pub(super) struct Decoder {
    blocks: Vec<Mixing>,
    mixing: Mixing,
    hidden: Mixing,
    resting: Option<Tensor>,
    score: Mixing,
    finest: Finest,
}

impl Decoder {
    pub(super) fn new(
        parameters: &mut Parameters,
        architecture: &Architecture,
    ) -> Result<Self, TchError> {
        let head = architecture.head as i64;
        let normalisation = architecture.normalisation;
        let widths = architecture.widths.iter().map(|width| *width as i64);
        let widths: Vec<i64> = widths.collect();
        let mut blocks = Vec::new();
        let mut decoded = 0;
        for (level, width) in widths.iter().enumerate().skip(1).rev() {
            let inputs = decoded + fused_width(architecture.fusion, *width);
            decoded = widths.get(level - 1).copied().unwrap_or(head);
            let name = format!("decoder.{level}");
            let shape = (inputs, 4 * decoded);
            blocks.push(Mixing::new(parameters, &name, shape, normalisation)?);
        }
        let finest = widths.first().copied().unwrap_or(head);
        let inputs = decoded + fused_width(architecture.fusion, finest);
        let none = Normalisation::None;
        let spread = match architecture.finest {
            Finest::Half => 4 * head,
            Finest::Full => head,
        };
        let mut layer = |name: &str, shape, normalisation| {
            Mixing::new(parameters, &format!("head.{name}"), shape, normalisation)
        };
        Ok(Self {
            blocks,
            mixing: layer("mixing", (inputs, 2 * head), normalisation)?,
            hidden: layer("hidden", (2 * head, spread), none)?,
            score: layer("score", (head, 1), none)?,
            resting: if architecture.resting_heights {
                let shape = [head, RESTING_CHANNELS];
                Some(parameters.weight("head.resting.weight", &shape, RESTING_CHANNELS)?)
            } else {
                None
            },
            finest: architecture.finest,
        })
    }

    /// `fused` from the finest, `[C_i, N, X_i, Y_i]`, and `resting`, `[4, RESTING_CHANNELS, N X Y / 4]`
    /// where the network has it, to `[4, N X Y / 4]`: the scores by phase.
    pub(super) fn forward(
        &self,
        fused: &[Tensor],
        resting: Option<&Tensor>,
        training: bool,
    ) -> Result<Tensor, TchError> {
        let mut decoded: Option<Tensor> = None;
        let Some((finest, coarser)) = fused.split_first() else {
            let what = "a network has at least one block".to_owned();
            return Err(TchError::Shape(what));
        };
        for (block, features) in self.blocks.iter().zip(coarser.iter().rev()) {
            let (_, maps, nx, ny) = features.size4()?;
            let input = beside(features, decoded.as_ref())?;
            let spread = block.forward(&input, training)?.f_relu_()?;
            // All maps of a channel as one tall image.
            let spread = spread.f_view([1, -1, maps * nx, ny])?.f_pixel_shuffle(2)?;
            decoded = Some(spread.f_reshape([-1, maps * 4 * nx * ny])?);
        }
        let input = beside(finest, decoded.as_ref())?;
        let mixed = self.mixing.forward(&input, training)?.f_relu_()?;
        let hidden = self.hidden.forward(&mixed, training)?;
        let mut hidden = self.by_phase(&hidden, finest)?;
        if let (Some(weight), Some(resting)) = (&self.resting, resting) {
            let (head, channels) = weight.size2()?;
            let weight = weight.f_unsqueeze(0)?;
            let weight = weight.f_expand([4, head, channels], false)?;
            hidden = hidden.f_baddbmm_(&weight, resting)?;
        }
        self.score.forward_phases(&hidden.f_relu_()?)
    }

    /// The hidden layer at the resolution of the finest features as `[4, head, N X Y / 4]`.
    fn by_phase(&self, hidden: &Tensor, finest: &Tensor) -> Result<Tensor, TchError> {
        let (channels, cells) = hidden.size2()?;
        match self.finest {
            Finest::Half => hidden.f_view([4, channels / 4, cells]),
            Finest::Full => {
                let (_, maps, nx, ny) = finest.size4()?;
                let cells = hidden.f_view([channels, maps, nx / 2, 2, ny / 2, 2])?;
                let phases = cells.f_permute([3, 5, 0, 1, 2, 4])?;
                phases.f_reshape([4, channels, -1])
            }
        }
    }

    pub(super) fn folded(&self) -> Result<Self, TchError> {
        let blocks = self.blocks.iter().map(Mixing::folded);
        Ok(Self {
            blocks: blocks.collect::<Result<_, _>>()?,
            mixing: self.mixing.folded()?,
            hidden: self.hidden.folded()?,
            score: self.score.folded()?,
            resting: self.resting.as_ref().map(Tensor::f_detach).transpose()?,
            finest: self.finest,
        })
    }
}

/// Features `[C, N, X, Y]` beside what is decoded of the coarser ones, as `[channels, N X Y]`.
fn beside(features: &Tensor, decoded: Option<&Tensor>) -> Result<Tensor, TchError> {
    let features = features.f_flatten(1, -1)?;
    match decoded {
        Some(decoded) => Tensor::f_cat(&[&features, decoded], 0),
        None => Ok(features),
    }
}
