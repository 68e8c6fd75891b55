//! Who is there: liveliness tokens and those who watch them.

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
use crate::process::{Identity, Process};
use crate::sync::lock;

/// Says that an instance is there, until it is dropped.
pub struct Token {
    _token: LivelinessToken,
    cell: Option<Cell>,
    identity: Arc<Identity>,
}

impl Drop for Token {
    fn drop(&mut self) {
        if let Some(cell) = &self.cell {
            self.identity.remove_cell(cell);
        }
    }
}

/// Says that the process is there for a cell; without one, for all.
///
/// # Errors
/// [`ServiceError::Zenoh`] where the session is closed.
pub fn announce(process: &Process, cell: Option<&Cell>) -> Result<Token, ServiceError> {
    announce_start(process, cell, process.identity().start)
}

/// As [`announce`], as this start of the process.
pub(crate) fn announce_start(
    process: &Process,
    cell: Option<&Cell>,
    start: Start,
) -> Result<Token, ServiceError> {
    let (service, instance) = (process.service(), process.instance().clone());
    let key = Key::Alive(cell.cloned(), service, instance, start).to_string();
    let token = process
        .session()
        .liveliness()
        .declare_token(key.clone())
        .wait()
        .map_err(|error| ServiceError::zenoh(format!("declaring {key}"), &error))?;
    let identity = process.identity().clone();
    if let Some(cell) = cell {
        identity.add_cell(cell);
    }
    Ok(Token {
        _token: token,
        cell: cell.cloned(),
        identity,
    })
}

/// What a token says.
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

/// The tokens of a service, or of all, and whether there are surely no more.
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

/// Everything that is there, sorted.
///
/// # Errors
/// [`ServiceError::Zenoh`] where the session is closed.
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
    /// Each with the cell that it is there for, `None` for all, and the nonce of its start.
    tokens: BTreeSet<(Instance, Option<Cell>, u64)>,
    /// When those that went did so last; for as long as a request of theirs may wait.
    left: BTreeMap<Instance, Instant>,
}

impl Alive {
    /// Watches a service.
    ///
    /// # Errors
    /// [`ServiceError::Zenoh`] where the session is closed.
    pub fn watch(session: &Session, service: Service) -> Result<Self, ServiceError> {
        let seen = Arc::new(Seen::default());
        let key = everything_alive(Some(service));
        let callback = {
            let seen = seen.clone();
            move |sample: Sample| seen.note(&sample)
        };
        let subscriber = session
            .liveliness()
            .declare_subscriber(key.clone())
            .history(true)
            .callback(callback)
            .wait()
            .map_err(|error| ServiceError::zenoh(format!("watching {key}"), &error))?;
        Ok(Self {
            seen,
            _subscriber: subscriber,
        })
    }

    /// Those that are there, sorted.
    pub fn instances(&self) -> Vec<Instance> {
        lock(&self.seen.known).instances()
    }

    /// Those that are there for a cell, sorted.
    pub fn instances_for(&self, cell: &Cell) -> Vec<Instance> {
        let known = lock(&self.seen.known);
        let is_for = |of: &Option<Cell>| of.as_ref().is_none_or(|of| of == cell);
        let tokens = known.tokens.iter().filter(|(_, of, _)| is_for(of));
        let mut instances: Vec<Instance> = tokens.map(|(instance, ..)| instance.clone()).collect();
        instances.dedup();
        instances
    }

    /// Whether an instance has gone since then, even where it came back.
    pub fn has_left_since(&self, instance: &Instance, since: Instant) -> bool {
        let known = lock(&self.seen.known);
        known.left.get(instance).is_some_and(|left| *left >= since)
    }

    /// Waits until those that are there are as wanted; says whether they are.
    pub fn wait(&self, deadline: Instant, is_wanted: impl Fn(&[Instance]) -> bool) -> bool {
        let known = lock(&self.seen.known);
        let left = deadline.saturating_duration_since(Instant::now());
        let is_other = |known: &mut Known| !is_wanted(&known.instances());
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
    /// Those that are there, sorted.
    fn instances(&self) -> Vec<Instance> {
        let tokens = self.tokens.iter();
        let mut instances: Vec<Instance> = tokens.map(|token| token.0.clone()).collect();
        instances.dedup();
        instances
    }

    /// An instance goes with the last of its tokens.
    fn remove(&mut self, token: (Instance, Option<Cell>, u64), now: Instant) {
        self.tokens.remove(&token);
        let (instance, ..) = token;
        if self.tokens.iter().all(|(own, ..)| *own != instance) {
            self.left
                .retain(|_, left| now.saturating_duration_since(*left) <= MAX_TIME_LIMIT);
            self.left.insert(instance, now);
        }
    }
}
