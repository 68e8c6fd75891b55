//! Networks for the commands of `ppnpack`.

use anyhow::Result;
use ppnpack_cli::network::{Backend, Proposing};
use ppnpack_model::card::ModelCard;
use ppnpack_model::report::TrainingEvent;
use ppnpack_model::settings::{Device, TrainingRequest};
use ppnpack_model::weights::Model;
use ppnpack_packing::ranking::proposals::Proposer;
use ppnpack_ppn::proposer::NetworkProposer;
use ppnpack_ppn::training;

use crate::service::TorchNetwork;

/// Networks on the libtorch that this program is linked with.
#[derive(Debug, Clone, Copy, Default)]
pub struct Torch;

impl Backend for Torch {
    fn open(&self, model: &Model, how: &Proposing<'_>) -> Result<Box<dyn Proposer>> {
        let proposer = NetworkProposer::new(model, how.grid, how.share, how.device, how.items)?;
        Ok(Box::new(proposer))
    }

    fn network(
        &self,
        model: &Model,
        device: Device,
    ) -> Result<Box<dyn ppnpack_ppn_service::Network>> {
        Ok(Box::new(TorchNetwork::new(model.clone(), device)))
    }

    fn train(
        &self,
        request: &TrainingRequest,
        watch: &mut dyn FnMut(TrainingEvent),
    ) -> Result<ModelCard> {
        Ok(training::train(request, watch)?)
    }
}
