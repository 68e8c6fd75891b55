//! The Zenoh session of a process: opened, watched, closed.

use std::time::Duration;

use zenoh::{Session, Wait};

use crate::configuration::{Mode, ZenohSettings};
use crate::error::ServiceError;
use crate::health::HealthLatch;
use crate::process::{Process, thread};
use crate::shutdown::Shutdown;

/// How long to wait before a client tries to connect again: at first, and at most.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

/// How often the connection is looked at.
const WATCH_PERIOD: Duration = Duration::from_millis(500);

/// Opens the session. A client tries until there is a router, or until the end is asked for (`None`).
pub(crate) fn open(
    settings: &ZenohSettings,
    latch: &HealthLatch,
    shutdown: &Shutdown,
) -> Result<Option<Session>, ServiceError> {
    let config = settings.to_zenoh()?;
    let mut pause = FIRST_PAUSE;
    loop {
        match zenoh::open(config.clone()).wait() {
            Ok(session) => return Ok(Some(session)),
            Err(error) if settings.mode == Mode::Client => latch.fail(error.to_string()),
            Err(error) => return Err(ServiceError::zenoh("opening the Zenoh session", &error)),
        }
        if shutdown.wait_timeout(pause) {
            return Ok(None);
        }
        pause = LONGEST_PAUSE.min(pause * 2);
    }
}

/// Says from now on whether the session has who it needs, as long as there is the process.
pub(crate) fn watch(
    process: &Process,
    settings: &ZenohSettings,
    latch: HealthLatch,
) -> Result<(), ServiceError> {
    let endpoints = settings.connect().to_vec();
    let has_needs = settings.mode == Mode::Client || !endpoints.is_empty();
    let shutdown = process.shutdown().clone();
    let process = process.weak();
    let look = move || {
        while let Some(process) = process() {
            let supervisor = process.supervisor();
            if process.session().is_closed() {
                latch.fail("the session is closed");
                return supervisor.give_up("the Zenoh session was closed".to_owned());
            }
            supervisor.look();
            if !has_needs || is_connected(process.session()) {
                latch.pass();
            } else {
                latch.fail(format!("no connection to any of {}", endpoints.join(", ")));
            }
            drop(process);
            if shutdown.wait_timeout(WATCH_PERIOD) {
                return;
            }
        }
    };
    thread("zenoh-watch", look).map(drop)
}

fn is_connected(session: &Session) -> bool {
    let info = session.info();
    info.routers_zid().wait().next().is_some() || info.peers_zid().wait().next().is_some()
}
