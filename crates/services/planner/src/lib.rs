//! The planner service: keeps each cell's session on disk, and decides which item goes where.
//!
//! A cell is an actor; cells know nothing of each other. Algorithm 1 is that of
//! [`packing`](ppnpack_packing); here its stages ask the services that are alive, and do without
//! those that are not.

mod bridge;
mod cell;
mod counts;
mod fill;
mod objects;
mod orders;
mod planning;
mod record;
mod refusal;
mod remote;
pub mod replay;
mod scenes;
mod settings;
mod shapes;
mod step;
mod store;

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_physics::trial;
use ppnpack_protocol::session::AFTER_ANOTHER;
use ppnpack_service::Running;
use ppnpack_service::actor::{self, Address};
use ppnpack_service::alive::Alive;
use ppnpack_service::lease::{self, Lease};
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{Client, Listener};
use ppnpack_service::stream::{self, Subscription};
use ppnpack_service::{HealthLatch, ServiceError, join};
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};

use cell::{CellPlanner, Message, Shared};
use objects::Objects;
use planning::Helpers;
pub use settings::{CellSettings, ClosingSettings, ContainerSettings, Settings, Where};
use store::Store;

/// The running service.
pub struct PlannerService {
    leases: Vec<Lease>,
    listeners: Vec<Listener>,
    outcomes: Vec<Subscription>,
    threads: Vec<JoinHandle<()>>,
    ready: HealthLatch,
}

/// Starts the service; `catalogues` has the objects that can be announced by name, one for each
/// resolution of a cell.
///
/// # Errors
/// [`ServiceError`] where the store, the session, a thread or a setting is not possible.
pub fn start(
    process: &Process,
    settings: &Settings,
    catalogues: &[Arc<Catalogue>],
) -> Result<PlannerService, ServiceError> {
    let store_health = process.health().check("session_store");
    let cells_health = process.health().check("cells");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let shape_bytes = (settings.shapes_mib as u64) << 20;
    let store = Store::open(settings.store.as_deref(), shape_bytes);
    let shared = Shared {
        store: store.map_err(ServiceError::start)?,
        store_health,
        objects: Objects::new(catalogues),
        helpers: Helpers {
            client: Client::new(process.session()).of_planner(process.instance()),
            ppn: Arc::new(Alive::watch(process.session(), Service::Ppn)?),
            heuristic: Arc::new(Alive::watch(process.session(), Service::Heuristic)?),
            threads: trial::pool(cores).map_err(ServiceError::start)?,
        },
    };
    shared.store_health.pass();
    let shared = Arc::new(shared);
    let mut service = PlannerService {
        leases: Vec::new(),
        listeners: Vec::new(),
        outcomes: Vec::new(),
        threads: Vec::new(),
        ready: cells_health,
    };
    let cells = settings.cells.keys().map(|name| Cell::new(name).map(Some));
    let cells: Vec<Option<Cell>> = cells.collect::<Result<_, _>>()?;
    lease::take_each(process, cells, |cell, lease| {
        let own = cell.and_then(|cell| Some((cell, settings.cells.get(cell.as_str())?)));
        own.map_or(Ok(()), |(cell, own)| {
            service.add(process, settings.queue, cell, own, &shared, lease)
        })
    })?;
    service.ready.pass();
    Ok(service)
}

impl PlannerService {
    /// Starts the actor of a cell, and has it take requests.
    fn add(
        &mut self,
        process: &Process,
        queue: usize,
        cell: &Cell,
        settings: &CellSettings,
        shared: &Arc<Shared>,
        lease: Lease,
    ) -> Result<(), ServiceError> {
        if lease.is_after_another {
            let settled = shared.store.settle(cell, AFTER_ANOTHER);
            settled.map_err(ServiceError::start)?;
        }
        self.leases.push(lease);
        let (address, mailbox) = actor::mailbox(queue.max(1));
        let own = address.downgrade();
        let (planner, stepper) = CellPlanner::new(process, cell, settings, shared, own)?;
        let thread = actor::spawn(process, &format!("cell-{cell}"), planner, mailbox)?;
        self.threads.extend([thread, stepper]);
        self.listen(process, cell, &address)?;
        for container in settings.container_plans(cell)? {
            self.hear(process, &container.address, &address)?;
        }
        Ok(())
    }

    /// Has a cell's actor take requests.
    fn listen(
        &mut self,
        process: &Process,
        cell: &Cell,
        address: &Address<Message>,
    ) -> Result<(), ServiceError> {
        self.listeners.extend([
            address.listen(process, Some(cell), Message::Begin)?,
            address.listen(process, Some(cell), Message::Announce)?,
            address.listen(process, Some(cell), Message::Withdraw)?,
            address.listen(process, Some(cell), Message::Plan)?,
            address.listen(process, Some(cell), Message::Report)?,
            address.listen(process, Some(cell), Message::Open)?,
            address.listen(process, Some(cell), Message::Close)?,
            address.listen(process, Some(cell), Message::Explain)?,
            address.listen(process, Some(cell), Message::Automatic)?,
            address.listen(process, Some(cell), Message::Session)?,
            address.listen(process, Some(cell), Message::Shapes)?,
        ]);
        Ok(())
    }

    /// Has a cell's actor take the outcomes that the bridge tells of one of its containers.
    fn hear(
        &mut self,
        process: &Process,
        container: &Cell,
        address: &Address<Message>,
    ) -> Result<(), ServiceError> {
        let outcomes = address.clone();
        self.outcomes.push(stream::subscribe(
            process.session(),
            Some(container),
            Stream::Outcome,
            MAX_MESSAGE_BYTES,
            move |_, outcome: v1::Outcome| {
                // Where the mailbox is full the outcome is asked for later.
                if !outcomes.try_send(Message::Outcome(outcome)) {
                    tracing::debug!("an outcome did not fit into the mailbox");
                }
            },
        )?);
        Ok(())
    }
}

impl Running for PlannerService {
    fn finish(self: Box<Self>, deadline: Instant) -> Result<(), String> {
        // Without these nobody has the cells' addresses: they end when their mailboxes are empty.
        drop((self.leases, self.listeners, self.outcomes));
        join(self.threads, deadline)
    }
}
