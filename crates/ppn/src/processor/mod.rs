//! What runs at every step, on the processor: the container's encoder, fusion and decoder without libtorch.
//!
//! The maps of a step are small and its layers narrow, so most of libtorch's time goes into calls, copies and layouts.
//! The functions are those of [`network`](crate::network).

mod correlation;
mod decoder;
mod encoder;
mod matrix;
mod mixing;

use tch::TchError;

use correlation::PaddedFeatures;
pub(crate) use correlation::SparseKernel;
use decoder::Decoder;
use encoder::{Canvas, Encoder};
use matrix::Matrix;

use crate::network::{CONTAINER_CHANNELS, Network};
use crate::symmetry::Cells;

/// A network whose fusion is correlation, but for the items' encoder.
#[derive(Debug)]
pub(crate) struct Processor {
    /// The container's cells.
    cells: Cells,
    encoder: Encoder,
    decoder: Decoder,
    padded: PaddedFeatures,
    fused: Vec<Matrix>,
}

impl Processor {
    /// `network` has its normalisation folded in; `cells` are a container's, multiples of the network's stride.
    pub(crate) fn new(network: &Network, cells: Cells) -> Result<Self, TchError> {
        let encoder = network.container_weights()?;
        Ok(Self {
            cells,
            fused: encoder.iter().map(|_| Matrix::default()).collect(),
            padded: PaddedFeatures::default(),
            encoder: Encoder::new(&encoder),
            decoder: Decoder::new(&network.decoder_weights()?),
        })
    }

    /// Scores of all views' maps, from the container's, `[CONTAINER_CHANNELS, X, Y]`, each view's kernels by
    /// resolution, and `resting`, `[views, RESTING_CHANNELS, L]`. The result is `[views, L]`, cells in the order of
    /// [`Layout::cell_of`](crate::maps::Layout::cell_of).
    pub(crate) fn score(
        &mut self,
        container: &[f32],
        views: &[Vec<&SparseKernel>],
        resting: &[f32],
    ) -> Vec<f32> {
        let channels = CONTAINER_CHANNELS as usize;
        let features = self.encoder.encode(channels, self.cells, container);
        for ((features, kernels), fused) in features.iter().zip(views).zip(&mut self.fused) {
            self.padded.correlate(features, kernels, fused);
        }
        let finest = features.first().map(Canvas::cells).unwrap_or_default();
        let maps = views.first().map_or(0, Vec::len);
        self.decoder.decode(&self.fused, finest, maps, resting)
    }
}
