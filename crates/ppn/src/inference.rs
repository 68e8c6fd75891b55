//! Running a network: scores for every placement of a step's candidates.

use std::collections::HashMap;
use std::sync::Arc;

use ppnpack_model::settings::Device;
use ppnpack_model::weights::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::{Item, ItemView, ShapeId};
use ppnpack_packing::kernel::placement::Placement;
use ppnpack_packing::kernel::resting::RestingHeights;
use ppnpack_packing::ranking::proposals::Percent;
use tch::{TchError, Tensor};

use crate::error::NetworkError;
use crate::files::network_of;
use crate::maps::{Layout, limit, lowest};
use crate::network::{CONTAINER_CHANNELS, Features, Network, RESTING_CHANNELS, VIEW_CHANNELS};
use crate::runtime;
use crate::symmetry::Symmetry;

/// Maximum number of items whose features are kept: some thirty megabytes of items of up to 32
/// cells a side with four yaws.
const KEPT_ITEMS: usize = 512;

/// A network ready to score placements on one grid.
#[derive(Debug)]
pub(crate) struct Inference {
    grid: Grid,
    device: tch::Device,
    network: Network,
    layout: Layout,
    resting: RestingHeights,
    features: HashMap<ShapeId, ItemFeatures>,
    uses: u64,
}

/// Features of an item, which do not depend on the container.
#[derive(Debug)]
struct ItemFeatures {
    /// On a canvas that holds the item's largest view.
    views: Features,
    last_used: u64,
}

/// The scores of a step's candidates. Maps are by candidate and yaw, cells as the layout orders
/// them.
#[derive(Debug)]
pub(crate) struct Scores {
    scores: Vec<f32>,
    fits: Vec<bool>,
}

/// A score and where it stands, ordered by both: one integer, as many are compared at every step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Ranked(u64);

impl Ranked {
    /// `index` is less than 2^32.
    fn new(score: f32, index: usize) -> Self {
        let bits = score.to_bits();
        // Negative numbers are in the reverse order, and below the positive ones.
        let ordered = if score.is_sign_negative() {
            !bits
        } else {
            bits | 1 << 31
        };
        Self(u64::from(ordered) << 32 | index as u64)
    }

    fn index(self) -> usize {
        (self.0 & u64::from(u32::MAX)) as usize
    }
}

impl Inference {
    /// Takes a model over; its weights must be those of its architecture.
    pub(crate) fn new(model: &Model, grid: &Grid, device: Device) -> Result<Self, NetworkError> {
        let device = runtime::device(device)?;
        let architecture = &model.card().architecture;
        let network = network_of(model, device)?;
        let network = tch::no_grad(|| network.folded())?;
        let layout = Layout::new(grid, architecture.stride(), Symmetry::default());
        Ok(Self {
            layout,
            resting: RestingHeights::new(grid),
            grid: grid.clone(),
            device,
            network,
            features: HashMap::new(),
            uses: 0,
        })
    }

    /// Runs the network a few times, so that libtorch has chosen its kernels before the first step.
    pub(crate) fn warmed_up(self) -> Result<Self, NetworkError> {
        let kind = (tch::Kind::Float, self.device);
        tch::no_grad(|| -> Result<(), NetworkError> {
            let side = self.network.architecture().stride() as i64;
            let container = vec![0.0; CONTAINER_CHANNELS as usize * self.layout.cells()];
            for _ in 0..3 {
                let containers = self.encode_container(&container)?;
                let views = Tensor::f_zeros([1, VIEW_CHANNELS, side, side], kind)?;
                let views = self.network.encode_views(&views)?;
                let views = views.iter().map(|features| features.f_unsqueeze(0));
                let views = views.collect::<Result<Vec<_>, _>>()?;
                let fused = self.network.fuse(&containers, &views)?;
                let cells = self.layout.cells() as i64;
                let resting = Tensor::f_zeros([1, RESTING_CHANNELS, cells], kind)?;
                let takes_resting = self.network.architecture().resting_heights;
                let resting = takes_resting.then_some(&resting);
                let scores = self.network.score(&fused, resting)?;
                drop(scores.f_to(tch::Device::Cpu)?);
            }
            Ok(())
        })?;
        Ok(self)
    }

    /// Computes the features of items ahead of time, as many as are kept.
    pub(crate) fn prepare(&mut self, items: &[Arc<Item>]) -> Result<(), NetworkError> {
        let mut prepare = items.iter().take(KEPT_ITEMS);
        tch::no_grad(|| prepare.try_for_each(|item| self.remember(item)))
    }

    /// Gives the best-scored placements per item: `share` of all placements, best first; equal
    /// scores by yaw, then cell.
    pub(crate) fn best(
        &mut self,
        heightmap: &Heightmap,
        items: &[&Item],
        share: Percent,
    ) -> Result<Vec<Vec<Placement>>, NetworkError> {
        let Scores { scores, fits } = self.score(heightmap, items)?;
        let cells = self.layout.cells();
        let mut first = 0;
        let mut best = Vec::with_capacity(items.len());
        for item in items {
            let maps = item.views().len();
            let range = first * cells..(first + maps) * cells;
            first += maps;
            let scores = scores.get(range.clone()).unwrap_or(&[]);
            let fits = fits.get(range).unwrap_or(&[]);
            let mut ranked: Vec<Ranked> = Vec::with_capacity(scores.len());
            for (index, (score, fits)) in scores.iter().zip(fits).enumerate() {
                if *fits {
                    ranked.push(Ranked::new(*score, index));
                }
            }
            let mut scored = scores.iter().zip(fits);
            if !scored.all(|(score, fits)| !fits || score.is_finite()) {
                return Err(NetworkError::Other(format!(
                    "the network's scores for item {} are not finite",
                    item.name()
                )));
            }
            let all = (maps * self.grid.nx() * self.grid.ny()) as u64;
            let wanted = share.of(all) as usize;
            if wanted < ranked.len() {
                ranked.select_nth_unstable(wanted);
                ranked.truncate(wanted);
            }
            ranked.sort_unstable();
            let placements = ranked.iter().filter_map(|ranked| {
                let (yaw, cell) = (ranked.index() / cells, ranked.index() % cells);
                let (x, y) = self.layout.corner_of(cell, item.views().get(yaw)?)?;
                Some(Placement { yaw, x, y })
            });
            best.push(placements.collect());
        }
        Ok(best)
    }

    /// Scores all items' placements, and says where they fit.
    pub(crate) fn score(
        &mut self,
        heightmap: &Heightmap,
        items: &[&Item],
    ) -> Result<Scores, NetworkError> {
        self.uses += 1;
        self.resting.update(heightmap, items.iter().copied());
        let cells = self.layout.cells();
        let maps: usize = items.iter().map(|item| item.views().len()).sum();
        let mut fits = vec![false; maps * cells];
        let mut resting = vec![0.0; maps * RESTING_CHANNELS as usize * cells];
        self.write_resting(items, &mut resting, &mut fits);
        if maps == 0 {
            let scores = Vec::new();
            return Ok(Scores { scores, fits });
        }
        let scores = tch::no_grad(|| self.run(heightmap, items, &resting))?;
        Ok(Scores { scores, fits })
    }

    fn write_resting(&mut self, items: &[&Item], resting: &mut [f32], fits: &mut [bool]) {
        let cells = self.layout.cells();
        let mut outputs = resting
            .chunks_exact_mut(RESTING_CHANNELS as usize * cells)
            .zip(fits.chunks_exact_mut(cells));
        for item in items {
            let lowest = lowest(&self.grid, item, self.resting.of(item));
            for (view, heights) in item.views().iter().zip(self.resting.of(item)) {
                let limit = limit(&self.grid, view);
                if let Some((resting, fits)) = outputs.next() {
                    self.layout
                        .write_resting(view, heights, limit, lowest, resting, fits);
                }
            }
        }
    }

    /// Runs the network; the scores are in the items' order.
    fn run(
        &mut self,
        heightmap: &Heightmap,
        items: &[&Item],
        resting: &[f32],
    ) -> Result<Vec<f32>, NetworkError> {
        for item in items {
            self.remember(item)?;
        }
        let mut container = vec![0.0; CONTAINER_CHANNELS as usize * self.layout.cells()];
        self.layout
            .write_container(heightmap.heights(), &mut container);
        runtime::use_one_thread();
        let cells = self.layout.cells() as i64;
        let containers = self.encode_container(&container)?;
        let fused = self.fuse(&containers, items)?;
        let resting = if self.network.architecture().resting_heights {
            let all = Tensor::f_from_slice(resting)?.f_view([-1, RESTING_CHANNELS, cells])?;
            Some(all.f_to(self.device)?)
        } else {
            None
        };
        let scores = self.network.score(&fused, resting.as_ref())?;
        let scores = scores.f_to(tch::Device::Cpu)?.f_contiguous()?.f_view(-1)?;
        Ok(Vec::try_from(scores)?)
    }

    /// Brings the features of the container and of all views together.
    fn fuse(&self, containers: &[Tensor], items: &[&Item]) -> Result<Vec<Tensor>, NetworkError> {
        let views = (0..containers.len()).map(|level| {
            let of_level = items
                .iter()
                .filter_map(|item| self.features.get(&item.shape())?.views.get(level));
            let of_level = on_one_canvas(&of_level.collect::<Vec<_>>())?;
            Tensor::f_cat(&of_level, 0)?.f_unsqueeze(0)
        });
        let views: Vec<Tensor> = views.collect::<Result<_, _>>()?;
        Ok(self.network.fuse(containers, &views)?)
    }

    fn encode_container(&self, maps: &[f32]) -> Result<Vec<Tensor>, NetworkError> {
        let padded = self.layout.padded;
        let shape = [1, CONTAINER_CHANNELS, padded.nx as i64, padded.ny as i64];
        let maps = Tensor::f_from_slice(maps)?.f_view(shape)?;
        Ok(self.network.encode_containers(&maps.f_to(self.device)?)?)
    }

    /// Makes sure that an item's features are kept.
    fn remember(&mut self, item: &Item) -> Result<(), NetworkError> {
        if let Some(kept) = self.features.get_mut(&item.shape()) {
            kept.last_used = self.uses;
            return Ok(());
        }
        if self.features.len() >= KEPT_ITEMS {
            let oldest = self.features.iter().min_by_key(|(_, kept)| kept.last_used);
            if let Some(shape) = oldest.map(|(shape, _)| *shape) {
                self.features.remove(&shape);
            }
        }
        runtime::use_one_thread();
        let views: Vec<&ItemView> = item.views().iter().collect();
        let stride = self.network.architecture().stride();
        let (maps, side) = self.layout.write_views(&views, stride);
        let shape = [-1, VIEW_CHANNELS, side as i64, side as i64];
        let maps = Tensor::f_from_slice(&maps)?.f_view(shape)?;
        let views = self.network.encode_views(&maps.f_to(self.device)?)?;
        let last_used = self.uses;
        let kept = ItemFeatures { views, last_used };
        self.features.insert(item.shape(), kept);
        Ok(())
    }
}

/// Features `[R, C, K, K]` of several items, with zeros around those on smaller canvases than the
/// greatest.
fn on_one_canvas(features: &[&Tensor]) -> Result<Vec<Tensor>, TchError> {
    let sides = features.iter().map(|features| Ok(features.size4()?.3));
    let sides: Vec<i64> = sides.collect::<Result<_, TchError>>()?;
    let greatest = sides.iter().copied().max().unwrap_or(0);
    let padded = features.iter().zip(sides).map(|(features, side)| {
        let margin = (greatest - side) / 2;
        if margin == 0 {
            Ok(features.shallow_clone())
        } else {
            features.f_constant_pad_nd([margin; 4])
        }
    });
    padded.collect()
}

#[cfg(test)]
mod tests;
