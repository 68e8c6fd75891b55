//! Liveliness tokens, by which instances of services are seen to come and go.
//!
//! All fails with [`ServiceError::Zenoh`] where the session is closed.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Instant;

use ppnpack_wire::header::MAX_TIME_LIMIT;
use ppnpack_wire::keys::{Cell, Instance, Key, Service, Start, everything_alive};
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

use crate::error::ServiceError;
use crate::process::{Core, Process};
use crate::sync::lock;

/// Says that an instance is there, until it is dropped.
pub struct Token {
    _token: LivelinessToken,
    cell: Option<Cell>,
    core: Arc<Core>,
}

impl Drop for Token {
    fn drop(&mut self) {
        if let Some(cell) = &self.cell {
            self.core.remove_cell(cell);
        }
    }
}

/// Announces the process for a cell; without one, for all.
pub fn announce(process: &Process, cell: Option<&Cell>) -> Result<Token, ServiceError> {
    announce_term(process, cell, 0)
}

/// Announces the process as one that serves a cell after so many others.
pub(crate) fn announce_term(
    process: &Process,
    cell: Option<&Cell>,
    term: u32,
) -> Result<Token, ServiceError> {
    let core = process.core().clone();
    let (cell, instance) = (cell.cloned(), core.instance.clone());
    let key = Key::Alive(cell.clone(), core.service, instance, core.start(term)).to_string();
    let liveliness = process.session().liveliness();
    let token = liveliness.declare_token(key.clone()).wait();
    let token = token.map_err(|error| ServiceError::zenoh(format!("declaring {key}"), &error))?;
    if let Some(cell) = &cell {
        core.add_cell(cell);
    }
    Ok(Token {
        _token: token,
        cell,
        core,
    })
}

#[derive(Debug, Clone)]
pub(crate) struct Said {
    pub(crate) cell: Option<Cell>,
    pub(crate) service: Service,
    pub(crate) instance: Instance,
    pub(crate) start: Start,
}

impl Said {
    /// Reads a token; `None` where it is none of this protocol.
    pub(crate) fn read(sample: &Sample) -> Option<Self> {
        match Key::parse(sample.key_expr().as_str()) {
            Ok(Key::Alive(cell, service, instance, start)) => Some(Self {
                cell,
                service,
                instance,
                start,
            }),
            _ => None,
        }
    }
}

/// Finds the tokens of a service, or of all, and says whether there are surely no more.
pub(crate) fn tokens(
    session: &Session,
    service: Option<Service>,
    deadline: Instant,
) -> Result<(Vec<Said>, bool), ServiceError> {
    let key = everything_alive(service);
    let replies = session
        .liveliness()
        .get(key.clone())
        .timeout(deadline.saturating_duration_since(Instant::now()))
        .wait()
        .map_err(|error| ServiceError::zenoh(format!("looking for {key}"), &error))?;
    let (mut found, mut is_all) = (Vec::new(), true);
    loop {
        match replies.recv_deadline(deadline) {
            Ok(Some(reply)) => match reply.into_result() {
                Ok(sample) => found.extend(Said::read(&sample)),
                Err(_) => is_all = false,
            },
            Ok(None) => return Ok((found, false)),
            // The channel ends after the last reply.
            Err(_) => return Ok((found, is_all)),
        }
    }
}

/// An instance that is there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// Its service.
    pub service: Service,
    /// Its name.
    pub instance: Instance,
    /// The cells that it is there for; none where it is there for all.
    pub cells: Vec<Cell>,
}

/// Finds every instance that is there, sorted.
pub fn find(session: &Session, deadline: Instant) -> Result<Vec<Found>, ServiceError> {
    let mut found: BTreeMap<(Service, Instance), BTreeSet<Cell>> = BTreeMap::new();
    for said in tokens(session, None, deadline)?.0 {
        let cells = found.entry((said.service, said.instance)).or_default();
        cells.extend(said.cell);
    }
    let found = found.into_iter().map(|((service, instance), cells)| Found {
        service,
        instance,
        cells: cells.into_iter().collect(),
    });
    Ok(found.collect())
}

/// Watches tokens: those that are there, and those that come and go from now on.
pub(crate) fn declare(
    session: &Session,
    key: &str,
    on_token: impl Fn(Sample) + Send + Sync + 'static,
) -> Result<Subscriber<()>, ServiceError> {
    session
        .liveliness()
        .declare_subscriber(key.to_owned())
        .history(true)
        .callback(on_token)
        .wait()
        .map_err(|error| ServiceError::zenoh(format!("watching {key}"), &error))
}

/// The instances of a service that are there, kept current.
pub struct Alive {
    seen: Arc<Seen>,
    _subscriber: Subscriber<()>,
}

#[derive(Default)]
struct Seen {
    known: Mutex<Known>,
    changed: Condvar,
}

#[derive(Default)]
struct Known {
    /// Instances, each with the cell that it is there for, `None` for all, and its nonce.
    tokens: BTreeSet<(Instance, Option<Cell>, u64)>,
    /// The time at which each that went did so last, for as long as its requests may wait.
    left: BTreeMap<Instance, Instant>,
}

impl Alive {
    /// Watches a service.
    pub fn watch(session: &Session, service: Service) -> Result<Self, ServiceError> {
        let seen = Arc::new(Seen::default());
        let key = everything_alive(Some(service));
        let callback = {
            let seen = seen.clone();
            move |sample: Sample| seen.note(&sample)
        };
        Ok(Self {
            seen,
            _subscriber: declare(session, &key, callback)?,
        })
    }

    /// Names the instances that are there, sorted.
    pub fn instances(&self) -> Vec<Instance> {
        lock(&self.seen.known).instances(None)
    }

    /// Names the instances that are there for a cell, sorted.
    pub fn instances_for(&self, cell: &Cell) -> Vec<Instance> {
        lock(&self.seen.known).instances(Some(cell))
    }

    /// Says whether an instance has gone since then, even where it came back.
    pub fn has_left_since(&self, instance: &Instance, since: Instant) -> bool {
        let known = lock(&self.seen.known);
        known.left.get(instance).is_some_and(|left| *left >= since)
    }

    /// Waits until the instances are as wanted; says whether they are.
    pub fn wait(&self, deadline: Instant, is_wanted: impl Fn(&[Instance]) -> bool) -> bool {
        let known = lock(&self.seen.known);
        let left = deadline.saturating_duration_since(Instant::now());
        let is_other = |known: &mut Known| !is_wanted(&known.instances(None));
        let waited = self.seen.changed.wait_timeout_while(known, left, is_other);
        let timeout = waited.unwrap_or_else(PoisonError::into_inner).1;
        !timeout.timed_out()
    }
}

impl Seen {
    fn note(&self, sample: &Sample) {
        let Some(said) = Said::read(sample) else {
            return;
        };
        let token = (said.instance, said.cell, said.start.nonce);
        let mut known = lock(&self.known);
        match sample.kind() {
            SampleKind::Put => {
                known.tokens.insert(token);
            }
            SampleKind::Delete => known.remove(token, Instant::now()),
        }
        self.changed.notify_all();
    }
}

impl Known {
    /// Names the instances, or those for a cell, sorted.
    fn instances(&self, cell: Option<&Cell>) -> Vec<Instance> {
        let is_for = |of: &Option<Cell>| cell.is_none() || of.is_none() || of.as_ref() == cell;
        let tokens = self.tokens.iter().filter(|(_, of, _)| is_for(of));
        let mut instances: Vec<Instance> = tokens.map(|(instance, ..)| instance.clone()).collect();
        instances.dedup();
        instances
    }

    /// Removes a token, with the last of which its instance goes.
    fn remove(&mut self, token: (Instance, Option<Cell>, u64), now: Instant) {
        self.tokens.remove(&token);
        let (instance, ..) = token;
        if self.tokens.iter().all(|(own, ..)| *own != instance) {
            let is_recent = |left: &Instant| now.saturating_duration_since(*left) <= MAX_TIME_LIMIT;
            self.left.retain(|_, left| is_recent(left));
            self.left.insert(instance, now);
        }
    }
}
