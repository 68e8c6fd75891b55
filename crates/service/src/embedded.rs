//! Several services in one process: a session that listens on a loopback port of the system's choice, and clients of it.

use std::sync::Arc;
use std::time::Duration;

use ppnpack_wire::keys::{Instance, Service};
use serde_json::Value;
use zenoh::{Session, Wait};

use crate::configuration::{Endpoints, Mode, ZenohSettings};
use crate::error::ServiceError;
use crate::health::Health;
use crate::process::{Identity, Process};
use crate::shutdown::Shutdown;
use crate::supervision::Supervisor;

/// How long a router may take to say where it listens, and who is connected.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(5);

/// A router within this process, on a loopback port of the system's choice. It ends when it is dropped.
pub struct Hub {
    session: Session,
    endpoints: Vec<String>,
    shutdown: Shutdown,
    supervisor: Supervisor,
}

/// Opens a hub on a loopback port of the system's choice. There is no multicast: only who is told its endpoint finds it.
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
        ..ZenohSettings::default().with_largest_clouds()
    };
    let action = "opening the hub";
    let session = zenoh::open(settings.to_zenoh()?)
        .wait()
        .map_err(|error| ServiceError::zenoh(action, &error))?;
    let endpoints = locators(&session)?;
    let shutdown = Shutdown::default();
    Ok(Hub {
        session,
        endpoints,
        supervisor: Supervisor::new(shutdown.clone()),
        shutdown,
    })
}

impl Hub {
    /// Where it listens, such as `tcp/127.0.0.1:40123`: for others on this machine.
    pub fn endpoint(&self) -> &str {
        let is_loopback = |endpoint: &&String| endpoint.contains("/127.0.0.1:");
        let loopback = self.endpoints.iter().find(is_loopback);
        loopback
            .or(self.endpoints.first())
            .map_or("", String::as_str)
    }

    /// The wish that all processes on it end.
    pub fn shutdown(&self) -> &Shutdown {
        &self.shutdown
    }

    /// Why all processes on it end, where they do not as they were asked to.
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

/// A client session on a hub, for a program that is no service.
///
/// # Errors
/// [`ServiceError::Zenoh`] where there is no hub any more.
pub fn session(hub: &Hub) -> Result<Session, ServiceError> {
    let settings = ZenohSettings {
        connect: Some(Endpoints(vec![hub.endpoint().to_owned()])),
        ..ZenohSettings::default().with_largest_clouds()
    };
    zenoh::open(settings.to_zenoh()?)
        .wait()
        .map_err(|error| ServiceError::zenoh("connecting to the hub", &error))
}

/// What a service runs on, in this process: a client of the hub, with the hub's wish to end and a health of its own.
///
/// # Errors
/// [`ServiceError`] where the instance's name is not possible, or there is no hub any more.
pub fn process(hub: &Hub, service: Service, instance: &str) -> Result<Process, ServiceError> {
    let identity = Identity::new(service, Instance::new(instance)?, String::new());
    Process::new(
        session(hub)?,
        ZenohSettings::default()
            .with_largest_clouds()
            .max_message_bytes,
        Arc::new(identity),
        Health::default(),
        hub.shutdown.clone(),
        hub.supervisor.clone(),
    )
}

/// Counts the sessions of a router with others, at the router's own.
///
/// # Errors
/// [`ServiceError::Zenoh`] where it does not say.
pub fn sessions(session: &Session) -> Result<usize, ServiceError> {
    told(session, "sessions").map(|sessions| sessions.len())
}

/// Where a router listens.
fn locators(session: &Session) -> Result<Vec<String>, ServiceError> {
    let locators = told(session, "locators")?;
    let locators = locators.iter().filter_map(Value::as_str);
    Ok(locators.map(str::to_owned).collect())
}

/// Asks a router for a list that its admin space has.
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
