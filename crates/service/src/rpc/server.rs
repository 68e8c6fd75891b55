//! Requests that a service answers.

use std::sync::Arc;
use std::time::Instant;

use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::header::{self, RequestHeader};
use ppnpack_wire::keys::{Cell, Instance, Key, answered};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1;
use zenoh::bytes::ZBytes;
use zenoh::query::{Query, Queryable};
use zenoh::{Session, Wait};

use super::incoming::{Answering, Done, Incoming, Pending};
use crate::error::ServiceError;
use crate::payload;
use crate::process::{Core, Process};

/// Answers a method, until it is dropped.
pub struct Listener {
    _queryables: Vec<Queryable<()>>,
}

/// Answers a method for a cell, or for every cell. `accept` runs on Zenoh's thread: it must only
/// hand the request on. Malformed requests are refused before.
pub fn listen<R: Request>(
    process: &Process,
    cell: Option<&Cell>,
    accept: impl Fn(Incoming<R>) + Send + Sync + 'static,
) -> Result<Listener, ServiceError> {
    let on_request = move |cell, message, header, pending: Pending<R>| match cell {
        Some(cell) => accept(Incoming {
            message,
            header,
            cell,
            pending,
        }),
        None => pending.refuse(v1::Status::Invalid, "send this to a cell, not to all"),
    };
    let core = process.core();
    let names = std::slice::from_ref(&core.instance);
    declare(process.session(), core, cell, names, on_request)
}

/// Answers for the health of a process, by its name and by that of its start: others may have the
/// same name.
pub(crate) fn answer_health(session: &Session, core: &Arc<Core>) -> Result<Listener, ServiceError> {
    let own = core.clone();
    let on_request = move |_, _, _, pending: Pending<v1::HealthRequest>| {
        let done = Done {
            model: own.model(),
            ..Done::default()
        };
        pending.reply(own.health_reply(), done);
    };
    let names = [core.instance.clone(), core.start(0).name()];
    declare(session, core, None, &names, on_request)
}

/// Answers to these names. `on_request` is given the cell: `None` for a request to no single one.
fn declare<R: Request>(
    session: &Session,
    core: &Arc<Core>,
    cell: Option<&Cell>,
    names: &[Instance],
    on_request: impl Fn(Option<Cell>, R, RequestHeader, Pending<R>) + Send + Sync + 'static,
) -> Result<Listener, ServiceError> {
    let service = R::SERVICE.unwrap_or(core.service);
    let answering = Arc::new(Answering::new::<R>(core.clone(), service));
    let on_request = Arc::new(on_request);
    let own_cell = cell.cloned();
    let queryable = |key: String| {
        let answering = answering.clone();
        let on_request = on_request.clone();
        let own_cell = own_cell.clone();
        let callback = move |query: Query| {
            let Some((cell, message, header, pending)) = receive(&answering, query) else {
                return;
            };
            match strayed(own_cell.as_ref(), cell.as_ref(), header.cell.as_ref()) {
                Some(reason) => pending.refuse(v1::Status::Unavailable, &reason),
                None => on_request(cell, message, header, pending),
            }
        };
        session
            .declare_queryable(key.clone())
            // One answer is enough: Zenoh asks one of several that are complete.
            .complete(true)
            .callback(callback)
            .wait()
            .map_err(|error| ServiceError::zenoh(format!("declaring {key}"), &error))
    };
    let (any, own) = answered(cell, service, R::METHOD, names);
    // In this order, who finds any instance finds this one by its name too.
    let keys = own.into_iter().chain([any]);
    Ok(Listener {
        _queryables: keys.map(queryable).collect::<Result<_, _>>()?,
    })
}

/// Says why a request is not for the cell that it came to; `own` is none where all are served.
fn strayed(own: Option<&Cell>, of_key: Option<&Cell>, meant: Option<&Cell>) -> Option<String> {
    let came_to = own.or(of_key)?;
    let cells = [of_key, meant].into_iter().flatten();
    let other = cells.into_iter().find(|cell| *cell != came_to)?;
    tracing::warn!(%came_to, meant = %other, "a request came to another cell than it is for");
    Some(format!(
        "it is for cell {other}, and came to cell {came_to}: send it again"
    ))
}

/// Reads a request; refuses a malformed one.
fn receive<R: Request>(
    answering: &Arc<Answering>,
    query: Query,
) -> Option<(Option<Cell>, R, RequestHeader, Pending<R>)> {
    let received = Instant::now();
    let cell = match Key::parse(query.key_expr().as_str()) {
        Ok(Key::Request(cell, ..)) => cell,
        _ => {
            answering.malformed.count(&query.key_expr());
            let refused = query.reply_err("name one cell, service and method");
            refused.wait().ok();
            return None;
        }
    };
    let empty = ZBytes::default();
    let read = payload::read::<R>(query.payload().unwrap_or(&empty), MAX_MESSAGE_BYTES);
    let mut pending = Pending::new(answering.clone(), query, received);
    let checked = read.and_then(|message| {
        pending.request_id = id_of(&message);
        Ok((RequestHeader::read(message.header())?, message))
    });
    match checked {
        Ok((header, message)) => {
            pending.begin_span();
            Some((cell, message, header, pending))
        }
        Err(error) => {
            answering.malformed.count(&error);
            pending.refuse(v1::Status::Invalid, &error.to_string());
            None
        }
    }
}

/// Gives the id of a request, as far as it has one.
fn id_of(request: &impl Request) -> String {
    let id = request.header().map_or("", |header| &header.request_id);
    let id = header::id("header.request_id", id);
    id.unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_taken_by_the_cell_that_it_is_for_alone() {
        let [one, two] = ["cell-1", "cell-2"].map(|name| Cell::new(name).unwrap());
        let (one, two) = (Some(&one), Some(&two));
        for (own, of_key, meant) in [
            (one, one, one),
            (one, one, None),
            (None, one, one),
            (None, one, None),
            (None, None, None),
        ] {
            assert_eq!(strayed(own, of_key, meant), None);
        }
        for (own, of_key, meant) in [
            (one, two, two),
            (one, two, None),
            (one, one, two),
            (None, one, two),
        ] {
            let reason = strayed(own, of_key, meant).unwrap();
            assert!(reason.contains("it is for cell cell-2, and came to cell cell-1"));
        }
    }
}
