//! The requests for controls.

use std::sync::Arc;
use std::time::Instant;

use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use serde_json::json;

use super::failure::{Failure, json};
use super::{Served, waited};
use crate::controls::{Action, Order};

/// The control that only checks the token.
const CHECK: &str = "check";

pub(super) async fn control(
    State(served): State<Arc<Served>>,
    Path(action): Path<String>,
    headers: HeaderMap,
    body: Result<Bytes, BytesRejection>,
) -> Result<Response, Failure> {
    let began = Instant::now();
    served.access.admit(&headers).await?;
    let text = match (action.as_str(), Action::parse(&action)) {
        (CHECK, _) => "The token is right.".to_owned(),
        (_, Some(known)) => carry_out(served, action, known, order_of(body)?).await?,
        (name, None) => {
            let text = format!("there is no control '{name}'");
            return Err(Failure::new(StatusCode::NOT_FOUND, "unknown_action", text));
        }
    };
    let took_ms = began.elapsed().as_secs_f64() * 1e3;
    let done = json!({"text": text, "took_ms": took_ms});
    Ok(json(&done).into_response())
}

fn order_of(body: Result<Bytes, BytesRejection>) -> Result<Order, Failure> {
    let body = body.map_err(|rejection| match rejection.status() {
        status @ StatusCode::PAYLOAD_TOO_LARGE => {
            Failure::new(status, "too_large", "the body is too large")
        }
        _ => Failure::invalid("the body cannot be read"),
    })?;
    serde_json::from_slice(&body).map_err(|error| Failure::invalid(error.to_string()))
}

/// Carries an order out on a thread that may wait for the answer.
async fn carry_out(
    served: Arc<Served>,
    name: String,
    action: Action,
    order: Order,
) -> Result<String, Failure> {
    let carry_out = move || -> Result<String, Failure> {
        let limit = match action.is_stop() {
            true => &served.limits.stops,
            false => &served.limits.controls,
        };
        let permit = limit.try_acquire();
        let _permit = permit.map_err(|_| Failure::busy("too many controls are under way"))?;
        Ok(served.controls.carry_out(&name, action, &order)?)
    };
    waited(carry_out).await?
}
