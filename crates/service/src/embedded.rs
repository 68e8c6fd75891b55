//! Several services in one process: a router on a loopback port, and clients of it.

use std::sync::Arc;
use std::time::Duration;

use ppnpack_wire::keys::{Instance, Service};
use serde_json::Value;
use zenoh::{Session, Wait};

use crate::configuration::{Endpoints, Mode, ZenohSettings};
use crate::error::ServiceError;
use crate::process::{Core, Process};
use crate::shutdown::Shutdown;
use crate::supervision::Supervisor;

const ANSWER_TIMEOUT: Duration = Duration::from_secs(5);

/// A router within this process, on a loopback port of the system's choice. It ends when it is
/// dropped.
pub struct Hub {
    session: Session,
    endpoints: Vec<String>,
    supervisor: Supervisor,
}

/// Opens a hub on a loopback port of the system's choice. There is no multicast: only those who
/// are told its endpoint find it.
///
/// # Errors
/// [`ServiceError::Zenoh`] where it cannot listen.
pub fn hub() -> Result<Hub, ServiceError> {
    hub_at(&[])
}

/// Opens a hub on these endpoints; on a loopback port of the system's choice where there are none.
///
/// # Errors
/// [`ServiceError::Zenoh`] where it cannot listen on one of them.
pub fn hub_at(listen: &[String]) -> Result<Hub, ServiceError> {
    let listen = match listen {
        [] => vec!["tcp/127.0.0.1:0".to_owned()],
        given => given.to_vec(),
    };
    let settings = ZenohSettings {
        mode: Mode::Router,
        listen: Endpoints(listen),
        ..ZenohSettings::default()
    };
    let session = open(settings, "opening the hub")?;
    let locators = told(&session, "locators")?;
    let endpoints = locators.iter().filter_map(Value::as_str);
    Ok(Hub {
        endpoints: endpoints.map(str::to_owned).collect(),
        session,
        supervisor: Supervisor::new(Shutdown::default()),
    })
}

/// Opens a session with room for the largest clouds.
fn open(settings: ZenohSettings, action: &str) -> Result<Session, ServiceError> {
    let config = settings.with_largest_clouds().to_zenoh()?;
    let session = zenoh::open(config).wait();
    session.map_err(|error| ServiceError::zenoh(action, &error))
}

impl Hub {
    /// Gives its endpoint for others on this machine, such as `tcp/127.0.0.1:40123`.
    pub fn endpoint(&self) -> &str {
        let is_loopback = |endpoint: &&String| endpoint.contains("/127.0.0.1:");
        let loopback = self.endpoints.iter().find(is_loopback);
        let endpoint = loopback.or(self.endpoints.first());
        endpoint.map_or("", String::as_str)
    }

    /// The wish that all processes on it end.
    pub fn shutdown(&self) -> &Shutdown {
        self.supervisor.shutdown()
    }

    /// Gives the reason for which all processes on it fail, if they do.
    pub fn fault(&self) -> Option<String> {
        self.supervisor.fault()
    }
}

impl Drop for Hub {
    fn drop(&mut self) {
        if let Err(error) = self.session.close().wait() {
            tracing::debug!(%error, "closing the hub");
        }
    }
}

/// Opens a client's session on a hub, for a program that is no service.
///
/// # Errors
/// [`ServiceError::Zenoh`] where there is no hub any more.
pub fn session(hub: &Hub) -> Result<Session, ServiceError> {
    let settings = ZenohSettings {
        connect: Some(Endpoints(vec![hub.endpoint().to_owned()])),
        ..ZenohSettings::default()
    };
    open(settings, "connecting to the hub")
}

/// Makes the process of a service within this one: a client of the hub, which ends with it and has
/// a health of its own.
///
/// # Errors
/// [`ServiceError`] where the instance's name is not possible, or there is no hub any more.
pub fn process(hub: &Hub, service: Service, instance: &str) -> Result<Process, ServiceError> {
    let (instance, supervisor) = (Instance::new(instance)?, hub.supervisor.clone());
    let core = Core::new(service, instance, String::new(), supervisor);
    let settings = ZenohSettings::default().with_largest_clouds();
    Process::new(session(hub)?, settings.max_message_bytes, Arc::new(core))
}

/// Counts the sessions of a router with others, at the router's own.
///
/// # Errors
/// [`ServiceError::Zenoh`] where it does not say.
pub fn sessions(session: &Session) -> Result<usize, ServiceError> {
    told(session, "sessions").map(|sessions| sessions.len())
}

/// Asks a router for a list in its admin space.
fn told(session: &Session, what: &str) -> Result<Vec<Value>, ServiceError> {
    let action = format!("asking the router for its {what}");
    let failed = |reason: &str| ServiceError::Zenoh {
        action: action.clone(),
        reason: reason.to_owned(),
    };
    let replies = session
        .get(format!("@/{}/router", session.zid()))
        .wait()
        .map_err(|error| ServiceError::zenoh(&*action, &error))?;
    let reply = replies.recv_timeout(ANSWER_TIMEOUT).ok().flatten();
    let reply = reply.ok_or_else(|| failed("no answer"))?;
    let sample = reply.into_result().map_err(|_| failed("an error"))?;
    let mut answer: Value = serde_json::from_slice(&sample.payload().to_bytes())
        .map_err(|error| failed(&error.to_string()))?;
    match answer.get_mut(what).map(Value::take) {
        Some(Value::Array(list)) => Ok(list),
        _ => Err(failed("it names none")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_router_counts_its_sessions() {
        let hub = hub().unwrap();
        assert_eq!(sessions(&hub.session).unwrap(), 0);
        let own = [session(&hub).unwrap(), session(&hub).unwrap()];
        assert_eq!(sessions(&hub.session).unwrap(), own.len());
    }
}
