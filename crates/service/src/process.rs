//! What a service runs on.

use std::collections::BTreeMap;
use std::hash::{BuildHasher, RandomState};
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

/// What a service runs on: its Zenoh session, name, health, and the wish to end. Cheap to clone.
#[derive(Clone)]
pub struct Process {
    inner: Arc<Inner>,
}

struct Inner {
    session: Session,
    max_message_bytes: usize,
    identity: Arc<Identity>,
    health: Health,
    shutdown: Shutdown,
    supervisor: Supervisor,
    _answers_health: Listener,
}

/// Who a process is, and what it says of itself.
pub(crate) struct Identity {
    pub(crate) service: Service,
    pub(crate) instance: Instance,
    /// Tells it from others of its name, as long as it serves after nobody.
    pub(crate) start: Start,
    /// The hash of its configuration.
    configuration: String,
    model: Mutex<Option<String>>,
    /// The cells that it said it is there for, and how often.
    cells: Mutex<BTreeMap<Cell, usize>>,
    started: Instant,
}

impl Identity {
    pub(crate) fn new(service: Service, instance: Instance, configuration: String) -> Self {
        Self {
            service,
            instance,
            start: fresh_start(),
            configuration,
            model: Mutex::default(),
            cells: Mutex::default(),
            started: Instant::now(),
        }
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

    /// What it answers when asked for its health.
    pub(crate) fn health_reply(&self, health: &Health) -> v1::HealthReply {
        v1::HealthReply {
            header: None,
            service: self.service.to_string(),
            is_ready: health.is_ready(),
            checks: health.report(),
            uptime_ns: u64::try_from(self.started.elapsed().as_nanos()).unwrap_or(u64::MAX),
            cells: lock(&self.cells).keys().map(Cell::to_string).collect(),
        }
    }
}

/// A start unlike any other.
fn fresh_start() -> Start {
    let random = RandomState::new().hash_one(()) & u64::from(u32::MAX);
    Start {
        term: 0,
        nonce: ((now_ns() / 1_000_000_000) << 32) | random,
    }
}

impl Process {
    /// A process on this session. From here on it answers for its health over Zenoh.
    pub(crate) fn new(
        session: Session,
        max_message_bytes: usize,
        identity: Arc<Identity>,
        health: Health,
        shutdown: Shutdown,
        supervisor: Supervisor,
    ) -> Result<Self, ServiceError> {
        let answers_health = rpc::answer_health(&session, &identity, &health)?;
        let inner = Inner {
            session,
            max_message_bytes,
            identity,
            health,
            shutdown,
            supervisor,
            _answers_health: answers_health,
        };
        Ok(Self {
            inner: Arc::new(inner),
        })
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
        &self.inner.identity.instance
    }

    /// Its service.
    pub fn service(&self) -> Service {
        self.inner.identity.service
    }

    /// What made its answers, but for the network.
    pub fn versions(&self) -> v1::Versions {
        self.inner.identity.versions(None)
    }

    /// What it needs, and whether it has it.
    pub fn health(&self) -> &Health {
        &self.inner.health
    }

    /// The wish that it ends.
    pub fn shutdown(&self) -> &Shutdown {
        &self.inner.shutdown
    }

    /// Who watches its threads.
    pub fn supervisor(&self) -> &Supervisor {
        &self.inner.supervisor
    }

    /// The network that it runs, for `/info`.
    pub fn set_model(&self, model: Option<String>) {
        *lock(&self.inner.identity.model) = model;
    }

    /// Gives the process as long as somebody else has it; does not keep its session open.
    pub(crate) fn weak(&self) -> impl Fn() -> Option<Self> + Send + use<> {
        let inner = Arc::downgrade(&self.inner);
        move || inner.upgrade().map(|inner| Self { inner })
    }

    pub(crate) fn identity(&self) -> &Arc<Identity> {
        &self.inner.identity
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
