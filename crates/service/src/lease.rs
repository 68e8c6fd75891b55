//! The right to serve a cell, which one instance of a service has at a time.
//!
//! Who has it holds the liveliness token of the cell. An instance that starts takes it where no other one has it; otherwise it
//! waits, and is not ready, until that has gone. Where two have it, as two started at once or the network was split, the one
//! whose name is the later ends its process, starts again and waits.

use std::time::{Duration, Instant};

use ppnpack_wire::keys::{Cell, Instance, Key, Service, everything_alive};
use zenoh::Wait;
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};

use crate::alive::{self, Token};
use crate::error::ServiceError;
use crate::health::HealthLatch;
use crate::process::Process;
use crate::rpc::Client;

/// How long looking for others may take.
const LOOK_LIMIT: Duration = Duration::from_secs(1);

/// How long another one has to say that it works.
const ANSWER_LIMIT: Duration = Duration::from_millis(300);

/// How long to wait before looking again.
const PAUSE: Duration = Duration::from_millis(200);

/// The right to serve a cell, until it is dropped.
pub struct Lease {
    _token: Token,
    _others: Subscriber<()>,
    _latch: HealthLatch,
    /// Whether another instance served the cell meanwhile: what that did is not known here.
    pub is_after_another: bool,
}

/// Takes the right to serve a cell; waits as long as another instance has it. One that does not answer and then goes is taken for
/// one that was killed, such as this one's predecessor.
///
/// # Errors
/// [`ServiceError`] where the session is closed, or the end is asked for meanwhile.
pub fn take(process: &Process, cell: &Cell) -> Result<Lease, ServiceError> {
    let latch = process.health().check("lease");
    let mut is_after_another = false;
    while let Some(other) = another(process, cell)? {
        let deadline = Instant::now() + ANSWER_LIMIT;
        let answer = Client::new(process.session()).health(process.service(), &other, deadline);
        if answer.is_ok() {
            is_after_another = true;
            let text = another_serves(process.service(), cell, &other);
            tracing::warn!(%cell, %other, "{text}; waiting until it has ended");
            latch.fail(text);
        }
        if process.shutdown().wait_timeout(PAUSE) {
            let text = format!("the end was asked for while another instance served cell {cell}");
            return Err(ServiceError::start(text));
        }
    }
    let others = watch(process, cell)?;
    let token = alive::announce(process, Some(cell))?;
    latch.pass();
    Ok(Lease {
        _token: token,
        _others: others,
        _latch: latch,
        is_after_another,
    })
}

/// Another instance that serves the cell, if there is one.
fn another(process: &Process, cell: &Cell) -> Result<Option<Instance>, ServiceError> {
    let found = alive::find(process.session(), Instant::now() + LOOK_LIMIT)?;
    let mut others = found.into_iter().filter(|found| {
        let is_of_cell = found.cells.is_empty() || found.cells.contains(cell);
        is_of_cell && found.service == process.service() && found.instance != *process.instance()
    });
    Ok(others.next().map(|found| found.instance))
}

/// Ends this process where another instance comes that has the earlier name.
fn watch(process: &Process, cell: &Cell) -> Result<Subscriber<()>, ServiceError> {
    let (service, own, cell) = (process.service(), process.instance().clone(), cell.clone());
    let supervisor = process.supervisor().clone();
    let key = everything_alive(Some(service));
    let on_token = move |sample: Sample| {
        let Ok(Key::Alive(of, _, other)) = Key::parse(sample.key_expr().as_str()) else {
            return;
        };
        let is_of_cell = of.is_none_or(|of| of == cell);
        if sample.kind() != SampleKind::Put || !is_of_cell || other == own {
            return;
        }
        let text = another_serves(service, &cell, &other);
        match own > other {
            true => supervisor.give_up(text),
            false => tracing::error!(%cell, %other, "{text}: that one ends"),
        }
    };
    process
        .session()
        .liveliness()
        .declare_subscriber(key.clone())
        .callback(on_token)
        .wait()
        .map_err(|error| ServiceError::zenoh(format!("watching {key}"), &error))
}

fn another_serves(service: Service, cell: &Cell, other: &Instance) -> String {
    format!("another {service}, instance {other}, serves cell {cell}: end one of them")
}
