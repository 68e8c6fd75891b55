//! Networks for the ppn service.

use anyhow::Result;
use ppnpack_model::settings::Device;
use ppnpack_model::weights::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::ranking::proposals::Percent;
use ppnpack_packing::ranking::step::StageError;
use ppnpack_ppn::proposer::NetworkProposer;
use ppnpack_ppn_service::{Network, ScoredItems, ScoredStep, Scorer, Settings};

/// A model that runs on the libtorch that this program is linked with.
pub struct TorchNetwork {
    model: Model,
    device: Device,
    name: String,
}

impl TorchNetwork {
    /// Reads the model of a service's settings.
    ///
    /// # Errors
    /// [`ModelError`](ppnpack_model::weights::ModelError) where the weights cannot be read.
    pub fn read(settings: &Settings) -> Result<Self> {
        let model = match &settings.model {
            Some(file) => Model::read(file)?,
            None => Model::shipped()?,
        };
        let device = match settings.device {
            ppnpack_ppn_service::Device::Cpu => Device::Cpu,
            ppnpack_ppn_service::Device::Cuda => Device::Cuda,
        };
        Ok(Self::new(model, device))
    }

    /// Makes a network of a model on a device.
    pub fn new(model: Model, device: Device) -> Self {
        let name = model.card().weights_blake3.chars().take(16).collect();
        Self {
            model,
            device,
            name,
        }
    }
}

impl Network for TorchNetwork {
    fn model(&self) -> &str {
        &self.name
    }

    fn open(&self, grid: &Grid) -> Result<Box<dyn Scorer>, StageError> {
        // Requests carry their own share.
        let share = Percent::new(100.0)?;
        let proposer = NetworkProposer::new(&self.model, grid, share, self.device, &[])?;
        Ok(Box::new(TorchScorer(proposer)))
    }
}

struct TorchScorer(NetworkProposer);

impl Scorer for TorchScorer {
    fn best(&mut self, step: &ScoredStep<'_>) -> Result<ScoredItems, StageError> {
        Ok(self.0.best(step.heightmap, step.items, step.share)?)
    }
}
