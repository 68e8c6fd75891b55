//! The decoder on the processor.
//!
//! The same function as [`network::Decoder`](crate::network), but a tile of cells goes through the whole head while it
//! is in the nearest cache, and no operation costs a call into libtorch.

use pulp::{Arch, Simd, WithSimd};

use super::matrix::{Matrix, TILE};
use super::mixing::{Activation, Mixing, tile};
use crate::network::{DecoderWeights, RESTING_CHANNELS};
use crate::symmetry::Cells;

/// Cells of a map that the decoder keeps apart: the 2 x 2 of a de-convolution's output.
const PHASES: usize = 4;

/// The decoder's layers.
#[derive(Debug)]
pub(super) struct Decoder {
    /// From the coarsest.
    blocks: Vec<Mixing>,
    mixing: Mixing,
    hidden: Mixing,
    /// Per channel of the head.
    channels: Vec<HeadChannel>,
    takes_resting: bool,
    bias: f32,
    scratch: Scratch,
}

/// What a channel of the head adds and counts for.
#[derive(Debug)]
struct HeadChannel {
    resting: [f32; RESTING_CHANNELS as usize],
    score: f32,
}

#[derive(Debug, Default)]
struct Scratch {
    spread: Matrix,
    decoded: Matrix,
    /// Of one tile.
    mixed: Matrix,
    /// Of one tile.
    hidden: Matrix,
}

impl Decoder {
    pub(super) fn new(weights: &DecoderWeights) -> Self {
        let hidden = Mixing::new(&weights.hidden);
        let resting = |channel: usize, input: usize| {
            let at = channel * RESTING_CHANNELS as usize + input;
            weights
                .resting
                .as_ref()
                .and_then(|all| all.get(at).copied())
        };
        let channels = weights.score.weight.iter().enumerate();
        let channels = channels.map(|(channel, score)| HeadChannel {
            resting: std::array::from_fn(|input| resting(channel, input).unwrap_or(0.0)),
            score: *score,
        });
        Self {
            blocks: weights.blocks.iter().map(Mixing::new).collect(),
            mixing: Mixing::new(&weights.mixing),
            hidden,
            channels: channels.collect(),
            takes_resting: weights.resting.is_some(),
            bias: weights.score.bias.first().copied().unwrap_or(0.0),
            scratch: Scratch::default(),
        }
    }

    /// Scores of `maps` maps from their `fused` features, from the finest resolution, `[C_i, maps, X_i, Y_i]`, whose
    /// finest has the given `finest` cells, and from `resting`, `[maps, RESTING_CHANNELS, 4, X_0 Y_0]`. Gives
    /// `[maps, 4, X_0 Y_0]`.
    pub(super) fn decode(
        &mut self,
        fused: &[Matrix],
        finest: Cells,
        maps: usize,
        resting: &[f32],
    ) -> Vec<f32> {
        let mut scores = vec![0.0; maps * PHASES * finest.nx * finest.ny];
        Arch::new().dispatch(Decode {
            decoder: self,
            fused,
            finest,
            maps,
            resting,
            scores: &mut scores,
        });
        scores
    }
}

struct Decode<'a> {
    decoder: &'a mut Decoder,
    fused: &'a [Matrix],
    finest: Cells,
    maps: usize,
    resting: &'a [f32],
    scores: &'a mut [f32],
}

impl WithSimd for Decode<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Some((finest, coarser)) = self.fused.split_first() else {
            return;
        };
        let mut scratch = std::mem::take(&mut self.decoder.scratch);
        let mut has_decoded = false;
        let levels = coarser.iter().enumerate().rev();
        for ((level, features), block) in levels.zip(&self.decoder.blocks) {
            scratch.spread.reshape(block.outputs(), features.width());
            for first in (0..features.width()).step_by(tile::<S>()) {
                let decoded = has_decoded.then(|| scratch.decoded.tile(first));
                let inputs = [Some(features.tile(first)), decoded];
                let mut spread = scratch.spread.tile_mut(first);
                block.apply(simd, inputs, &mut spread, Activation::Rectified);
            }
            shuffle(
                &scratch.spread,
                self.finest.ny >> (level + 1),
                &mut scratch.decoded,
            );
            has_decoded = true;
        }
        let decoder = &*self.decoder;
        scratch.mixed.reshape(decoder.mixing.outputs(), TILE);
        scratch.hidden.reshape(decoder.hidden.outputs(), TILE);
        let cells = self.finest.nx * self.finest.ny;
        let resting = self
            .resting
            .chunks(RESTING_CHANNELS as usize * PHASES * cells);
        let mut resting = resting.map(Some).chain(std::iter::repeat(None));
        let scores = self.scores.chunks_exact_mut((PHASES * cells).max(1));
        for (map, scores) in scores.take(self.maps).enumerate() {
            let resting = resting.next().flatten().filter(|_| decoder.takes_resting);
            for first in (0..cells).step_by(tile::<S>()) {
                let at = map * cells + first;
                let decoded = has_decoded.then(|| scratch.decoded.tile(at));
                let inputs = [Some(finest.tile(at)), decoded];
                let mut mixed = scratch.mixed.tile_mut(0);
                let mixing = &decoder.mixing;
                mixing.apply(simd, inputs, &mut mixed, Activation::Rectified);
                let inputs = [Some(scratch.mixed.tile(0)), None];
                let mut hidden = scratch.hidden.tile_mut(0);
                let layer = &decoder.hidden;
                layer.apply(simd, inputs, &mut hidden, Activation::None);
                let hidden = &scratch.hidden;
                head(simd, decoder, hidden, resting, (first, cells), scores);
            }
        }
        self.decoder.scratch = scratch;
    }
}

/// The scores of one tile from its hidden layer, which has the head's channels once per phase. The tile is that from
/// `first` on of a map's `cells`; `resting` and `scores` are the map's.
#[inline(always)]
fn head<S: Simd>(
    simd: S,
    decoder: &Decoder,
    hidden: &Matrix,
    resting: Option<&[f32]>,
    (first, cells): (usize, usize),
    scores: &mut [f32],
) {
    let zero = simd.splat_f32s(0.0);
    let mut rows = (0..hidden.rows()).map(|row| hidden.row(row));
    let width = tile::<S>().min(cells - first);
    for phase in 0..PHASES {
        let mut inputs = [[zero; 2]; RESTING_CHANNELS as usize];
        for (channel, input) in inputs.iter_mut().enumerate() {
            let at = (channel * PHASES + phase) * cells + first;
            if let Some(cells) = resting.and_then(|resting| resting.get(at..at + width)) {
                load(input, cells);
            }
        }
        let mut sums = [simd.splat_f32s(decoder.bias); 2];
        for (channel, row) in decoder.channels.iter().zip(&mut rows) {
            let weights = channel.resting.map(|weight| simd.splat_f32s(weight));
            let score = simd.splat_f32s(channel.score);
            for ((lane, hidden), sum) in S::as_simd_f32s(row).0.iter().enumerate().zip(&mut sums) {
                let mut hidden = *hidden;
                for (weight, input) in weights.iter().zip(&inputs) {
                    if let Some(input) = input.get(lane) {
                        hidden = simd.mul_add_e_f32s(*weight, *input, hidden);
                    }
                }
                *sum = simd.mul_add_e_f32s(simd.max_f32s(hidden, zero), score, *sum);
            }
        }
        let at = phase * cells + first;
        let sums: &[f32] = pulp::bytemuck::cast_slice(&sums);
        if let (Some(scores), Some(sums)) = (scores.get_mut(at..at + width), sums.get(..width)) {
            scores.copy_from_slice(sums);
        }
    }
}

/// Fills the first lanes.
#[inline(always)]
fn load<V: pulp::bytemuck::Pod>(vectors: &mut [V; 2], cells: &[f32]) {
    let lanes: &mut [f32] = pulp::bytemuck::cast_slice_mut(vectors);
    if let Some(lanes) = lanes.get_mut(..cells.len()) {
        lanes.copy_from_slice(cells);
    }
}

/// Spreads each group of four channels over 2 x 2 cells: channel `4 c + 2 dx + dy` of `[4 D, maps X, ny]` becomes
/// channel `c` at `(2 x + dx, 2 y + dy)` of `[D, 2 maps X, 2 ny]`.
#[inline(always)]
fn shuffle(spread: &Matrix, ny: usize, decoded: &mut Matrix) {
    let rows = spread.rows();
    decoded.reshape(rows / PHASES, PHASES * spread.width());
    for channel in 0..rows / PHASES {
        for dx in 0..2 {
            let even = spread
                .row(PHASES * channel + 2 * dx)
                .chunks_exact(ny.max(1));
            let odd = spread
                .row(PHASES * channel + 2 * dx + 1)
                .chunks_exact(ny.max(1));
            let out = decoded.row_mut(channel).chunks_exact_mut(2 * ny.max(1));
            for ((even, odd), out) in even.zip(odd).zip(out.skip(dx).step_by(2)) {
                let pairs = out.as_chunks_mut::<2>().0;
                for ((even, odd), pair) in even.iter().zip(odd).zip(pairs) {
                    *pair = [*even, *odd];
                }
            }
        }
    }
}
