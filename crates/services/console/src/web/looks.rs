//! Single questions of pages: shapes, and why an item has no place.
//!
//! Threads wait for the planner, whether or not the page that asked is still there. So it is they
//! who have the permits: a page that asks and leaves, again and again, takes no thread from a hold.

use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use ppnpack_service::rpc::CallError;
use ppnpack_wire::v1::{self, Status};

use super::failure::{Failure, json};
use super::{Served, waited};
use crate::shapes::{ShapeError, ShapeId};

/// How long a planner may take to explain: as long as a step.
const EXPLAINING_PATIENCE: Duration = Duration::from_secs(8);

/// A shape never changes: its name is the hash of its content.
const FOR_EVER: &str = "public, max-age=31536000, immutable";

pub(super) async fn shape(
    State(served): State<Arc<Served>>,
    Path((cell, id)): Path<(String, String)>,
) -> Result<impl IntoResponse, Failure> {
    let cell = served.cell(&cell)?;
    let unknown = |text: &str| Failure::new(StatusCode::NOT_FOUND, "unknown_shape", text);
    let id = ShapeId::from_hex(&id).map_err(|_| unknown("64 hexadecimal digits name a shape"))?;
    let found = match served.shapes.kept(&id) {
        Some(known) => Ok(known),
        None => {
            let permit = Arc::clone(&served.limits.shapes).acquire_owned().await;
            let permit = permit.map_err(|_| Failure::lost())?;
            let shapes = Arc::clone(&served.shapes);
            let get = move || {
                let _permit = permit;
                shapes.get(&cell, &id)
            };
            waited(get).await?
        }
    };
    let known = found.map_err(|error| match error {
        ShapeError::Unknown => unknown("the planner does not have it, or not any more"),
        ShapeError::Call(error) => Failure::unanswered(error.to_string()),
    })?;
    let headers = [
        (CONTENT_TYPE, "application/octet-stream"),
        (CACHE_CONTROL, FOR_EVER),
    ];
    Ok((headers, known.triangles.clone()))
}

pub(super) async fn explain(
    State(served): State<Arc<Served>>,
    Path((cell, item_id)): Path<(String, String)>,
) -> Result<Response, Failure> {
    let cell = served.cell(&cell)?;
    let permit = Arc::clone(&served.limits.explaining).try_acquire_owned();
    let permit = permit.map_err(|_| Failure::busy("another item is being explained"))?;
    let request = v1::ExplainRequest {
        item_id: item_id.clone(),
        ..v1::ExplainRequest::default()
    };
    let ask = move || {
        let _permit = permit;
        let deadline = Instant::now() + EXPLAINING_PATIENCE;
        let reply = served.client.call(&cell, request, deadline)?;
        let mut picture = served.directory.picture();
        Ok(picture.explain(&cell, &item_id, reply))
    };
    let explained = waited(ask).await?.map_err(|error| refused(&error))?;
    let explained = explained.ok_or_else(Failure::lost)?;
    Ok(json(&explained).into_response())
}

fn refused(error: &CallError) -> Failure {
    let text = error.to_string();
    match error.status() {
        Some(Status::NotFound) => Failure::new(StatusCode::NOT_FOUND, "unknown_item", text),
        Some(_) => Failure::new(StatusCode::CONFLICT, "refused", text),
        None => Failure::unanswered(text),
    }
}
