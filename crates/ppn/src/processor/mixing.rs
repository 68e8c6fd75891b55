//! Combining inputs linearly, many cells at once.

use pulp::Simd;

use super::matrix::{Inputs, Outputs};
use crate::network::Linear;

/// Outputs and vectors whose sums are under way together: as many as hide the latency of a fused multiply-add, and
/// few enough to stay in registers with AVX2.
const OUTPUTS: usize = 4;
const VECTORS: usize = 2;

/// A linear layer with its weights in the order in which they are used.
#[derive(Debug)]
pub(super) struct Mixing {
    outputs: usize,
    /// Per block of [`OUTPUTS`] outputs, their biases and then their weights by input.
    blocks: Vec<Vec<[f32; OUTPUTS]>>,
}

/// What becomes of the sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Activation {
    None,
    Rectified,
}

/// The cells of a tile.
#[inline(always)]
pub(super) const fn tile<S: Simd>() -> usize {
    VECTORS * S::F32_LANES
}

impl Mixing {
    pub(super) fn new(layer: &Linear) -> Self {
        let at = |values: &[f32], index: usize| values.get(index).copied().unwrap_or(0.0);
        let block = |first: usize| {
            let bias = std::array::from_fn(|output| at(&layer.bias, first + output));
            let of_input = |input| {
                let weight = |output| at(&layer.weight, (first + output) * layer.inputs + input);
                std::array::from_fn(weight)
            };
            let mut block = vec![bias];
            block.extend((0..layer.inputs).map(of_input));
            block
        };
        Self {
            outputs: layer.outputs,
            blocks: (0..layer.outputs).step_by(OUTPUTS).map(block).collect(),
        }
    }

    pub(super) fn outputs(&self) -> usize {
        self.outputs
    }

    /// One tile of all outputs from one of all inputs: those of the first part, then those of the second.
    #[inline(always)]
    pub(super) fn apply<S: Simd>(
        &self,
        simd: S,
        inputs: [Option<Inputs<'_>>; 2],
        out: &mut Outputs<'_>,
        activation: Activation,
    ) {
        let zero = simd.splat_f32s(0.0);
        for (number, block) in self.blocks.iter().enumerate() {
            let Some((bias, weights)) = block.split_first() else {
                continue;
            };
            let mut sums = [[zero; VECTORS]; OUTPUTS];
            for (sums, bias) in sums.iter_mut().zip(bias) {
                *sums = [simd.splat_f32s(*bias); VECTORS];
            }
            let mut weights = weights.iter();
            for part in inputs.into_iter().flatten() {
                for (start, weights) in part.starts.iter().zip(weights.by_ref()) {
                    let row = part.values.get(*start..*start + tile::<S>());
                    let [first, second] = S::as_simd_f32s(row.unwrap_or(&[])).0 else {
                        continue;
                    };
                    for (sums, weight) in sums.iter_mut().zip(weights) {
                        let weight = simd.splat_f32s(*weight);
                        sums[0] = simd.mul_add_e_f32s(*first, weight, sums[0]);
                        sums[1] = simd.mul_add_e_f32s(*second, weight, sums[1]);
                    }
                }
            }
            let first = number * OUTPUTS;
            for (sums, output) in sums.iter().zip(first..self.outputs) {
                let start = output * out.stride;
                let row = out.values.get_mut(start..start + tile::<S>());
                let row = S::as_mut_simd_f32s(row.unwrap_or(&mut [])).0;
                for (out, sum) in row.iter_mut().zip(sums) {
                    *out = match activation {
                        Activation::None => *sum,
                        Activation::Rectified => simd.max_f32s(*sum, zero),
                    };
                }
            }
        }
    }
}
