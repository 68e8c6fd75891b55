//! The heuristic service: the best valid placements of a step.
//!
//! It serves any cell, or those that are named. Its worker, one thread, keeps the searches of the
//! cells that ask it, with the memory that they need.

mod evaluate;
mod settings;
mod worker;

use ppnpack_service::configuration;
use ppnpack_service::process::Process;
use ppnpack_service::{OneWorker, ServiceError};

pub use settings::Settings;
use worker::Worker;

/// Starts the service.
///
/// # Errors
/// [`ServiceError`] where the session or a thread cannot be had.
pub fn start(process: &Process, settings: &Settings) -> Result<OneWorker, ServiceError> {
    let ready = process.health().check("workers");
    let worker = Worker::new(settings);
    let cells = configuration::cells(&settings.cells).map_err(ServiceError::start)?;
    OneWorker::start(process, "heuristic", ready, &cells, settings.queue, worker)
}
