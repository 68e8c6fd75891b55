//! `ppnpack-router`: the Zenoh router that services and controllers connect to, run as a service.
//!
//! Access control is a part of Zenoh's configuration: `zenoh.file` names a file with it.

use std::process::ExitCode;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ppnpack_service::configuration::{Endpoints, Mode, ZenohSettings};
use ppnpack_service::metrics::{self, Metric};
use ppnpack_service::{Process, Running, ServiceError, ServiceSettings, alive, embedded, join};
use ppnpack_wire::keys::Service;
use serde::{Deserialize, Serialize};

const COUNTED: Duration = Duration::from_secs(5);

/// A router has nothing to set but its Zenoh session.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Settings {}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        Ok(())
    }

    fn zenoh() -> ZenohSettings {
        ZenohSettings {
            mode: Mode::Router,
            listen: Endpoints(vec!["tcp/127.0.0.1:7447".to_owned()]),
            ..ZenohSettings::default()
        }
    }
}

/// Zenoh does the work; the token says that it is there, a thread how many are.
struct Router {
    _alive: alive::Token,
    counting: JoinHandle<()>,
}

impl Running for Router {
    fn finish(self: Box<Self>, deadline: Instant) -> Result<(), String> {
        join(vec![self.counting], deadline)
    }
}

/// Counts who is connected, until the process is asked to end.
fn count(process: &Process) -> Result<JoinHandle<()>, ServiceError> {
    let (session, shutdown) = (process.session().clone(), process.shutdown().clone());
    let connected = metrics::gauge(Metric::RouterSessions, &[]);
    process.supervisor().thread("router-sessions", move || {
        loop {
            match embedded::sessions(&session) {
                Ok(sessions) => connected.set(sessions as f64),
                Err(error) => tracing::debug!(%error, "the sessions are not counted"),
            }
            if shutdown.wait_timeout(COUNTED) {
                return;
            }
        }
    })
}

fn main() -> ExitCode {
    ppnpack_service::main(Service::Router, |process, _settings: Settings| {
        Ok(Box::new(Router {
            _alive: alive::announce(process, None)?,
            counting: count(process)?,
        }))
    })
}
