//! The Zenoh session of a process: opened, watched, closed.

use std::time::{Duration, Instant};

use zenoh::{Session, Wait};

use crate::configuration::{Mode, ZenohSettings};
use crate::error::ServiceError;
use crate::health::HealthLatch;
use crate::process::{Process, thread};
use crate::shutdown::Shutdown;

/// Minimum and maximum pause before a client tries to connect again.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

const WATCH_PERIOD: Duration = Duration::from_millis(500);

/// Maximum time of a client without the router that it had; networks are cut for shorter. A session
/// keeps its id, which somebody else may have taken meanwhile: the router lets in a new one alone.
const ROUTER_PATIENCE: Duration = Duration::from_secs(10);

/// Opens the session. A client tries until there is a router, or until the end is asked for
/// (`None`).
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
    let mut cut = Cut::of(settings.mode);
    let process = process.weak();
    let look = move || {
        while let Some(process) = process() {
            let supervisor = process.supervisor();
            if process.session().is_closed() {
                latch.fail("the session is closed");
                return supervisor.give_up("the Zenoh session was closed".to_owned());
            }
            supervisor.look();
            let is_fine = !has_needs || is_connected(process.session());
            let trouble = format!("no connection to any of {}", endpoints.join(", "));
            if cut.is_too_long(is_fine, Instant::now()) && !supervisor.is_kept() {
                let patience_s = ROUTER_PATIENCE.as_secs();
                latch.fail(trouble.clone());
                return supervisor.give_up(format!("{trouble} for {patience_s} s"));
            }
            match is_fine {
                true => latch.pass(),
                false => latch.fail(trouble),
            }
            drop(process);
            if shutdown.wait_timeout(WATCH_PERIOD) {
                return;
            }
        }
    };
    thread("zenoh-watch", look).map(drop)
}

/// A cut between a session and those it needs.
struct Cut {
    /// Whether a long one ends the process: a client whose router is gone can do nothing.
    is_client: bool,
    since: Option<Instant>,
}

impl Cut {
    fn of(mode: Mode) -> Self {
        Self {
            is_client: mode == Mode::Client,
            since: None,
        }
    }

    /// Says whether it has been too long.
    fn is_too_long(&mut self, is_fine: bool, now: Instant) -> bool {
        if is_fine {
            self.since = None;
            return false;
        }
        let since = *self.since.get_or_insert(now);
        self.is_client && now.saturating_duration_since(since) >= ROUTER_PATIENCE
    }
}

/// Says whether a session reaches anybody.
pub(crate) fn is_connected(session: &Session) -> bool {
    let info = session.info();
    info.routers_zid().wait().next().is_some() || info.peers_zid().wait().next().is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_without_a_router_ends_and_cuts_of_seconds_end_nobody() {
        let begun = Instant::now();
        let at = |seconds| begun + Duration::from_secs(seconds);
        let mut client = Cut::of(Mode::Client);
        // A cut of five seconds, and what it takes to connect again.
        assert!(!client.is_too_long(false, at(0)));
        assert!(!client.is_too_long(false, at(6)));
        assert!(!client.is_too_long(true, at(7)));
        // The next one is another.
        assert!(!client.is_too_long(false, at(8)));
        assert!(!client.is_too_long(false, at(17)));
        assert!(client.is_too_long(false, at(18)));
        let mut peer = Cut::of(Mode::Peer);
        assert!(!peer.is_too_long(false, begun));
        assert!(!peer.is_too_long(false, at(3600)));
    }
}
