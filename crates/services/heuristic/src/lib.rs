//! The heuristic service: the best valid placements of a step.
//!
//! It serves any cell. Each worker thread keeps the searches of the cells that are routed to it, with the memory that
//! they need.

mod evaluate;
mod settings;
mod worker;

use std::sync::{Arc, Mutex};
use std::time::Instant;

use ppnpack_service::Running;
use ppnpack_service::actor::{self, Address};
use ppnpack_service::alive::Alive;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{self, Listener};
use ppnpack_service::{HealthLatch, ServiceError, alive};
use ppnpack_wire::item_store::ItemStore;
use ppnpack_wire::keys::Service;

pub use settings::Settings;
use worker::{Evaluate, Worker};

/// The running service.
pub struct Heuristic {
    // Requests stop coming before the workers end: fields are dropped in this order.
    alive: alive::Token,
    listener: Listener,
    _ready: HealthLatch,
    workers: Vec<std::thread::JoinHandle<()>>,
}

/// Starts the service.
///
/// # Errors
/// [`ServiceError`] where the session or the threads cannot be had.
pub fn start(process: &Process, settings: &Settings) -> Result<Heuristic, ServiceError> {
    let ready = process.health().check("workers");
    let items = Arc::new(Mutex::new(ItemStore::new(settings.items_kept_mib << 20)));
    let planners = Arc::new(Alive::watch(process.session(), Service::Planner)?);
    let mut addresses = Vec::new();
    let mut workers = Vec::new();
    for index in 0..settings.workers.max(1) {
        let (address, mailbox) = actor::mailbox(settings.queue.max(1));
        let worker = Worker::new(Arc::clone(&items), Arc::clone(&planners), settings)?;
        let name = format!("heuristic-{index}");
        workers.push(actor::spawn(process, &name, worker, mailbox)?);
        addresses.push(address);
    }
    let routes: Vec<Address<Evaluate>> = addresses;
    // The requests of one cell always go to the same worker, which has its searches.
    let evaluate = move |incoming: Evaluate| {
        let sum: usize = incoming.cell().as_str().bytes().map(usize::from).sum();
        if let Some(route) = routes.get(sum % routes.len().max(1)) {
            route.deliver(incoming, |incoming| incoming);
        }
    };
    let listener = rpc::listen(process, None, evaluate)?;
    let alive = alive::announce(process, None)?;
    ready.pass();
    Ok(Heuristic {
        alive,
        listener,
        _ready: ready,
        workers,
    })
}

impl Running for Heuristic {
    fn finish(self: Box<Self>, deadline: Instant) -> Result<(), String> {
        // Without the listener nobody has the workers' addresses: they end when their mailboxes are empty.
        drop((self.alive, self.listener));
        ppnpack_service::join(self.workers, deadline)
    }
}
