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
use std::sync::atomic::Ordering;
use std::time::Duration;

use axum::extract::State;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;
use axum::routing::get;
use serde_json::{Value, json};
use tokio::net::TcpListener;

use crate::error::ServiceError;
use crate::http;
use crate::metrics;
use crate::process::Core;

const TIDY_PERIOD: Duration = Duration::from_secs(5);

const HEALTHCHECK_TIMEOUT: Duration = Duration::from_secs(2);

/// Opens the port and serves it from then on; gives its address, with the port that was chosen.
pub(crate) fn serve(
    runtime: &tokio::runtime::Handle,
    address: SocketAddr,
    core: Arc<Core>,
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
        .with_state(core);
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

async fn live(State(core): State<Arc<Core>>) -> impl IntoResponse {
    let fault = core.supervisor.fault();
    let text = format!("{}\n", fault.as_deref().unwrap_or("live"));
    (status(fault.is_none()), text)
}

async fn ready(State(core): State<Arc<Core>>) -> impl IntoResponse {
    let is_ready = core.health.is_ready();
    let checks = core.health.report().into_iter();
    let checks = checks.map(|check| match check.is_passing {
        true => json!({"name": check.name, "passes": true}),
        false => json!({"name": check.name, "passes": false, "message": check.message}),
    });
    let checks: Vec<Value> = checks.collect();
    let body = json_body(&json!({"ready": is_ready, "checks": checks}));
    (status(is_ready), body)
}

async fn started(State(core): State<Arc<Core>>) -> impl IntoResponse {
    match core.has_started.load(Ordering::Acquire) {
        true => (status(true), "started\n"),
        false => (status(false), "starting\n"),
    }
}

async fn numbers() -> impl IntoResponse {
    let kind = [(CONTENT_TYPE, "text/plain; version=0.0.4")];
    (kind, metrics::render())
}

async fn info(State(core): State<Arc<Core>>) -> impl IntoResponse {
    let model = core.model();
    let versions = core.versions(model.as_deref());
    json_body(&json!({
        "service": core.service.as_str(),
        "instance": versions.instance,
        "version": versions.software,
        "model": model,
        "configuration": versions.configuration,
    }))
}

fn status(is_fine: bool) -> StatusCode {
    match is_fine {
        true => StatusCode::OK,
        false => StatusCode::SERVICE_UNAVAILABLE,
    }
}

fn json_body(value: &Value) -> impl IntoResponse + use<> {
    ([(CONTENT_TYPE, "application/json")], format!("{value}\n"))
}

/// Asks a process's admin port whether it is ready. An address that stands for all, such as
/// 0.0.0.0, is the loopback's.
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
    use ppnpack_wire::keys::{Instance, Service};

    use super::*;
    use crate::shutdown::Shutdown;
    use crate::supervision::Supervisor;

    #[test]
    fn the_port_tells_of_health() {
        let runtime = tokio::runtime::Runtime::new().unwrap();
        let instance = Instance::new("p1").unwrap();
        let supervisor = Supervisor::new(Shutdown::default());
        let core = Core::new(Service::Planner, instance, "c0ffee".to_owned(), supervisor);
        let core = Arc::new(core);
        let store = core.health.check("session_store");
        let loopback = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let address = serve(runtime.handle(), loopback, core.clone()).unwrap();
        let ask = |path: &str| {
            let head = format!("GET {path} HTTP/1.1\r\n");
            let answer = http::exchange(&address.to_string(), &head, &[], HEALTHCHECK_TIMEOUT);
            answer.map(|answer| (answer.status, answer.body)).unwrap()
        };
        assert_eq!(ask("/livez").0, 200);
        assert_eq!(ask("/startupz").0, 503);
        core.has_started.store(true, Ordering::Release);
        assert_eq!(ask("/startupz").0, 200);
        let not_started = r#"{"checks":[{"message":"not started","name":"session_store","passes":false}],"ready":false}"#;
        assert_eq!(ask("/readyz"), (503, format!("{not_started}\n")));
        store.pass();
        assert_eq!(ask("/readyz").0, 200);
        let published = SocketAddr::from((Ipv4Addr::UNSPECIFIED, address.port()));
        assert_eq!(ask_ready(published), Ok(()));
        store.fail("disk full");
        assert_eq!(ask("/readyz").0, 503);
        assert!(ask_ready(published).unwrap_err().contains("disk full"));
        assert!(ask("/info").1.contains(r#""configuration":"c0ffee""#));
        assert_eq!(ask("/metrics").0, 200);
        assert_eq!(ask("/other").0, 404);
        core.supervisor.give_up("a thread is gone".to_owned());
        assert_eq!(ask("/livez"), (503, "a thread is gone\n".to_owned()));
        let error = serve(runtime.handle(), address, core);
        let error = error.unwrap_err().to_string();
        assert!(error.contains("admin.listen"), "{error}");
    }
}
