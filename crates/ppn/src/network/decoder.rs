//! The decoder: fused features back to a score per cell.

use tch::{TchError, Tensor};

use ppnpack_model::architecture::Architecture;

use super::fusion::fused_width;
use super::layers::Mixing;
use super::parameters::Parameters;

/// Channels that the resting heights give to the head: above the floor, and above the item's
/// lowest.
pub(crate) const RESTING_CHANNELS: i64 = 2;

/// Blocks of a normalisation, a 2 x 2 de-convolution of stride 2 and the concatenation with the
/// next finer features, from the coarsest; then a hidden layer and the score.
///
/// Each output cell of such a de-convolution has one input cell, so it is a [`Mixing`] to four
/// times the channels, spread over the four output cells. At the container's resolution nothing
/// mixes neighbours any more, so the four are left apart as *phases*: cell `(2 x + dx, 2 y + dy)`
/// is cell `(x, y)` of phase `2 dx + dy`.
#[derive(Debug)]
pub(super) struct Decoder {
    blocks: Vec<Mixing>,
    mixing: Mixing,
    hidden: Mixing,
    resting: Option<Tensor>,
    score: Mixing,
}

impl Decoder {
    pub(super) fn new(
        parameters: &mut Parameters,
        architecture: &Architecture,
    ) -> Result<Self, TchError> {
        let head = architecture.head as i64;
        let widths = architecture.widths.iter().map(|width| *width as i64);
        let widths: Vec<i64> = widths.collect();
        let mut blocks = Vec::new();
        let mut decoded = 0;
        for (level, width) in widths.iter().enumerate().skip(1).rev() {
            let inputs = decoded + fused_width(architecture.fusion, *width);
            decoded = widths.get(level - 1).copied().unwrap_or(head);
            let name = format!("decoder.{level}");
            let shape = (inputs, 4 * decoded);
            blocks.push(Mixing::new(parameters, &name, shape)?);
        }
        let finest = widths.first().copied().unwrap_or(head);
        let inputs = decoded + fused_width(architecture.fusion, finest);
        Ok(Self {
            blocks,
            mixing: Mixing::new(parameters, "head.mixing", (inputs, 2 * head))?,
            hidden: Mixing::plain(parameters, "head.hidden", (2 * head, 4 * head))?,
            score: Mixing::plain(parameters, "head.score", (head, 1))?,
            resting: if architecture.resting_heights {
                let shape = [head, RESTING_CHANNELS];
                Some(parameters.weight("head.resting.weight", &shape, RESTING_CHANNELS)?)
            } else {
                None
            },
        })
    }

    /// `fused` from the finest, `[C_i, N, X_i, Y_i]`, and `resting`, `[4, RESTING_CHANNELS, N X Y /
    /// 4]` where the network has it, to `[4, N X Y / 4]`: the scores by phase.
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
        let (channels, cells) = hidden.size2()?;
        let mut hidden = hidden.f_view([4, channels / 4, cells])?;
        if let (Some(weight), Some(resting)) = (&self.resting, resting) {
            let (head, channels) = weight.size2()?;
            let weight = weight.f_unsqueeze(0)?;
            let weight = weight.f_expand([4, head, channels], false)?;
            hidden = hidden.f_baddbmm_(&weight, resting)?;
        }
        self.score.forward_phases(&hidden.f_relu_()?)
    }

    pub(super) fn folded(&self) -> Result<Self, TchError> {
        let blocks = self.blocks.iter().map(Mixing::folded);
        Ok(Self {
            blocks: blocks.collect::<Result<_, _>>()?,
            mixing: self.mixing.folded()?,
            hidden: self.hidden.folded()?,
            score: self.score.folded()?,
            resting: self.resting.as_ref().map(Tensor::f_detach).transpose()?,
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
