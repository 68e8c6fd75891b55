//! The planner service: keeps the packing session of each cell on disk, and decides which item goes where.
//!
//! A cell is a thread with a mailbox; cells know nothing of each other. Algorithm 1 is that of
//! [`packing`](ppnpack_packing); here its stages ask the services that are alive, and do without those that are not.

mod cell;
mod objects;
mod planning;
mod remote;
mod scenes;
mod session;
mod settings;
mod store;

use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Instant;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_service::Running;
use ppnpack_service::alive::{self, Alive};
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{self, Client, Incoming, Listener};
use ppnpack_service::stream::{self, Subscription};
use ppnpack_service::{HealthLatch, ServiceError, join};
use ppnpack_wire::keys::{Cell, KeyError, Service, Stream};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};

use cell::{CellPlanner, Command, Shared};
use objects::Objects;
use planning::Helpers;
pub use settings::{CellSettings, ProposalSettings, Settings, Stability, Where};
use store::Store;
pub use store::StoreError;

/// Why the service did not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// The process lacks something.
    #[error(transparent)]
    Service(#[from] ServiceError),
    /// The sessions cannot be had.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A cell has an impossible name.
    #[error(transparent)]
    Name(#[from] KeyError),
    /// A cell's settings are not possible.
    #[error("{0}")]
    Cell(String),
    /// A thread cannot be started.
    #[error("a thread cannot be started: {0}")]
    Thread(#[source] std::io::Error),
}

/// The running service.
pub struct PlannerService {
    alive: Vec<alive::Token>,
    listeners: Vec<Listener>,
    outcomes: Vec<Subscription>,
    mailboxes: Vec<SyncSender<Command>>,
    threads: Vec<JoinHandle<()>>,
    ready: HealthLatch,
}

/// Starts the service; `catalogues` has the objects that can be announced by name, one for each resolution of a cell.
///
/// # Errors
/// [`StartError`] where the store, the session or a thread cannot be had, or a setting is not possible.
pub fn start(
    process: &Process,
    settings: &Settings,
    catalogues: &[Arc<Catalogue>],
) -> Result<PlannerService, StartError> {
    let store_health = process.health().check("session_store");
    let cells_health = process.health().check("cells");
    let shared = Shared {
        store: Arc::new(Store::open(settings.store.as_deref())?),
        store_health: store_health.clone(),
        objects: Arc::new(Objects::new(catalogues)),
        helpers: Helpers {
            client: Client::new(process.session()).of_planner(process.instance()),
            ppn: Arc::new(Alive::watch(process.session(), Service::Ppn)?),
            heuristic: Arc::new(Alive::watch(process.session(), Service::Heuristic)?),
        },
    };
    store_health.pass();
    let mut service = PlannerService {
        alive: Vec::new(),
        listeners: Vec::new(),
        outcomes: Vec::new(),
        mailboxes: Vec::new(),
        threads: Vec::new(),
        ready: cells_health,
    };
    for (name, cell_settings) in &settings.cells {
        let cell = Cell::new(name)?;
        let planner = CellPlanner::new(process, &cell, cell_settings, &shared)?;
        service.serve(process, &cell, planner, settings.queue.max(1))?;
    }
    service.ready.pass();
    Ok(service)
}

impl PlannerService {
    fn serve(
        &mut self,
        process: &Process,
        cell: &Cell,
        planner: CellPlanner,
        queue: usize,
    ) -> Result<(), StartError> {
        let (mailbox, commands) = sync_channel(queue);
        let thread = std::thread::Builder::new()
            .name(format!("cell-{cell}"))
            .spawn(move || planner.run(&commands))
            .map_err(StartError::Thread)?;
        self.threads.push(thread);
        self.listen(process, cell, &mailbox, Command::Begin)?;
        self.listen(process, cell, &mailbox, Command::Announce)?;
        self.listen(process, cell, &mailbox, Command::Withdraw)?;
        self.listen(process, cell, &mailbox, Command::Plan)?;
        self.listen(process, cell, &mailbox, Command::Report)?;
        self.listen(process, cell, &mailbox, Command::Explain)?;
        self.listen(process, cell, &mailbox, Command::Automatic)?;
        self.listen(process, cell, &mailbox, Command::Session)?;
        let outcomes = mailbox.clone();
        self.outcomes.push(stream::subscribe(
            process,
            Some(cell),
            Stream::Outcome,
            MAX_MESSAGE_BYTES,
            move |_, outcome: v1::Outcome| {
                // Where the mailbox is full the outcome is asked for later.
                if outcomes.try_send(Command::Outcome(outcome)).is_err() {
                    tracing::debug!("an outcome did not fit into the mailbox");
                }
            },
        )?);
        self.alive.push(alive::announce(process, Some(cell))?);
        self.mailboxes.push(mailbox);
        Ok(())
    }

    fn listen<R: Request>(
        &mut self,
        process: &Process,
        cell: &Cell,
        mailbox: &SyncSender<Command>,
        wrap: fn(Incoming<R>) -> Command,
    ) -> Result<(), StartError> {
        let mailbox = mailbox.clone();
        let listener = rpc::listen(process, Some(cell), move |incoming: Incoming<R>| {
            rpc::deliver(&mailbox, incoming, wrap);
        })?;
        self.listeners.push(listener);
        Ok(())
    }
}

impl Running for PlannerService {
    fn finish(self: Box<Self>, deadline: Instant) -> Result<(), String> {
        let Self {
            alive,
            listeners,
            outcomes,
            mailboxes,
            threads,
            ready: _ready,
        } = *self;
        drop((alive, listeners, outcomes));
        for mailbox in mailboxes {
            // A full mailbox is emptied first; the thread then sees that nobody can send any more.
            drop(mailbox.try_send(Command::Stop));
        }
        join(threads, deadline)
    }
}
