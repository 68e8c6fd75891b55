//! The placement proposal network.

mod decoder;
mod encoder;
mod fusion;
mod layers;
mod parameters;

use tch::{Device, TchError, Tensor};

use ppnpack_model::architecture::Architecture;

use decoder::Decoder;
pub(crate) use decoder::RESTING_CHANNELS;
use encoder::{Encoder, halved};
pub(crate) use fusion::fuse;
pub(crate) use parameters::Parameters;

/// Channels of a container: height in decimetres, and 1 inside.
pub(crate) const CONTAINER_CHANNELS: i64 = 2;
/// Channels of a view: upper surface and lower surface in decimetres, and 1 where there is
/// material.
pub(crate) const VIEW_CHANNELS: i64 = 3;

/// Features from the finest resolution: `[S, C_i, X_i, Y_i]` of containers, with `X_i = X /
/// 2^(i+1)`; `[V, C_i, K_i, K_i]` of views, with `K_i` of `K` likewise.
pub(crate) type Features = Vec<Tensor>;

/// The network's layers.
#[derive(Debug)]
pub(crate) struct Network {
    architecture: Architecture,
    container: Encoder,
    item: Encoder,
    decoder: Decoder,
    is_training: bool,
}

impl Network {
    /// Makes a network with random weights, ready to be trained, and its named tensors.
    pub(crate) fn new(
        architecture: &Architecture,
        device: Device,
    ) -> Result<(Self, Parameters), TchError> {
        let mut parameters = Parameters::new(device);
        let registry = &mut parameters;
        let network = Self {
            architecture: architecture.clone(),
            container: Encoder::new(registry, "container", CONTAINER_CHANNELS, architecture)?,
            item: Encoder::new(registry, "item", VIEW_CHANNELS, architecture)?,
            decoder: Decoder::new(registry, architecture)?,
            is_training: true,
        };
        Ok((network, parameters))
    }

    /// Sets whether normalisation uses the batch's statistics, and updates the running ones.
    pub(crate) fn set_training(&mut self, is_training: bool) {
        self.is_training = is_training;
    }

    /// Gives the same function for inference: normalisation is folded into the convolutions.
    pub(crate) fn folded(&self) -> Result<Self, TchError> {
        Ok(Self {
            architecture: self.architecture.clone(),
            container: self.container.folded()?,
            item: self.item.folded()?,
            decoder: self.decoder.folded()?,
            is_training: false,
        })
    }

    /// Encodes `maps`, `[S, CONTAINER_CHANNELS, X, Y]`, sides a multiple of
    /// [`Architecture::stride`].
    pub(crate) fn encode_containers(&self, maps: &Tensor) -> Result<Features, TchError> {
        self.container.forward(maps, None, self.is_training)
    }

    /// Encodes `views`, `[V, VIEW_CHANNELS, K, K]`, `K` a multiple of twice the stride, the
    /// footprint's centre at `K / 2`.
    ///
    /// Features are limited to the footprint and divided by its cells: neither canvas nor size
    /// scales a correlation.
    pub(crate) fn encode_views(&self, views: &Tensor) -> Result<Features, TchError> {
        let mut mask = views.f_narrow(1, VIEW_CHANNELS - 1, 1)?;
        let features = self.item.forward(views, Some(&mask), self.is_training)?;
        let divided = features.into_iter().map(|features| {
            mask = halved(&mask)?;
            let cells = mask.f_sum_dim_intlist([1_i64, 2, 3].as_slice(), true, None)?;
            features.f_div(&cells.f_clamp_min(1.0)?)
        });
        divided.collect()
    }

    /// Brings the features of `V` views and of each of `S` containers together: `views` is `[S, V,
    /// C_i, K_i, K_i]` per resolution, the result `[C'_i, S V, X_i, Y_i]`.
    pub(crate) fn fuse(
        &self,
        containers: &[Tensor],
        views: &[Tensor],
    ) -> Result<Vec<Tensor>, TchError> {
        let both = containers.iter().zip(views);
        both.map(|(container, views)| fuse(self.architecture.fusion, container, views))
            .collect()
    }

    /// Scores `N` maps by their fused features, and by `resting`, `[N, RESTING_CHANNELS, L]`, where
    /// the network takes it: `[N, L]`, lower is better. The `L = X Y` cells of a map are in the
    /// order of [`Layout::cell_of`](crate::maps::Layout::cell_of): by phase.
    pub(crate) fn score(
        &self,
        fused: &[Tensor],
        resting: Option<&Tensor>,
    ) -> Result<Tensor, TchError> {
        let by_phase = resting.map(|resting| {
            let (maps, channels, cells) = resting.size3()?;
            let phases = resting.f_view([maps, channels, 4, cells / 4])?;
            let phases = phases.f_permute([2, 1, 0, 3])?;
            phases.f_reshape([4, channels, maps * cells / 4])
        });
        let by_phase = by_phase.transpose()?;
        let sizes = fused.first().map(Tensor::size4).transpose()?;
        let maps = sizes.map_or(0, |(_, maps, ..)| maps);
        let (by_phase, is_training) = (by_phase.as_ref(), self.is_training);
        let scores = self.decoder.forward(fused, by_phase, is_training)?;
        let by_map = scores.f_view([4, maps, -1])?;
        by_map.f_permute([1, 0, 2])?.f_reshape([maps, -1])
    }

    pub(crate) fn architecture(&self) -> &Architecture {
        &self.architecture
    }
}
