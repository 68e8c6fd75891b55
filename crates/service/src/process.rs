//! The process of a service, and threads.

use std::collections::BTreeMap;
use std::hash::{BuildHasher, RandomState};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Instant;

use ppnpack_wire::keys::{Cell, Instance, Service, Start};
use ppnpack_wire::v1;
use zenoh::Session;

use crate::clock::now_ns;
use crate::error::ServiceError;
use crate::health::Health;
use crate::rpc::{self, Listener};
use crate::shutdown::Shutdown;
use crate::supervision::Supervisor;
use crate::sync::lock;

/// The process that a service runs on: its Zenoh session and name, its health, and the wish that
/// it ends. Cheap to clone.
#[derive(Clone)]
pub struct Process {
    inner: Arc<Inner>,
}

struct Inner {
    session: Session,
    max_message_bytes: usize,
    core: Arc<Core>,
    _answers_health: Listener,
}

/// All of a process but its session: the admin port tells of it before there is one.
pub(crate) struct Core {
    pub(crate) service: Service,
    pub(crate) instance: Instance,
    /// Tells the process from others of its name: the nonce of its [`Start`].
    pub(crate) nonce: u64,
    pub(crate) health: Health,
    pub(crate) supervisor: Supervisor,
    pub(crate) has_started: AtomicBool,
    /// The hash of its configuration.
    configuration: String,
    model: Mutex<Option<String>>,
    /// The cells that it was announced for, and how often.
    cells: Mutex<BTreeMap<Cell, usize>>,
    began: Instant,
}

impl Core {
    pub(crate) fn new(
        service: Service,
        instance: Instance,
        configuration: String,
        supervisor: Supervisor,
    ) -> Self {
        let random = RandomState::new().hash_one(()) & u64::from(u32::MAX);
        Self {
            service,
            instance,
            nonce: ((now_ns() / 1_000_000_000) << 32) | random,
            health: Health::default(),
            supervisor,
            has_started: AtomicBool::new(false),
            configuration,
            model: Mutex::default(),
            cells: Mutex::default(),
            began: Instant::now(),
        }
    }

    /// Gives the start of the process, which has served a cell after so many others.
    pub(crate) fn start(&self, term: u32) -> Start {
        let nonce = self.nonce;
        Start { term, nonce }
    }

    pub(crate) fn versions(&self, model: Option<&str>) -> v1::Versions {
        v1::Versions {
            software: env!("CARGO_PKG_VERSION").to_owned(),
            model: model.unwrap_or_default().to_owned(),
            configuration: self.configuration.clone(),
            instance: self.instance.to_string(),
        }
    }

    pub(crate) fn model(&self) -> Option<String> {
        lock(&self.model).clone()
    }

    pub(crate) fn add_cell(&self, cell: &Cell) {
        *lock(&self.cells).entry(cell.clone()).or_default() += 1;
    }

    pub(crate) fn remove_cell(&self, cell: &Cell) {
        let mut cells = lock(&self.cells);
        match cells.get_mut(cell) {
            Some(count) if *count > 1 => *count -= 1,
            _ => drop(cells.remove(cell)),
        }
    }

    pub(crate) fn health_reply(&self) -> v1::HealthReply {
        v1::HealthReply {
            header: None,
            service: self.service.to_string(),
            is_ready: self.health.is_ready(),
            checks: self.health.report(),
            uptime_ns: u64::try_from(self.began.elapsed().as_nanos()).unwrap_or(u64::MAX),
            cells: lock(&self.cells).keys().map(Cell::to_string).collect(),
        }
    }
}

impl Process {
    /// Makes a process on this session, which answers for its health over Zenoh from here on.
    pub(crate) fn new(
        session: Session,
        max_message_bytes: usize,
        core: Arc<Core>,
    ) -> Result<Self, ServiceError> {
        let inner = Inner {
            _answers_health: rpc::answer_health(&session, &core)?,
            session,
            max_message_bytes,
            core,
        };
        let inner = Arc::new(inner);
        Ok(Self { inner })
    }

    /// Its Zenoh session.
    pub fn session(&self) -> &Session {
        &self.inner.session
    }

    /// The largest message that it takes, and that others are to take.
    pub(crate) fn max_message_bytes(&self) -> usize {
        self.inner.max_message_bytes
    }

    /// Its name among those of its service.
    pub fn instance(&self) -> &Instance {
        &self.core().instance
    }

    /// Its service.
    pub fn service(&self) -> Service {
        self.core().service
    }

    /// The versions that made its answers, but for the network.
    pub fn versions(&self) -> v1::Versions {
        self.core().versions(None)
    }

    /// Its health.
    pub fn health(&self) -> &Health {
        &self.core().health
    }

    /// The wish that it ends.
    pub fn shutdown(&self) -> &Shutdown {
        self.supervisor().shutdown()
    }

    /// The supervisor of its threads.
    pub fn supervisor(&self) -> &Supervisor {
        &self.core().supervisor
    }

    /// Sets the network that it runs, for `/info`.
    pub fn set_model(&self, model: Option<String>) {
        *lock(&self.core().model) = model;
    }

    /// Gives the process as long as somebody else has it; does not keep its session open.
    pub(crate) fn weak(&self) -> impl Fn() -> Option<Self> + Send + use<> {
        let inner = Arc::downgrade(&self.inner);
        move || inner.upgrade().map(|inner| Self { inner })
    }

    pub(crate) fn core(&self) -> &Arc<Core> {
        &self.inner.core
    }
}

impl std::fmt::Debug for Process {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "Process({}/{})", self.service(), self.instance())
    }
}

/// Starts a thread with a name that the process can do without; see [`Supervisor::thread`].
///
/// # Errors
/// [`ServiceError::System`] where there can be no more threads.
pub fn thread<T: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<JoinHandle<T>, ServiceError> {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(work)
        .map_err(|source| ServiceError::System {
            what: "starting a thread",
            source,
        })
}
