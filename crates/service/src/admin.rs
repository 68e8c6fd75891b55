//! The admin port: what operators and their tools ask over HTTP.
//!
//! | path | answer |
//! |---|---|
//! | `/livez` | 200 while all that the process cannot do without works, else 503 |
//! | `/readyz` | 200 where every check passes, else 503; names each check |
//! | `/startupz` | 200 once the service has started, else 503 |
//! | `/metrics` | for Prometheus |
//! | `/info` | version, instance, network, configuration |

use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::extract::State;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;
use axum::routing::get;
use serde_json::{Value, json};
use tokio::net::TcpListener;

use crate::error::ServiceError;
use crate::health::Health;
use crate::http;
use crate::metrics;
use crate::process::Identity;
use crate::supervision::Supervisor;

/// How often what was counted is sorted.
const TIDY_PERIOD: Duration = Duration::from_secs(5);

/// How long the health check waits.
const HEALTHCHECK_TIMEOUT: Duration = Duration::from_secs(2);

/// What the admin port tells of.
#[derive(Clone)]
pub(crate) struct Told {
    pub(crate) identity: Arc<Identity>,
    pub(crate) health: Health,
    pub(crate) has_started: Arc<AtomicBool>,
    pub(crate) supervisor: Supervisor,
}

/// Opens the port and serves it from then on. Returns its address, with the port that the system chose.
pub(crate) fn serve(
    runtime: &tokio::runtime::Handle,
    address: SocketAddr,
    told: Told,
) -> Result<SocketAddr, ServiceError> {
    let failed = |source| ServiceError::Admin { address, source };
    let listener = runtime
        .block_on(TcpListener::bind(address))
        .map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let router = axum::Router::new()
        .route("/livez", get(live))
        .route("/readyz", get(ready))
        .route("/startupz", get(started))
        .route("/metrics", get(numbers))
        .route("/info", get(info))
        .with_state(told);
    runtime.spawn(async move {
        if let Err(error) = axum::serve(listener, router).await {
            tracing::error!(%error, "the admin port is gone");
        }
    });
    runtime.spawn(async {
        let mut interval = tokio::time::interval(TIDY_PERIOD);
        loop {
            interval.tick().await;
            metrics::tidy();
        }
    });
    Ok(address)
}

async fn live(State(told): State<Told>) -> impl IntoResponse {
    let fault = told.supervisor.fault();
    let text = fault
        .as_ref()
        .map_or("live\n".to_owned(), |fault| format!("{fault}\n"));
    (status(fault.is_none()), text)
}

async fn ready(State(told): State<Told>) -> impl IntoResponse {
    let is_ready = told.health.is_ready();
    let checks = told.health.report().into_iter().map(|check| {
        if check.is_passing {
            json!({"name": check.name, "passes": true})
        } else {
            json!({"name": check.name, "passes": false, "message": check.message})
        }
    });
    let checks: Vec<Value> = checks.collect();
    let body = json_body(&json!({"ready": is_ready, "checks": checks}));
    (status(is_ready), body)
}

async fn started(State(told): State<Told>) -> impl IntoResponse {
    let has_started = told.has_started.load(Ordering::Acquire);
    let text = has_started.then_some("started\n");
    (status(has_started), text.unwrap_or("starting\n"))
}

async fn numbers() -> impl IntoResponse {
    let kind = [(CONTENT_TYPE, "text/plain; version=0.0.4")];
    (kind, metrics::render())
}

async fn info(State(told): State<Told>) -> impl IntoResponse {
    let model = told.identity.model();
    let versions = told.identity.versions(model.as_deref());
    json_body(&json!({
        "service": told.identity.service.as_str(),
        "instance": versions.instance,
        "version": versions.software,
        "model": model,
        "configuration": versions.configuration,
    }))
}

fn status(is_fine: bool) -> StatusCode {
    if is_fine {
        StatusCode::OK
    } else {
        StatusCode::SERVICE_UNAVAILABLE
    }
}

fn json_body(value: &Value) -> impl IntoResponse + use<> {
    ([(CONTENT_TYPE, "application/json")], format!("{value}\n"))
}

/// Asks a process's admin port whether it is ready; an address that stands for all, such as 0.0.0.0, is the loopback's.
///
/// # Errors
/// What the process is not ready for, or that nobody answers.
pub fn ask_ready(listen: SocketAddr) -> Result<(), String> {
    let mut address = listen;
    if listen.ip().is_unspecified() {
        address.set_ip(match listen {
            SocketAddr::V4(_) => Ipv4Addr::LOCALHOST.into(),
            SocketAddr::V6(_) => Ipv6Addr::LOCALHOST.into(),
        });
    }
    let head = "GET /readyz HTTP/1.1\r\n";
    match http::exchange(&address.to_string(), head, &[], HEALTHCHECK_TIMEOUT) {
        Ok(answer) if answer.status == 200 => Ok(()),
        Ok(answer) => Err(answer.body.trim_end().to_owned()),
        Err(error) => Err(format!("nobody answers at {address}: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use crate::shutdown::Shutdown;
    use ppnpack_wire::keys::{Instance, Service};

    use super::*;

    #[test]
    fn the_port_tells_of_health() {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .unwrap();
        let instance = Instance::new("p1").unwrap();
        let identity = Identity::new(Service::Planner, instance, "c0ffee".to_owned());
        let told = Told {
            identity: Arc::new(identity),
            health: Health::default(),
            has_started: Arc::default(),
            supervisor: Supervisor::new(Shutdown::default()),
        };
        let store = told.health.check("session_store");
        let any = SocketAddr::from((Ipv4Addr::UNSPECIFIED, 0));
        let loopback = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let address = serve(runtime.handle(), loopback, told.clone()).unwrap();
        let ask = |path: &str| {
            let head = format!("GET {path} HTTP/1.1\r\n");
            let answer = http::exchange(&address.to_string(), &head, &[], HEALTHCHECK_TIMEOUT);
            answer.map(|answer| (answer.status, answer.body)).unwrap()
        };
        assert_eq!(ask("/livez").0, 200);
        assert_eq!(ask("/startupz").0, 503);
        told.has_started.store(true, Ordering::Release);
        assert_eq!(ask("/startupz").0, 200);
        let not_started = r#"{"checks":[{"message":"not started","name":"session_store","passes":false}],"ready":false}"#;
        assert_eq!(ask("/readyz"), (503, format!("{not_started}\n")));
        store.pass();
        assert_eq!(ask("/readyz").0, 200);
        let mut published = any;
        published.set_port(address.port());
        assert_eq!(ask_ready(published), Ok(()));
        store.fail("disk full");
        assert_eq!(ask("/readyz").0, 503);
        assert!(ask_ready(published).unwrap_err().contains("disk full"));
        assert!(ask("/info").1.contains(r#""configuration":"c0ffee""#));
        assert_eq!(ask("/metrics").0, 200);
        assert_eq!(ask("/other").0, 404);
        told.supervisor.give_up("a thread is gone".to_owned());
        assert_eq!(ask("/livez"), (503, "a thread is gone\n".to_owned()));
        let error = serve(runtime.handle(), address, told);
        let error = error.unwrap_err().to_string();
        assert!(error.contains("admin.listen"), "{error}");
    }
}
