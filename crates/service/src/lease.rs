//! The lease of a cell: the right to serve it, which one instance of a service has at a time.
//!
//! The holder has a liveliness token of the cell, whose key names its fencing token, a
//! [`Start`](ppnpack_wire::keys::Start). That is a term, above those of all holders before it, and
//! the nonce of its process. An instance that starts takes the lease where no other start has it.
//! Else it waits, and is not ready, until the other has gone. Names are no matter: a token of the
//! own name with another nonce is another's.
//!
//! A token goes with its process, at the latest when the session has timed out. One that answered
//! before it went has worked meanwhile, and may only have lost the router. So it has to be gone for
//! a while, as seen by who is connected.
//!
//! Two may have it all the same, as those that start at once, or whose network was split. Each
//! hears of the other, as it announces itself first and is then told of those before. Both compare
//! the same two starts, so exactly one ends its process, starts again and waits:
//! - where one waited for the other and took over, the other, which knows nothing of that;
//! - else the one that started later: who serves stays when it meets a newcomer. Of two that
//!   started within a second, or whose clocks differ, it is either.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use ppnpack_wire::keys::{Cell, Instance, Service, everything_alive};
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};

use crate::alive::{self, Said, Token};
use crate::error::ServiceError;
use crate::health::HealthLatch;
use crate::process::Process;
use crate::rpc::Client;
use crate::session::is_connected;

const LOOK_LIMIT: Duration = Duration::from_secs(1);

/// Maximum time for others to answer that they work.
const ANSWER_LIMIT: Duration = Duration::from_millis(300);

const PAUSE: Duration = Duration::from_millis(200);

/// Minimum time for which another that worked has to be gone. It looks for its lost router once a
/// second.
const GONE_FOR: Duration = Duration::from_secs(2);

/// Message where nobody tells who is alive.
const UNKNOWN: &str = "who else serves is not known: the router does not tell who is alive; in the \
                       profile secure, the identity has to watch and check its own service";

/// The lease of a cell, until it is dropped.
pub struct Lease {
    _token: Token,
    _others: Subscriber<()>,
    _latch: HealthLatch,
    /// Whether another instance served the cell meanwhile; its doings are not known here.
    pub is_after_another: bool,
}

/// Takes the lease of each of these cells, where `None` is all of them. Calls `begin` with each as
/// soon as it is had, and waits as long as others have the rest.
///
/// A holder that never answered before it went counts as one that was killed, such as this one's
/// predecessor.
///
/// # Errors
/// [`ServiceError`] where the session is closed, or the end is asked for meanwhile; those of
/// `begin`.
pub fn take_each(
    process: &Process,
    cells: impl IntoIterator<Item = Option<Cell>>,
    mut begin: impl FnMut(Option<&Cell>, Lease) -> Result<(), ServiceError>,
) -> Result<(), ServiceError> {
    let latch = process.health().check("lease");
    let mut wanted: Vec<Wanted> = cells.into_iter().map(Wanted::of).collect();
    let mut others = Others::default();
    loop {
        others.look(process, &wanted)?;
        for mut one in std::mem::take(&mut wanted) {
            if one.is_free(&others) {
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
        if let Some(trouble) = others.trouble(process.service(), &wanted) {
            latch.fail(trouble);
        }
        if process.shutdown().wait_timeout(PAUSE) {
            let text = "the end was asked for while another instance served its cell";
            return Err(ServiceError::start(text));
        }
    }
}

/// A cell, or all of them, whose lease is wanted.
#[derive(Default)]
struct Wanted {
    cell: Option<Cell>,
    /// Above those of all who were seen to have it.
    term: u32,
    is_after_another: bool,
    /// The time since which nobody has it.
    free_since: Option<Instant>,
}

impl Wanted {
    fn of(cell: Option<Cell>) -> Self {
        Self {
            cell,
            ..Self::default()
        }
    }

    /// Says whether nobody has the cell, for long enough.
    fn is_free(&mut self, others: &Others) -> bool {
        let mut is_free = others.is_all;
        for other in others.of(self.cell.as_ref()) {
            is_free = false;
            self.term = self.term.max(other.start.term.saturating_add(1));
            self.is_after_another |= others.works(other);
        }
        if !self.is_after_another {
            return is_free;
        }
        if !is_free || !others.is_connected {
            self.free_since = None;
            return false;
        }
        let since = self.free_since.get_or_insert_with(Instant::now);
        since.elapsed() >= GONE_FOR
    }

    /// Announces that the process has the cell, and watches for others then: none is missed.
    fn take(&self, process: &Process, latch: HealthLatch) -> Result<Lease, ServiceError> {
        Ok(Lease {
            _token: alive::announce_term(process, self.cell.as_ref(), self.term)?,
            _others: watch(process, self.cell.clone(), self.term)?,
            _latch: latch,
            is_after_another: self.is_after_another,
        })
    }
}

/// Others who have cells that are wanted.
#[derive(Default)]
struct Others {
    said: Vec<Said>,
    /// Whether there are surely no more.
    is_all: bool,
    is_connected: bool,
    /// The nonces of those that have ever answered.
    working: BTreeSet<u64>,
}

impl Others {
    /// Looks for others, and asks those that have not answered yet whether they work.
    fn look(&mut self, process: &Process, wanted: &[Wanted]) -> Result<(), ServiceError> {
        let (session, service) = (process.session(), process.service());
        let deadline = Instant::now() + LOOK_LIMIT;
        (self.said, self.is_all) = alive::tokens(session, Some(service), deadline)?;
        self.said.retain(|said| {
            let is_wanted = |one: &Wanted| meet(one.cell.as_ref(), said.cell.as_ref());
            said.start.nonce != process.core().nonce && wanted.iter().any(is_wanted)
        });
        let silent = self.said.iter().filter(|said| !self.works(said));
        // To an instance's own name another one may answer.
        let silent: BTreeMap<u64, Instance> = silent
            .map(|said| (said.start.nonce, said.start.name()))
            .collect();
        let asked = silent.values().map(|name| (service, name));
        let answers = Client::new(session).health_of_all(asked, Instant::now() + ANSWER_LIMIT);
        let answers = silent.keys().zip(answers);
        let working = answers.filter_map(|(nonce, answer)| answer.is_ok().then_some(*nonce));
        self.working.extend(working);
        self.is_connected = is_connected(session);
        Ok(())
    }

    /// Says whether another has ever answered.
    fn works(&self, other: &Said) -> bool {
        self.working.contains(&other.start.nonce)
    }

    /// Gives those who have this cell.
    fn of(&self, cell: Option<&Cell>) -> impl Iterator<Item = &Said> {
        let said = self.said.iter();
        said.filter(move |said| meet(cell, said.cell.as_ref()))
    }

    /// Says why cells are still wanted; `None` where there is nothing to add to what was said.
    fn trouble(&self, service: Service, wanted: &[Wanted]) -> Option<String> {
        if !self.is_all {
            return Some(UNKNOWN.to_owned());
        }
        let texts = wanted.iter().flat_map(|one| {
            let others = self
                .of(one.cell.as_ref())
                .filter(move |other| self.works(other));
            others.map(move |other| another_serves(service, one.cell.as_ref(), other))
        });
        let texts: BTreeSet<String> = texts.collect();
        (!texts.is_empty()).then(|| Vec::from_iter(texts).join("; "))
    }
}

/// Says whether there is a cell that both serve; `None` is all of them.
fn meet(one: Option<&Cell>, other: Option<&Cell>) -> bool {
    one.is_none() || other.is_none() || one == other
}

/// Ends this process where another has the cell that is to stay.
fn watch(process: &Process, cell: Option<Cell>, term: u32) -> Result<Subscriber<()>, ServiceError> {
    let (service, start) = (process.service(), process.core().start(term));
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
        let text = another_serves(service, cell.as_ref(), &other);
        match start.rank() < other.start.rank() {
            true => supervisor.give_up(text),
            false => tracing::error!("{text}: that one ends"),
        }
    };
    alive::declare(process.session(), &key, on_token)
}

/// Says that another serves a wanted cell.
fn another_serves(service: Service, wanted: Option<&Cell>, other: &Said) -> String {
    let cell = wanted.or(other.cell.as_ref());
    let cell = cell.map_or_else(|| "all cells".to_owned(), |cell| format!("cell {cell}"));
    let instance = &other.instance;
    format!("another {service}, instance {instance}, serves {cell}: end one of them")
}

#[cfg(test)]
mod tests;
