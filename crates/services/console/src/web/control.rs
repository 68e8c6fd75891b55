//! Controls, as they are asked for.

use std::sync::Arc;
use std::time::Instant;

use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use serde_json::json;

use super::Served;
use super::failure::{Failure, json};
use crate::controls::{Action, Order};

/// What is asked for to know whether a token is right.
const CHECK: &str = "check";

pub(super) async fn control(
    State(served): State<Arc<Served>>,
    Path(action): Path<String>,
    headers: HeaderMap,
    body: Result<Bytes, BytesRejection>,
) -> Result<Response, Failure> {
    let began = Instant::now();
    served.access.admit(&headers).await?;
    let text = match action.as_str() {
        CHECK => "The token is right.".to_owned(),
        name => {
            let unknown = || {
                let text = format!("there is no control '{name}'");
                Failure::new(StatusCode::NOT_FOUND, "unknown_action", text)
            };
            let known = Action::parse(name).ok_or_else(unknown)?;
            carry_out(served, name.to_owned(), known, order_of(body)?).await?
        }
    };
    let took_ms = began.elapsed().as_secs_f64() * 1e3;
    let done = json!({"text": text, "took_ms": took_ms});
    Ok(json(&done).into_response())
}

fn order_of(body: Result<Bytes, BytesRejection>) -> Result<Order, Failure> {
    let body = body.map_err(|rejection| match rejection.status() {
        StatusCode::PAYLOAD_TOO_LARGE => Failure::new(
            StatusCode::PAYLOAD_TOO_LARGE,
            "too_large",
            "the body is too large",
        ),
        _ => Failure::invalid("the body cannot be read"),
    })?;
    serde_json::from_slice(&body).map_err(|error| Failure::invalid(error.to_string()))
}

/// Carries an order out in a thread that may wait for the answer.
async fn carry_out(
    served: Arc<Served>,
    name: String,
    action: Action,
    order: Order,
) -> Result<String, Failure> {
    let carry_out = move || {
        let limits = &served.limits;
        let limit = if action.is_stop() {
            &limits.stops
        } else {
            &limits.controls
        };
        let permit = limit.try_acquire();
        let _permit = permit.map_err(|_| Failure::busy("too many controls are under way"))?;
        served
            .controls
            .carry_out(&name, action, &order)
            .map_err(Failure::from)
    };
    let done = tokio::task::spawn_blocking(carry_out).await;
    done.map_err(|_| Failure::lost())?
}
