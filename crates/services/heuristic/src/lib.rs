//! The heuristic service: the best valid placements of a step.
//!
//! It serves any cell. Its worker, one thread, keeps the searches of the cells that ask it, with the memory that they need.

mod evaluate;
mod settings;
mod worker;

use std::time::Instant;

use ppnpack_service::Running;
use ppnpack_service::actor;
use ppnpack_service::alive::Alive;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::Listener;
use ppnpack_service::{HealthLatch, ServiceError, alive};
use ppnpack_wire::keys::Service;

pub use settings::Settings;
use worker::Worker;

/// The running service.
pub struct Heuristic {
    // Requests stop coming before the worker ends: fields are dropped in this order.
    alive: alive::Token,
    listener: Listener,
    _ready: HealthLatch,
    thread: std::thread::JoinHandle<()>,
}

/// Starts the service.
///
/// # Errors
/// [`ServiceError`] where the session or a thread cannot be had.
pub fn start(process: &Process, settings: &Settings) -> Result<Heuristic, ServiceError> {
    let ready = process.health().check("workers");
    let planners = Alive::watch(process.session(), Service::Planner)?;
    let (address, mailbox) = actor::mailbox(settings.queue.max(1));
    let worker = Worker::new(planners, settings)?;
    let thread = actor::spawn(process, "heuristic", worker, mailbox)?;
    let listener = address.listen(process, None, |incoming| incoming)?;
    let alive = alive::announce(process, None)?;
    ready.pass();
    Ok(Heuristic {
        alive,
        listener,
        _ready: ready,
        thread,
    })
}

impl Running for Heuristic {
    fn finish(self: Box<Self>, deadline: Instant) -> Result<(), String> {
        // Without the listener nobody has the worker's address: it ends when its mailbox is empty.
        drop((self.alive, self.listener));
        ppnpack_service::join(vec![self.thread], deadline)
    }
}
