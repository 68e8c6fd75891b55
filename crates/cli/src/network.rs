//! Networks as seen from the commands, which know libtorch only through [`Backend`].

use std::sync::Arc;

use anyhow::Result;
use ppnpack_model::card::ModelCard;
use ppnpack_model::report::TrainingEvent;
use ppnpack_model::settings::{Device, TrainingRequest};
use ppnpack_model::weights::Model;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::ranking::proposals::{Percent, Proposer};

/// Settings by which a network proposes.
#[derive(Debug, Clone, Copy)]
pub struct Proposing<'a> {
    /// The grid that it proposes on.
    pub grid: &'a Grid,
    /// The share of an item's placements that it proposes.
    pub share: Percent,
    /// The device that it runs on.
    pub device: Device,
    /// The items that are known ahead of time.
    pub items: &'a [Arc<Item>],
}

/// Opens and trains networks.
pub trait Backend: Sync {
    /// Prepares for a command that may use a network; may hand this process over to one that can.
    fn prepare(&self) {}

    /// Makes a proposer that runs a model.
    ///
    /// # Errors
    /// Why the network cannot run here, with a remedy.
    fn open(&self, model: &Model, how: &Proposing<'_>) -> Result<Box<dyn Proposer>>;

    /// Opens a model for the ppn service.
    ///
    /// # Errors
    /// Why the network cannot run here, with a remedy.
    fn network(
        &self,
        model: &Model,
        device: Device,
    ) -> Result<Box<dyn ppnpack_ppn_service::Network>>;

    /// Trains a network, or goes on training; gives the card of the model that it leaves in the
    /// request's folder.
    ///
    /// # Errors
    /// What kept the training from its end.
    fn train(
        &self,
        request: &TrainingRequest,
        watch: &mut dyn FnMut(TrainingEvent),
    ) -> Result<ModelCard>;
}
