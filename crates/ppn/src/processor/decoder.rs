//! The decoder on the processor.
//!
//! The same function as [`network::Decoder`](crate::network), but a tile of cells goes through the whole head while it
//! is in the nearest cache, and no operation costs a call into libtorch.

use pulp::{Arch, Simd, WithSimd};

use super::matrix::{Inputs, Matrix, TILE};
use super::mixing::{Activation, Mixing, VECTORS, tile};
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
    /// Of the head.
    channels: Vec<HeadChannel>,
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
            hidden: Mixing::new(&weights.hidden),
            channels: channels.collect(),
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
        self.decoder.decode_coarser(simd, coarser, self.finest.ny);
        let cells = self.finest.nx * self.finest.ny;
        let resting = self.resting;
        let mut resting = resting.chunks_exact(RESTING_CHANNELS as usize * PHASES * cells);
        let scores = self.scores.chunks_exact_mut((PHASES * cells).max(1));
        for (map, scores) in scores.enumerate() {
            let resting = resting.next();
            for first in (0..cells).step_by(tile::<S>()) {
                self.decoder.mix(simd, finest, map * cells + first);
                self.decoder.score(simd, resting, (first, cells), scores);
            }
        }
    }
}

impl Decoder {
    /// Decodes all resolutions but the finest, whose maps have `finest_ny` cells along y.
    #[inline(always)]
    fn decode_coarser<S: Simd>(&mut self, simd: S, coarser: &[Matrix], finest_ny: usize) {
        let Scratch {
            spread, decoded, ..
        } = &mut self.scratch;
        decoded.reshape(0, 0);
        let levels = coarser.iter().enumerate().rev();
        for ((level, features), block) in levels.zip(&self.blocks) {
            spread.reshape(block.outputs(), features.width());
            for first in (0..features.width()).step_by(tile::<S>()) {
                let inputs = [features.tile(first), decoded.tile(first)];
                let mut out = spread.tile_mut(first);
                block.apply(simd, inputs, &mut out, Activation::Rectified);
            }
            shuffle(spread, finest_ny >> (level + 1), decoded);
        }
    }

    /// The head's hidden layer for the tile from the cell at `first` on.
    #[inline(always)]
    fn mix<S: Simd>(&mut self, simd: S, finest: &Matrix, first: usize) {
        let Scratch {
            decoded,
            mixed,
            hidden,
            ..
        } = &mut self.scratch;
        mixed.reshape(self.mixing.outputs(), TILE);
        let inputs = [finest.tile(first), decoded.tile(first)];
        let mut out = mixed.tile_mut(0);
        self.mixing
            .apply(simd, inputs, &mut out, Activation::Rectified);
        hidden.reshape(self.hidden.outputs(), TILE);
        let inputs = [mixed.tile(0), Inputs::default()];
        let mut out = hidden.tile_mut(0);
        self.hidden.apply(simd, inputs, &mut out, Activation::None);
    }

    /// The scores of a tile from its hidden layer, which has the head's channels once per phase. The tile is that from
    /// `first` on of a map's `cells`; `resting` and `scores` are the map's.
    #[inline(always)]
    fn score<S: Simd>(
        &self,
        simd: S,
        resting: Option<&[f32]>,
        (first, cells): (usize, usize),
        scores: &mut [f32],
    ) {
        let zero = simd.splat_f32s(0.0);
        let hidden = &self.scratch.hidden;
        let mut rows = (0..hidden.rows()).map(|row| hidden.row(row));
        let width = tile::<S>().min(cells - first);
        for phase in 0..PHASES {
            let mut inputs = [[zero; VECTORS]; RESTING_CHANNELS as usize];
            for (channel, input) in inputs.iter_mut().enumerate() {
                let at = (channel * PHASES + phase) * cells + first;
                if let Some(cells) = resting.and_then(|resting| resting.get(at..at + width)) {
                    load(input, cells);
                }
            }
            let mut sums = [simd.splat_f32s(self.bias); VECTORS];
            for (channel, row) in self.channels.iter().zip(&mut rows) {
                let weights = channel.resting.map(|weight| simd.splat_f32s(weight));
                let score = simd.splat_f32s(channel.score);
                let vectors = S::as_simd_f32s(row).0.iter().enumerate();
                for ((lane, hidden), sum) in vectors.zip(&mut sums) {
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
            if let (Some(scores), Some(sums)) = (scores.get_mut(at..at + width), sums.get(..width))
            {
                scores.copy_from_slice(sums);
            }
        }
    }
}

/// Fills the first lanes.
#[inline(always)]
fn load<V: pulp::bytemuck::Pod>(vectors: &mut [V; VECTORS], cells: &[f32]) {
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
