//! The correlation of features on the processor.
//!
//! libtorch would look through every window at the full size of an item's canvas. Most of a canvas is empty, so here
//! the kernels are lists of the cells that the footprint covers: about a tenth of the work.

use pulp::{Arch, Simd, WithSimd};
use tch::{TchError, Tensor};

use super::encoder::Canvas;
use super::matrix::Matrix;
use crate::symmetry::Cells;

/// Vectors whose sums are under way together.
const VECTORS: usize = 4;
/// Cells of a tile with the widest vectors there are.
const WIDEST_TILE: usize = 16 * VECTORS;

/// The features of one view at one resolution, where its footprint has material.
#[derive(Debug, Clone)]
pub(crate) struct SparseKernel {
    /// Where a cell lies from the footprint's centre.
    offsets: Vec<(isize, isize)>,
    /// The greatest distance of a cell from the centre, along either axis.
    reach: usize,
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
        let offsets: Vec<(isize, isize)> = used.iter().map(offset).collect();
        let reach = offsets
            .iter()
            .map(|(x, y)| x.unsigned_abs().max(y.unsigned_abs()));
        Ok(Self {
            reach: reach.max().unwrap_or(0),
            offsets,
            weights: (0..channels).flat_map(of_channel).collect(),
        })
    }

    /// The cells of a channel's kernel as indices into `features`, from the first cell of a window.
    fn taps(&self, channel: usize, features: &PaddedFeatures, taps: &mut Vec<(usize, f32)>) {
        let count = self.offsets.len();
        let weights = self.weights.get(channel * count..(channel + 1) * count);
        // After a rectifier many features are 0.
        let used = self.offsets.iter().zip(weights.unwrap_or(&[]));
        let used = used.filter(|(_, weight)| **weight != 0.0);
        let (margin, pitch) = (features.margin, features.pitch());
        taps.clear();
        taps.extend(used.filter_map(|((x, y), weight)| {
            let (x, y) = (
                margin.checked_add_signed(*x)?,
                margin.checked_add_signed(*y)?,
            );
            Some((x * pitch + y, *weight))
        }));
    }
}

/// Features of a container at one resolution, with zeros where kernels reach over its edge.
///
/// Rows lie one after the other with one margin between two, so that a tile may run over the end of a row into the
/// next: what it computes in between is left out.
#[derive(Debug, Default)]
pub(super) struct PaddedFeatures {
    channels: usize,
    cells: Cells,
    margin: usize,
    values: Vec<f32>,
}

impl PaddedFeatures {
    /// Correlates features with all kernels: `[channels, kernels, X, Y]`.
    pub(super) fn correlate(
        &mut self,
        features: &Canvas,
        kernels: &[&SparseKernel],
        out: &mut Matrix,
    ) {
        let reach = kernels.iter().map(|kernel| kernel.reach).max();
        self.fill(features, reach.unwrap_or(0));
        let cells = self.cells.nx * self.cells.ny;
        out.reshape(self.channels, kernels.len() * cells);
        Arch::new().dispatch(Correlate {
            features: self,
            kernels,
            out,
        });
    }

    /// Takes over what a kernel that reaches no farther than `margin` may look at.
    fn fill(&mut self, features: &Canvas, margin: usize) {
        (self.channels, self.cells) = (features.channels(), features.cells());
        self.margin = margin;
        let (pitch, plane) = (self.pitch(), self.plane());
        self.values.clear();
        self.values.resize(self.channels * plane, 0.0);
        for (channel, values) in self.values.chunks_exact_mut(plane).enumerate() {
            for x in 0..self.cells.nx {
                let start = (margin + x) * pitch + margin;
                if let Some(out) = values.get_mut(start..start + self.cells.ny) {
                    out.copy_from_slice(features.row(channel, x));
                }
            }
        }
    }

    fn pitch(&self) -> usize {
        self.cells.ny + self.margin
    }

    /// Room for a last tile with a kernel that reaches as far as it may.
    fn plane(&self) -> usize {
        (self.cells.nx + 2 * self.margin) * self.pitch() + self.margin + WIDEST_TILE
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
        let features = self.features;
        let (Cells { nx, ny }, pitch) = (features.cells, features.pitch());
        let width = VECTORS * S::F32_LANES;
        let mut taps: Vec<(usize, f32)> = Vec::new();
        let mut sums = vec![0.0; (nx * pitch).next_multiple_of(width)];
        let planes = features.values.chunks_exact(features.plane());
        for (channel, plane) in planes.enumerate() {
            let maps = self.out.row_mut(channel).chunks_exact_mut((nx * ny).max(1));
            for (kernel, out) in self.kernels.iter().zip(maps) {
                kernel.taps(channel, features, &mut taps);
                for (number, out) in sums.chunks_exact_mut(width).enumerate() {
                    let tile = plane.get(number * width..).unwrap_or(&[]);
                    let sums = correlate_tile(simd, tile, &taps);
                    out.copy_from_slice(pulp::bytemuck::cast_slice(&sums));
                }
                for (sums, out) in sums.chunks(pitch.max(1)).zip(out.chunks_exact_mut(ny)) {
                    if let Some(sums) = sums.get(..ny) {
                        out.copy_from_slice(sums);
                    }
                }
            }
        }
    }
}

/// A tile of one channel with one kernel. `taps` are the kernel's cells as indices into `plane`, from the window of the
/// tile's first cell.
#[inline(always)]
fn correlate_tile<S: Simd>(simd: S, plane: &[f32], taps: &[(usize, f32)]) -> [S::f32s; VECTORS] {
    let mut sums = [simd.splat_f32s(0.0); VECTORS];
    for (tap, weight) in taps {
        let window = plane.get(*tap..*tap + VECTORS * S::F32_LANES);
        let [a, b, c, d] = S::as_simd_f32s(window.unwrap_or(&[])).0 else {
            continue;
        };
        let weight = simd.splat_f32s(*weight);
        let [w, x, y, z] = sums;
        sums = [
            simd.mul_add_e_f32s(*a, weight, w),
            simd.mul_add_e_f32s(*b, weight, x),
            simd.mul_add_e_f32s(*c, weight, y),
            simd.mul_add_e_f32s(*d, weight, z),
        ];
    }
    sums
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
            let mut found = Matrix::default();
            let kernels: Vec<&SparseKernel> = kernels.iter().collect();
            PaddedFeatures::default().correlate(&canvas, &kernels, &mut found);
            let rows: Vec<f32> = (0..found.rows())
                .flat_map(|row| found.row(row).to_vec())
                .collect();
            let found = Tensor::from_slice(&rows).view(expected.size().as_slice());
            let difference = (found - expected).abs().max().double_value(&[]);
            assert!(difference < 1e-4, "{difference}");
        }
    }
}
