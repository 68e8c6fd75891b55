//! The right to serve a cell, which one instance of a service has at a time.
//!
//! Who has it holds the liveliness token of the cell, in which its start is named. An instance that
//! starts takes it where no other start has it. Else it waits, and is not ready, until that has gone.
//! Names are no matter: a token of the own name with another start is another's.
//!
//! A token goes with its process, at the latest when the session has timed out. One that answered
//! before it went has worked meanwhile, and may only have lost the router. So it has to be gone for
//! a while, as seen by who is connected.
//!
//! Two may have it all the same, as those that start at once, or whose network was split. Each hears
//! of the other, as it announces itself first and is then told of those before. Both compare the
//! same two starts, so exactly one ends its process, starts again and waits:
//! - where one waited for the other and took over, the other, which knows nothing of that;
//! - else the one that started later: who serves stays when it meets a newcomer. Of two that started
//!   within a second, or whose clocks differ, it is either.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use ppnpack_wire::keys::{Cell, Instance, Service, Start, everything_alive};
use zenoh::Wait;
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};

use crate::alive::{self, Found, Said, Token};
use crate::error::ServiceError;
use crate::health::HealthLatch;
use crate::process::Process;
use crate::rpc::Client;
use crate::session::is_connected;

/// How long looking for others may take.
const LOOK_LIMIT: Duration = Duration::from_secs(1);

/// How long others have to say that they work.
const ANSWER_LIMIT: Duration = Duration::from_millis(300);

/// How long to wait before looking again.
const PAUSE: Duration = Duration::from_millis(200);

/// How long another that worked has to be gone. Who lost its router tries again once a second.
const GONE_FOR: Duration = Duration::from_secs(2);

/// What is said where nobody tells who is alive.
const UNKNOWN: &str = "who else serves is not known: the router does not tell who is alive; in the \
                       profile secure, the identity has to watch and check its own service";

/// The right to serve a cell, until it is dropped.
pub struct Lease {
    _token: Token,
    _others: Subscriber<()>,
    _latch: HealthLatch,
    /// Whether another instance served the cell meanwhile: what that did is not known here.
    pub is_after_another: bool,
}

/// Takes the right to serve each of these cells, where `None` is all of them. Calls `begin` with each
/// as soon as it is had, and waits as long as others have the rest.
///
/// One that does not answer and then goes is taken for one that was killed, such as this one's
/// predecessor.
///
/// # Errors
/// [`ServiceError`] where the session is closed, or the end is asked for meanwhile; those of `begin`.
pub fn take_each(
    process: &Process,
    cells: impl IntoIterator<Item = Option<Cell>>,
    mut begin: impl FnMut(Option<&Cell>, Lease) -> Result<(), ServiceError>,
) -> Result<(), ServiceError> {
    let latch = process.health().check("lease");
    let mut wanted: Vec<Wanted> = cells.into_iter().map(Wanted::new).collect();
    let mut working = BTreeSet::new();
    loop {
        let found = Others::look(process, &wanted, &mut working)?;
        for mut one in std::mem::take(&mut wanted) {
            if one.is_free(&found, &working) {
                let lease = one.take(process, latch.clone())?;
                begin(one.cell.as_ref(), lease)?;
            } else {
                wanted.push(one);
            }
        }
        if wanted.is_empty() {
            latch.pass();
            return Ok(());
        }
        if let Some(trouble) = found.trouble(process.service(), &wanted, &working) {
            latch.fail(trouble);
        }
        if process.shutdown().wait_timeout(PAUSE) {
            let text = "the end was asked for while another instance served its cell";
            return Err(ServiceError::start(text));
        }
    }
}

/// A cell, or all of them, whose lease is wanted.
struct Wanted {
    cell: Option<Cell>,
    /// Above those of all who were seen to have it.
    term: u32,
    is_after_another: bool,
    /// Since when nobody has it.
    free_since: Option<Instant>,
}

impl Wanted {
    fn new(cell: Option<Cell>) -> Self {
        Self {
            cell,
            term: 0,
            is_after_another: false,
            free_since: None,
        }
    }

    /// Whether nobody has the cell, for long enough.
    fn is_free(&mut self, found: &Others, working: &BTreeSet<u64>) -> bool {
        let mut is_free = found.is_all;
        for other in found.of(self.cell.as_ref()) {
            is_free = false;
            self.term = self.term.max(other.start.term.saturating_add(1));
            self.is_after_another |= working.contains(&other.start.nonce);
        }
        if !self.is_after_another {
            return is_free;
        }
        if !is_free || !found.is_connected {
            self.free_since = None;
            return false;
        }
        let since = self.free_since.get_or_insert_with(Instant::now);
        since.elapsed() >= GONE_FOR
    }

    /// Announces that the process has the cell, and watches for others then: none is missed.
    fn take(&self, process: &Process, latch: HealthLatch) -> Result<Lease, ServiceError> {
        let nonce = process.identity().start.nonce;
        let start = Start {
            term: self.term,
            nonce,
        };
        let token = alive::announce_start(process, self.cell.as_ref(), start)?;
        Ok(Lease {
            _token: token,
            _others: watch(process, self.cell.clone(), start)?,
            _latch: latch,
            is_after_another: self.is_after_another,
        })
    }
}

/// Others who have cells that are wanted.
struct Others {
    said: Vec<Said>,
    /// Whether there are surely no more.
    is_all: bool,
    is_connected: bool,
}

impl Others {
    /// Looks for others, and adds the nonces of those that answer to those that work.
    fn look(
        process: &Process,
        wanted: &[Wanted],
        working: &mut BTreeSet<u64>,
    ) -> Result<Self, ServiceError> {
        let (session, service) = (process.session(), process.service());
        let deadline = Instant::now() + LOOK_LIMIT;
        let (mut said, is_all) = alive::tokens(session, Some(service), deadline)?;
        let own = process.identity().start.nonce;
        said.retain(|said| {
            let is_wanted = |one: &Wanted| meet(one.cell.as_ref(), said.cell.as_ref());
            said.start.nonce != own && wanted.iter().any(is_wanted)
        });
        let silent = said
            .iter()
            .filter(|said| !working.contains(&said.start.nonce));
        let silent: BTreeMap<u64, Found> = silent
            .map(|said| {
                // To its name another one may answer.
                let found = Found {
                    service,
                    instance: said.start.name(),
                    cells: Vec::new(),
                };
                (said.start.nonce, found)
            })
            .collect();
        let (nonces, found): (Vec<u64>, Vec<Found>) = silent.into_iter().unzip();
        let answers = Client::new(session).health_of_all(&found, Instant::now() + ANSWER_LIMIT);
        let answers = nonces.into_iter().zip(answers);
        working.extend(answers.filter_map(|(nonce, answer)| answer.is_ok().then_some(nonce)));
        Ok(Self {
            said,
            is_all,
            is_connected: is_connected(session),
        })
    }

    /// Those who have this cell.
    fn of(&self, cell: Option<&Cell>) -> impl Iterator<Item = &Said> {
        self.said
            .iter()
            .filter(move |said| meet(cell, said.cell.as_ref()))
    }

    /// Why cells are still wanted, for people; `None` where nothing is to be added to what was said.
    fn trouble(
        &self,
        service: Service,
        wanted: &[Wanted],
        working: &BTreeSet<u64>,
    ) -> Option<String> {
        if !self.is_all {
            return Some(UNKNOWN.to_owned());
        }
        let texts = wanted.iter().flat_map(|one| {
            let others = self.of(one.cell.as_ref());
            let others = others.filter(move |other| working.contains(&other.start.nonce));
            others.map(move |other| {
                let cell = one.cell.as_ref().or(other.cell.as_ref());
                another_serves(service, cell, &other.instance)
            })
        });
        let texts: BTreeSet<String> = texts.collect();
        let texts: Vec<String> = texts.into_iter().collect();
        (!texts.is_empty()).then(|| texts.join("; "))
    }
}

/// Whether there is a cell that both serve; `None` is all of them.
fn meet(one: Option<&Cell>, other: Option<&Cell>) -> bool {
    one.is_none() || other.is_none() || one == other
}

/// Ends this process where another has the cell that is to stay.
fn watch(
    process: &Process,
    cell: Option<Cell>,
    start: Start,
) -> Result<Subscriber<()>, ServiceError> {
    let service = process.service();
    let supervisor = process.supervisor().clone();
    let key = everything_alive(Some(service));
    let on_token = move |sample: Sample| {
        let Some(other) = Said::read(&sample) else {
            return;
        };
        let is_of_cell = meet(cell.as_ref(), other.cell.as_ref());
        let is_own = other.start.nonce == start.nonce;
        if sample.kind() != SampleKind::Put || !is_of_cell || is_own {
            return;
        }
        let text = another_serves(
            service,
            cell.as_ref().or(other.cell.as_ref()),
            &other.instance,
        );
        match start.rank() < other.start.rank() {
            true => supervisor.give_up(text),
            false => tracing::error!("{text}: that one ends"),
        }
    };
    process
        .session()
        .liveliness()
        .declare_subscriber(key.clone())
        .history(true)
        .callback(on_token)
        .wait()
        .map_err(|error| ServiceError::zenoh(format!("watching {key}"), &error))
}

fn another_serves(service: Service, cell: Option<&Cell>, other: &Instance) -> String {
    let cell = cell.map_or_else(|| "all cells".to_owned(), |cell| format!("cell {cell}"));
    format!("another {service}, instance {other}, serves {cell}: end one of them")
}

#[cfg(test)]
mod tests;
