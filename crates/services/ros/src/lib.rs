//! The cells in ROS 2: their streams as topics, their requests as services.
//!
//! It is a client of the stack like any other, and a node of ROS as `rmw_zenoh` has them, on the
//! stack's own router or on that of ROS. Each cell that is there, and each container, has its
//! topics below a name of its own.

mod cells;
mod convert;
mod error;
mod face;
mod requests;
mod rmw;
mod settings;
#[cfg(test)]
mod tests;

use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ppnpack_service::configuration::ZenohSettings;
use ppnpack_service::process::Process;
use ppnpack_service::{HealthLatch, Running, ServiceError, ServiceSettings, Shutdown, alive};
use zenoh::{Session, Wait};

use cells::Cells;
use rmw::Node;
use rmw::keys::Name;
pub use settings::Settings;

const LOOK: Duration = Duration::from_secs(1);

/// The running service.
pub struct Ros {
    // Nobody finds it any more before it ends: fields are dropped in this order.
    alive: alive::Token,
    _ready: HealthLatch,
    shutdown: Shutdown,
    thread: JoinHandle<()>,
    /// The session with ROS, where it is not the stack's.
    session: Option<Session>,
}

/// Starts the service.
///
/// # Errors
/// [`ServiceError`] where a setting is not possible, the router of ROS is away, or the session or a
/// thread cannot be had.
pub fn start(process: &Process, settings: &Settings) -> Result<Ros, ServiceError> {
    settings.validate().map_err(ServiceError::start)?;
    let ready = process.health().check("ros");
    let session = open(settings)?;
    let own = session.as_ref().unwrap_or(process.session());
    let name = Name::new(&settings.namespace).map_err(ServiceError::start)?;
    let node = Node::new(own, settings.domain, &name).map_err(ServiceError::start)?;
    let shutdown = process.shutdown().of_part();
    let mut cells = Cells::new(process, node, settings).map_err(ServiceError::start)?;
    let ended = shutdown.clone();
    let thread = process.supervisor().thread("ros-cells", move || {
        while !ended.is_requested() {
            cells.look();
            ended.wait_timeout(LOOK);
        }
    })?;
    let alive = alive::announce(process, None)?;
    ready.pass();
    tracing::info!(domain = settings.domain, namespace = %name, "in ROS 2");
    Ok(Ros {
        alive,
        _ready: ready,
        shutdown,
        thread,
        session,
    })
}

/// Opens a session with the router of ROS, where that is another one.
fn open(settings: &Settings) -> Result<Option<Session>, ServiceError> {
    if settings.connect.0.is_empty() {
        return Ok(None);
    }
    let endpoints = settings.connect.0.join(", ");
    let zenoh = ZenohSettings {
        connect: Some(settings.connect.clone()),
        ..ZenohSettings::default()
    };
    let opened = zenoh::open(zenoh.to_zenoh()?).wait();
    let opened = opened.map_err(|error| {
        ServiceError::start(format_args!(
            "the router of ROS at {endpoints} cannot be reached: {error}"
        ))
    });
    opened.map(Some)
}

impl Running for Ros {
    fn finish(self: Box<Self>, deadline: Instant) -> Result<(), String> {
        drop(self.alive);
        self.shutdown.request();
        let ended = ppnpack_service::join(vec![self.thread], deadline);
        if let Some(session) = self.session
            && let Err(error) = session.close().wait()
        {
            tracing::debug!(%error, "closing the session with ROS");
        }
        ended
    }
}
