//! The correlation of features on the processor.
//!
//! libtorch would look through every window at the full size of an item's canvas. Most of a canvas is empty, so here
//! the kernels are lists of the cells that the footprint covers: about a tenth of the work.

use pulp::{Arch, Simd, WithSimd};
use tch::{TchError, Tensor};

use super::encoder::Canvas;
use super::matrix::Matrix;
use crate::symmetry::Cells;

/// Rows are padded to a multiple of this: cells computed together, at most.
const LANES: usize = 16;
/// Rows that are computed together, so that several sums are under way at once.
const ROWS: usize = 4;

/// The features of one view at one resolution, where its footprint has material.
#[derive(Debug, Clone)]
pub(crate) struct SparseKernel {
    /// Where a cell lies from the footprint's centre.
    offsets: Vec<(isize, isize)>,
    /// Per channel, the value of each cell: `[channels, offsets]`.
    weights: Vec<f32>,
}

impl SparseKernel {
    /// From features `[channels, side, side]` with the footprint's centre at `side / 2`.
    pub(crate) fn new(features: &Tensor) -> Result<Self, TchError> {
        let (channels, side, _) = features.size3()?;
        let (channels, side) = (channels as usize, side as usize);
        let values: Vec<f32> = Vec::try_from(features.f_contiguous()?.f_view(-1)?)?;
        let cells = side * side;
        let at = |channel: usize, cell: usize| values.get(channel * cells + cell).copied();
        let is_used = |cell: &usize| {
            (0..channels).any(|channel| at(channel, *cell).is_some_and(|value| value != 0.0))
        };
        let used: Vec<usize> = (0..cells).filter(is_used).collect();
        let centre = (side / 2) as isize;
        let offset = |cell: &usize| {
            (
                (cell / side) as isize - centre,
                (cell % side) as isize - centre,
            )
        };
        let of_channel = |channel| {
            used.iter()
                .map(move |cell| at(channel, *cell).unwrap_or(0.0))
        };
        Ok(Self {
            offsets: used.iter().map(offset).collect(),
            weights: (0..channels).flat_map(of_channel).collect(),
        })
    }
}

/// Features of a container at one resolution, with room for kernels to reach over its edge.
#[derive(Debug, Clone)]
pub(super) struct PaddedFeatures {
    channels: usize,
    nx: usize,
    ny: usize,
    margin: usize,
    stride: usize,
    values: Vec<f32>,
}

impl PaddedFeatures {
    /// `margin` is the farthest that a kernel reaches.
    pub(super) fn new(features: &Canvas, margin: usize) -> Self {
        let (channels, Cells { nx, ny }) = (features.channels(), features.cells());
        let stride = ny.next_multiple_of(LANES) + 2 * margin;
        let rows = nx.next_multiple_of(ROWS) + 2 * margin;
        let mut padded = vec![0.0; channels * rows * stride];
        for channel in 0..channels {
            for x in 0..nx {
                let start = (channel * rows + margin + x) * stride + margin;
                if let Some(out) = padded.get_mut(start..start + ny) {
                    out.copy_from_slice(features.row(channel, x));
                }
            }
        }
        Self {
            channels,
            nx,
            ny,
            margin,
            stride,
            values: padded,
        }
    }

    fn rows(&self) -> usize {
        self.nx.next_multiple_of(ROWS) + 2 * self.margin
    }

    /// Correlates with all kernels: `[channels, kernels, X, Y]`.
    pub(super) fn correlate(&self, kernels: &[&SparseKernel], out: &mut Matrix) {
        out.reshape(self.channels, kernels.len() * self.nx * self.ny);
        Arch::new().dispatch(Correlate {
            features: self,
            kernels,
            out,
        });
    }
}

struct Correlate<'a> {
    features: &'a PaddedFeatures,
    kernels: &'a [&'a SparseKernel],
    out: &'a mut Matrix,
}

impl WithSimd for Correlate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            features,
            kernels,
            out,
        } = self;
        let cells = features.nx * features.ny;
        let plane = features.rows() * features.stride;
        let mut taps: Vec<(usize, f32)> = Vec::new();
        let maps = (0..features.channels).flat_map(|channel| {
            let kernels = kernels.iter().enumerate();
            kernels.map(move |(view, kernel)| (channel, view, kernel))
        });
        for (channel, view, kernel) in maps {
            let out = out.row_mut(channel);
            let Some(out) = out.get_mut(view * cells..(view + 1) * cells) else {
                continue;
            };
            let plane = features.values.get(channel * plane..(channel + 1) * plane);
            let count = kernel.offsets.len();
            let weights = kernel.weights.get(channel * count..(channel + 1) * count);
            let (Some(plane), Some(weights)) = (plane, weights) else {
                out.fill(0.0);
                continue;
            };
            taps.clear();
            let margin = features.margin as isize;
            let used = kernel.offsets.iter().zip(weights);
            // After a rectifier many features are 0.
            let used = used.filter(|(_, weight)| **weight != 0.0);
            taps.extend(used.map(|((x, y), weight)| {
                let at = (margin + x) * features.stride as isize + margin + y;
                (at.max(0) as usize, *weight)
            }));
            correlate_map(simd, plane, features, &taps, out);
        }
    }
}

/// One channel with one kernel. `taps` are the kernel's cells as indices from a window's first cell.
#[inline(always)]
fn correlate_map<S: Simd>(
    simd: S,
    plane: &[f32],
    features: &PaddedFeatures,
    taps: &[(usize, f32)],
    out: &mut [f32],
) {
    let (nx, ny, stride) = (features.nx, features.ny, features.stride);
    for first in (0..nx).step_by(ROWS) {
        for y in (0..ny).step_by(S::F32_LANES) {
            let mut sums = [simd.splat_f32s(0.0); ROWS];
            for (tap, weight) in taps {
                let at = first * stride + y + tap;
                // One check for all rows.
                let Some(windows) = plane.get(at..at + (ROWS - 1) * stride + S::F32_LANES) else {
                    continue;
                };
                let weight = simd.splat_f32s(*weight);
                for (row, sum) in sums.iter_mut().enumerate() {
                    let window = windows.get(row * stride..).unwrap_or(&[]);
                    if let Some(window) = S::as_simd_f32s(window).0.first() {
                        *sum = simd.mul_add_e_f32s(*window, weight, *sum);
                    }
                }
            }
            for (row, sum) in sums.iter().enumerate().take(nx - first) {
                let width = S::F32_LANES.min(ny - y);
                let start = (first + row) * ny + y;
                let sum: &[f32] = pulp::bytemuck::cast_slice(std::slice::from_ref(sum));
                if let (Some(out), Some(sum)) =
                    (out.get_mut(start..start + width), sum.get(..width))
                {
                    out.copy_from_slice(sum);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_model::architecture::Fusion;
    use tch::{Device, Kind};

    use super::*;
    use crate::network::fuse;

    #[test]
    fn the_sparse_correlation_is_that_of_libtorch() {
        tch::manual_seed(3);
        let kind = (Kind::Float, Device::Cpu);
        for (channels, nx, ny, side, views) in
            [(3, 16, 16, 8, 4), (2, 5, 18, 6, 1), (1, 2, 2, 2, 3)]
        {
            let container = Tensor::randn([1, channels, nx, ny], kind);
            let items = Tensor::randn([views, channels, side, side], kind);
            let mask = Tensor::rand([views, 1, side, side], kind).lt(0.4);
            let items = items * mask;
            let expected = fuse(Fusion::Correlation, &container, &items.unsqueeze(0)).unwrap();
            let kernels: Vec<SparseKernel> = (0..views)
                .map(|view| SparseKernel::new(&items.get(view)).unwrap())
                .collect();
            let mut canvas = Canvas::default();
            let cells = Cells {
                nx: nx as usize,
                ny: ny as usize,
            };
            let values: Vec<f32> = Vec::try_from(container.view(-1)).unwrap();
            canvas.fill(channels as usize, cells, &values);
            let padded = PaddedFeatures::new(&canvas, side as usize / 2);
            let mut found = Matrix::default();
            padded.correlate(&kernels.iter().collect::<Vec<_>>(), &mut found);
            let rows: Vec<f32> = (0..found.rows())
                .flat_map(|row| found.row(row).to_vec())
                .collect();
            let found = Tensor::from_slice(&rows).view(expected.size().as_slice());
            let difference = (found - expected).abs().max().double_value(&[]);
            assert!(difference < 1e-4, "{difference}");
        }
    }
}
