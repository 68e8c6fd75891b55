//! Combining inputs linearly, many cells at once.

use pulp::Simd;

use super::matrix::{Inputs, Outputs};
use crate::network::Linear;

/// Outputs and vectors whose sums are under way together: as many as hide the latency of a fused multiply-add, and
/// few enough to stay in registers with AVX2.
const OUTPUTS: usize = 4;
pub(super) const VECTORS: usize = 2;

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
        inputs: [Inputs<'_>; 2],
        out: &mut Outputs<'_>,
        activation: Activation,
    ) {
        let zero = simd.splat_f32s(0.0);
        for (number, block) in self.blocks.iter().enumerate() {
            let sums = sums(simd, block, inputs);
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

/// Sums of a block's outputs for one tile.
type Sums<S> = [[<S as Simd>::f32s; VECTORS]; OUTPUTS];

/// A block's outputs for one tile.
#[inline(always)]
fn sums<S: Simd>(simd: S, block: &[[f32; OUTPUTS]], inputs: [Inputs<'_>; 2]) -> Sums<S> {
    let Some((bias, weights)) = block.split_first() else {
        return [[simd.splat_f32s(0.0); VECTORS]; OUTPUTS];
    };
    let [a, b, c, d] = *bias;
    let twice = |bias| [simd.splat_f32s(bias); VECTORS];
    let mut sums = [twice(a), twice(b), twice(c), twice(d)];
    let [first, second] = inputs;
    let (of_first, of_second) = weights.split_at(first.starts.len().min(weights.len()));
    sums = add(simd, sums, first, of_first);
    add(simd, sums, second, of_second)
}

/// Adds inputs to sums, which are passed by value and never indexed: so they stay in registers.
#[inline(always)]
fn add<S: Simd>(simd: S, sums: Sums<S>, inputs: Inputs<'_>, weights: &[[f32; OUTPUTS]]) -> Sums<S> {
    let [
        [mut a0, mut a1],
        [mut b0, mut b1],
        [mut c0, mut c1],
        [mut d0, mut d1],
    ] = sums;
    for (start, [a, b, c, d]) in inputs.starts.iter().zip(weights) {
        let row = inputs.values.get(*start..*start + tile::<S>());
        let [first, second] = S::as_simd_f32s(row.unwrap_or(&[])).0 else {
            break;
        };
        let a = simd.splat_f32s(*a);
        (a0, a1) = (
            simd.mul_add_e_f32s(*first, a, a0),
            simd.mul_add_e_f32s(*second, a, a1),
        );
        let b = simd.splat_f32s(*b);
        (b0, b1) = (
            simd.mul_add_e_f32s(*first, b, b0),
            simd.mul_add_e_f32s(*second, b, b1),
        );
        let c = simd.splat_f32s(*c);
        (c0, c1) = (
            simd.mul_add_e_f32s(*first, c, c0),
            simd.mul_add_e_f32s(*second, c, c1),
        );
        let d = simd.splat_f32s(*d);
        (d0, d1) = (
            simd.mul_add_e_f32s(*first, d, d0),
            simd.mul_add_e_f32s(*second, d, d1),
        );
    }
    [[a0, a1], [b0, b1], [c0, c1], [d0, d1]]
}
