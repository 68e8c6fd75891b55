//! The ppn service: which placements the network scores best, for the planners of any cell, or of
//! those that are named.
//!
//! One thread owns the network; requests wait for it in a bounded queue. The network itself is
//! behind the traits [`Network`] and [`Scorer`]: this crate does not link libtorch.

mod settings;
mod worker;

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::kernel::placement::Placement;
use ppnpack_packing::ranking::proposals::Percent;
use ppnpack_packing::ranking::step::StageError;
use ppnpack_service::configuration;
use ppnpack_service::process::Process;
use ppnpack_service::{OneWorker, ServiceError};

pub use settings::{Device, Settings};
use worker::Worker;

/// A network that can be made ready for grids.
pub trait Network: Send {
    /// The first 16 hexadecimal digits of the hash of its weights.
    fn model(&self) -> &str;

    /// The network, ready to score placements on a grid.
    ///
    /// # Errors
    /// What keeps it from running there.
    fn open(&self, grid: &Grid) -> Result<Box<dyn Scorer>, StageError>;
}

/// A network on one grid.
pub trait Scorer: Send {
    /// The best placements of the items of a step.
    ///
    /// # Errors
    /// What keeps the network from scoring them.
    fn best(&mut self, step: &ScoredStep<'_>) -> Result<ScoredItems, StageError>;
}

/// The best placements of a step's items by the network: per item, those that score best, in order.
pub type ScoredItems = Vec<Vec<Placement>>;

/// A step whose items are to be scored.
#[derive(Debug, Clone, Copy)]
pub struct ScoredStep<'a> {
    /// The container.
    pub heightmap: &'a Heightmap,
    /// The candidates.
    pub items: &'a [&'a Item],
    /// How many of their placements are wanted.
    pub share: Percent,
}

/// Why the service did not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// The process lacks something.
    #[error(transparent)]
    Service(#[from] ServiceError),
    /// The network does not run.
    #[error("the network cannot run here: {0}")]
    Network(#[source] StageError),
}

/// Starts the service; it is ready when the network has run on the reference grid.
///
/// # Errors
/// [`StartError`] where the network does not run, or the session or a thread cannot be had.
pub fn start(
    process: &Process,
    settings: &Settings,
    network: Box<dyn Network>,
) -> Result<OneWorker, StartError> {
    let ready = process.health().check("network");
    process.set_model(Some(network.model().to_owned()));
    let cells = configuration::cells(&settings.cells).map_err(ServiceError::start)?;
    let mut worker = Worker::new(network, settings);
    worker.warm_up().map_err(StartError::Network)?;
    let started = OneWorker::start(process, "network", ready, &cells, settings.queue, worker);
    Ok(started?)
}
