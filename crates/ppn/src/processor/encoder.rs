//! The container's encoder on the processor.

use pulp::{Arch, Simd, WithSimd};

use super::matrix::{Inputs, Outputs, TILE};
use super::mixing::{Activation, Mixing, tile};
use crate::network::Linear;
use crate::symmetry::Cells;

/// Maps with a border of zeros, one after the other.
#[derive(Debug, Default)]
pub(super) struct Canvas {
    channels: usize,
    cells: Cells,
    values: Vec<f32>,
}

impl Canvas {
    /// Takes another shape; without one, what is inside the border is left over from before.
    fn reshape(&mut self, channels: usize, cells: Cells) {
        if (channels, cells) != (self.channels, self.cells) {
            *self = Self {
                channels,
                cells,
                values: Vec::new(),
            };
            self.values = vec![0.0; channels * self.plane()];
        }
    }

    pub(super) fn channels(&self) -> usize {
        self.channels
    }

    pub(super) fn cells(&self) -> Cells {
        self.cells
    }

    /// From a cell to its neighbour in x.
    fn pitch(&self) -> usize {
        self.cells.ny + 2
    }

    /// From a cell to the same of the next channel: room for a last tile that reaches beyond the border.
    fn plane(&self) -> usize {
        (self.cells.nx + 2) * self.pitch() + TILE
    }

    fn start(&self, channel: usize, x: usize) -> usize {
        channel * self.plane() + (x + 1) * self.pitch() + 1
    }

    /// The cells of a channel at one `x`.
    pub(super) fn row(&self, channel: usize, x: usize) -> &[f32] {
        let start = self.start(channel, x);
        let range = start..start + self.cells.ny;
        self.values.get(range).unwrap_or(&[])
    }

    fn row_mut(&mut self, channel: usize, x: usize) -> &mut [f32] {
        let start = self.start(channel, x);
        let range = start..start + self.cells.ny;
        self.values.get_mut(range).unwrap_or(&mut [])
    }

    /// Takes `[channels, X, Y]` over.
    pub(super) fn fill(&mut self, channels: usize, cells: Cells, maps: &[f32]) {
        self.reshape(channels, cells);
        for (row, values) in maps.chunks_exact(cells.ny.max(1)).enumerate() {
            let (channel, x) = (row / cells.nx.max(1), row % cells.nx.max(1));
            let out = self.row_mut(channel, x);
            if out.len() == values.len() {
                out.copy_from_slice(values);
            }
        }
    }

    /// Makes the border zero again after tiles have run over it.
    fn clear_border(&mut self) {
        let (pitch, plane, nx, ny) = (self.pitch(), self.plane(), self.cells.nx, self.cells.ny);
        for values in self.values.chunks_exact_mut(plane) {
            for x in 0..nx {
                let end = (x + 1) * pitch + 1 + ny;
                if let Some(edge) = values.get_mut(end..end + 2) {
                    edge.fill(0.0);
                }
            }
            if let Some(end) = values.get_mut((nx + 1) * pitch..) {
                end.fill(0.0);
            }
        }
    }
}

/// Blocks of two 3 x 3 convolutions and a 2 x 2 maximum pool.
#[derive(Debug)]
pub(super) struct Encoder {
    blocks: Vec<[Mixing; 2]>,
    input: Canvas,
    /// After each convolution of a block.
    convolved: Vec<[Canvas; 2]>,
    /// After each block.
    features: Vec<Canvas>,
}

impl Encoder {
    pub(super) fn new(weights: &[[Linear; 2]]) -> Self {
        let blocks = weights
            .iter()
            .map(|block| block.each_ref().map(Mixing::new));
        Self {
            blocks: blocks.collect(),
            input: Canvas::default(),
            convolved: weights.iter().map(|_| Default::default()).collect(),
            features: weights.iter().map(|_| Canvas::default()).collect(),
        }
    }

    /// Features of maps `[channels, X, Y]`: `[C_i, X / 2^(i+1), Y / 2^(i+1)]` from the finest.
    pub(super) fn encode(&mut self, channels: usize, cells: Cells, maps: &[f32]) -> &[Canvas] {
        self.input.fill(channels, cells, maps);
        Arch::new().dispatch(Encode(self));
        &self.features
    }
}

struct Encode<'a>(&'a mut Encoder);

impl WithSimd for Encode<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let encoder = self.0;
        let mut taps = Vec::new();
        let mut current = &encoder.input;
        let outputs = encoder.convolved.iter_mut().zip(&mut encoder.features);
        for ([first, second], (convolved, features)) in encoder.blocks.iter().zip(outputs) {
            let [once, twice] = convolved;
            convolve(simd, first, current, once, &mut taps);
            convolve(simd, second, once, twice, &mut taps);
            halve(twice, features);
            current = features;
        }
    }
}

/// A 3 x 3 convolution, rectified. Cells are computed in the order of memory, borders included.
#[inline(always)]
fn convolve<S: Simd>(
    simd: S,
    layer: &Mixing,
    input: &Canvas,
    out: &mut Canvas,
    taps: &mut Vec<usize>,
) {
    out.reshape(layer.outputs(), input.cells);
    let (pitch, plane) = (input.pitch(), input.plane());
    taps.clear();
    taps.extend((0..9 * input.channels).map(|input| {
        let (channel, dx, dy) = (input / 9, input / 3 % 3, input % 3);
        channel * plane + dx * pitch + dy
    }));
    for first in (0..input.cells.nx * pitch).step_by(tile::<S>()) {
        let inputs = Inputs {
            values: input.values.get(first..).unwrap_or(&[]),
            starts: taps,
        };
        let mut outputs = Outputs {
            values: out.values.get_mut(first + pitch + 1..).unwrap_or(&mut []),
            stride: plane,
        };
        layer.apply(
            simd,
            [inputs, Inputs::default()],
            &mut outputs,
            Activation::Rectified,
        );
    }
    out.clear_border();
}

/// Half the resolution: the greatest of each 2 x 2 cells.
#[inline(always)]
fn halve(input: &Canvas, out: &mut Canvas) {
    let cells = Cells {
        nx: input.cells.nx / 2,
        ny: input.cells.ny / 2,
    };
    out.reshape(input.channels, cells);
    for channel in 0..input.channels {
        for x in 0..cells.nx {
            let first = input.row(channel, 2 * x).as_chunks::<2>().0;
            let second = input.row(channel, 2 * x + 1).as_chunks::<2>().0;
            let out = out.row_mut(channel, x);
            for (([a, b], [c, d]), out) in first.iter().zip(second).zip(out) {
                *out = a.max(*b).max(c.max(*d));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_model::architecture::{Architecture, Normalisation};
    use tch::{Device, Kind, Tensor};

    use super::*;
    use crate::network::{CONTAINER_CHANNELS, Network};

    #[test]
    fn the_encoder_is_that_of_libtorch() {
        tch::manual_seed(5);
        let architecture = Architecture {
            normalisation: Normalisation::None,
            widths: vec![5, 8, 3],
            ..Architecture::default()
        };
        let (network, _) = Network::new(&architecture, Device::Cpu).unwrap();
        let mut own = Encoder::new(&network.container_weights().unwrap());
        // The same canvases again and again: nothing of one container is left in the next.
        for (nx, ny) in [(32, 32), (8, 40), (40, 8), (8, 8), (8, 8)] {
            let shape = [1, CONTAINER_CHANNELS, nx as i64, ny as i64];
            let maps = Tensor::randn(shape, (Kind::Float, Device::Cpu));
            let expected = network.encode_containers(&maps).unwrap();
            let maps: Vec<f32> = Vec::try_from(maps.view(-1)).unwrap();
            let found = own.encode(CONTAINER_CHANNELS as usize, Cells { nx, ny }, &maps);
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(expected) {
                let expected = expected.contiguous();
                let (_, channels, nx, ny) = expected.size4().unwrap();
                assert_eq!(found.channels() as i64, channels);
                assert_eq!((found.cells().nx as i64, found.cells().ny as i64), (nx, ny));
                let expected: Vec<f32> = Vec::try_from(expected.view(-1)).unwrap();
                let rows = (0..found.channels())
                    .flat_map(|channel| (0..found.cells().nx).map(move |x| (channel, x)));
                let found = rows.flat_map(|(channel, x)| found.row(channel, x).to_vec());
                for (found, expected) in found.zip(expected) {
                    assert!((found - expected).abs() < 1e-4, "{found} and {expected}");
                }
            }
        }
    }
}
