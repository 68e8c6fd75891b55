//! The desk of a cell: answers its requests, has its robot carry them out, and writes down what came of it.
//!
//! What is asked for is in the journal before the robot hears of it, and what came of it before anybody else does. While
//! the journal cannot be written, nothing is begun; what has ended meanwhile is told when it can be written.

mod opening;
mod outcome;
mod place;
mod renew;

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::time::{Duration, Instant};

use ppnpack_service::Shutdown;
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::{header, v1};

use crate::journal::{CellJournal, JournalError};
use crate::ledger::{Change, Ledger, Record};
use crate::robot::{Body, Finding, Outline, RobotError};
use crate::runner::Job;
use crate::streams::Streams;
pub(crate) use opening::open;

/// Who waits is answered so long before the time limit passes, or a tenth of it, that the answer still comes in time.
const ANSWER_BEFORE: Duration = Duration::from_millis(20);

/// How long to wait before a journal that cannot be written is tried again.
const RETRY_AFTER: Duration = Duration::from_millis(500);

/// What comes to a desk.
pub(crate) enum Mail {
    Place(Incoming<v1::PlaceRequest>),
    Outcome(Incoming<v1::OutcomeRequest>),
    Renew(Incoming<v1::RenewRequest>),
    State(Incoming<v1::CellStateRequest>),
    /// A placement has ended; what lies in the container now.
    Placed(Finding, Vec<Body>),
    /// The robot gave up before it touched anything.
    CutOff,
    /// A renewal has ended; what lies in the container now.
    Renewed(Result<(), RobotError>, Vec<Body>),
    /// The robot's thread is gone.
    RobotIsGone,
    /// No more requests will come: finish what is under way.
    End,
}

/// An end that could not be written down yet.
struct Unwritten {
    change: Change,
    failure: Option<String>,
}

/// What a desk works with.
pub(crate) struct Desk {
    pub(crate) ledger: Ledger,
    pub(crate) journal: CellJournal,
    pub(crate) objects: Option<BTreeMap<String, Outline>>,
    pub(crate) jobs: SyncSender<Job>,
    pub(crate) streams: Streams,
    /// The end of the whole process, asked for where the robot is gone.
    pub(crate) shutdown: Shutdown,
    /// The end of this service, at once.
    pub(crate) cut_off: Shutdown,
    pub(crate) progress: Progress,
}

/// What a desk has in hand.
pub(crate) struct Progress {
    is_robot_busy: bool,
    is_ending: bool,
    unwritten: Option<Unwritten>,
    /// Why the journal cannot be written, and when to try again.
    trouble: Option<(JournalError, Instant)>,
    outcomes: Vec<Incoming<v1::OutcomeRequest>>,
    renewals: Vec<Incoming<v1::RenewRequest>>,
    state_period: Duration,
    next_state: Instant,
}

impl Progress {
    pub(crate) fn new(state_period: Duration) -> Self {
        Self {
            is_robot_busy: false,
            is_ending: false,
            unwritten: None,
            trouble: None,
            outcomes: Vec::new(),
            renewals: Vec::new(),
            state_period,
            next_state: Instant::now(),
        }
    }
}

impl Desk {
    /// Works until the end is asked for and nothing is under way.
    pub(crate) fn run(mut self, mail: &Receiver<Mail>) {
        self.send(Job::Show(self.ledger.head().state_number));
        while !self.is_done() {
            match mail.recv_timeout(self.pause()) {
                Ok(mail) => self.take(mail),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            self.look_at_the_clock();
        }
    }

    fn is_done(&self) -> bool {
        let has_written = self.progress.unwritten.is_none() || self.cut_off.is_requested();
        self.progress.is_ending && !self.progress.is_robot_busy && has_written
    }

    fn take(&mut self, mail: Mail) {
        match mail {
            Mail::Place(incoming) => self.work_on(incoming, Self::place),
            Mail::Outcome(incoming) => self.work_on(incoming, Self::outcome),
            Mail::Renew(incoming) => self.work_on(incoming, Self::renew),
            Mail::State(incoming) => self.work_on(incoming, Self::state),
            Mail::Placed(finding, bodies) => {
                self.progress.is_robot_busy = false;
                self.end(self.ledger.end_placement(finding, bodies), None);
            }
            Mail::Renewed(Ok(()), bodies) => {
                self.progress.is_robot_busy = false;
                self.end(self.ledger.end_renewal(bodies), None);
            }
            Mail::Renewed(Err(error), bodies) => {
                self.progress.is_robot_busy = false;
                self.end(self.ledger.abandon_renewal(bodies), Some(error.to_string()));
            }
            Mail::CutOff => self.progress.is_robot_busy = false,
            Mail::RobotIsGone => {
                tracing::error!(
                    "the robot's thread ended by a panic: the process ends, to begin anew"
                );
                self.progress.is_robot_busy = false;
                self.shutdown.request();
            }
            Mail::End => self.progress.is_ending = true,
        }
    }

    /// Works on a request, as a part of its trace.
    fn work_on<R: Request>(
        &mut self,
        mut incoming: Incoming<R>,
        work: impl FnOnce(&mut Self, Incoming<R>),
    ) {
        incoming.start();
        let _entered = incoming.span().clone().entered();
        work(self, incoming);
    }

    fn state(&mut self, incoming: Incoming<v1::CellStateRequest>) {
        let reply = v1::CellStateReply {
            header: None,
            state: Some(self.streams.state_of(&self.ledger)),
        };
        incoming.reply(reply, Done::default());
    }

    /// Writes down a change and makes it; says how long the journal took.
    fn commit(&mut self, change: Change) -> Result<v1::StageTiming, JournalError> {
        let began = Instant::now();
        match self.journal.write(&self.ledger, &change) {
            Ok(()) => {
                self.progress.trouble = None;
                self.ledger.apply(change);
                Ok(header::stage("journal", began.elapsed()))
            }
            Err(error) => {
                let again = Instant::now() + RETRY_AFTER;
                self.progress.trouble = Some((error.clone(), again));
                Err(error)
            }
        }
    }

    /// Writes down the end of what was under way, and tells it.
    fn end(&mut self, change: Change, failure: Option<String>) {
        let unwritten = Unwritten {
            change: change.clone(),
            failure,
        };
        let ended = change.written.clone();
        if self.commit(change).is_err() {
            self.progress.unwritten = Some(unwritten);
            return;
        }
        self.progress.unwritten = None;
        match ended {
            Some((_, Record::Placement { placement, outcome })) => {
                self.tell_outcome(&placement, outcome.as_ref());
            }
            Some((_, Record::Renewal { state_number, .. })) => self.tell_renewed(state_number),
            None => self.tell_not_renewed(&unwritten.failure.unwrap_or_default()),
        }
        self.streams.tell_state(&self.ledger);
        self.send(Job::Show(self.ledger.head().state_number));
    }

    /// The robot is there as long as the desk; where its thread ended by a panic, the process ends too.
    fn send(&self, job: Job) {
        self.jobs.send(job).ok();
    }

    fn look_at_the_clock(&mut self) {
        let now = Instant::now();
        if self
            .progress
            .trouble
            .as_ref()
            .is_some_and(|(_, again)| *again <= now)
        {
            match self.progress.unwritten.take() {
                Some(unwritten) => self.end(unwritten.change, unwritten.failure),
                // Tells whether the journal can be written again; the health check says so.
                None => drop(self.commit(self.ledger.no_change())),
            }
        }
        self.give_up_waiting(now);
        if self.progress.next_state <= now {
            self.streams.tell_state(&self.ledger);
            self.progress.next_state = now + self.progress.state_period;
        }
    }

    /// Until something has to be done without being asked.
    fn pause(&self) -> Duration {
        let progress = &self.progress;
        let outcomes = progress.outcomes.iter().map(last_moment);
        let renewals = progress.renewals.iter().map(last_moment);
        let retry = progress.trouble.iter().map(|(_, again)| *again);
        let all = outcomes.chain(renewals).chain(retry);
        let first = all.fold(progress.next_state, Instant::min);
        first.saturating_duration_since(Instant::now())
    }

    /// Answers those whose time limit passed.
    fn give_up_waiting(&mut self, now: Instant) {
        for incoming in take_expired(&mut self.progress.outcomes, now) {
            self.refuse_outcome(incoming);
        }
        for incoming in take_expired(&mut self.progress.renewals, now) {
            let message = "the container is still being renewed";
            incoming.refuse(v1::Status::TimedOut, message);
        }
    }
}

fn take_expired<R: Request>(waiting: &mut Vec<Incoming<R>>, now: Instant) -> Vec<Incoming<R>> {
    waiting
        .extract_if(.., |incoming| last_moment(incoming) <= now)
        .collect()
}

/// When a request that waits has to be answered.
fn last_moment<R: Request>(incoming: &Incoming<R>) -> Instant {
    incoming.deadline() - ANSWER_BEFORE.min(incoming.header().time_limit / 10)
}
