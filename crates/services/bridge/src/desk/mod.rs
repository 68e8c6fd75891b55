//! The desk of a cell, an actor: answers requests, has the robot carry them out, writes down the
//! end.
//!
//! A request is written to the journal before the robot is told of it, and an outcome before
//! anybody is told of it. While the journal cannot be written, nothing begins, and outcomes wait.

mod expiry;
mod hold;
mod opening;
mod outcome;
mod place;
mod reach;
mod renew;
mod share;

use std::convert::Infallible;
use std::time::{Duration, Instant};

use ppnpack_service::Shutdown;
use ppnpack_service::actor::{Actor, Address, PendingRequests};
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, Status};
use ppnpack_wire::{WireError, header};

use crate::journal::{CellJournal, JournalError};
use crate::robot::{Body, Ending, Finding, RobotError};
use crate::runner::{Job, Jobs};
use crate::streams::Streams;
pub(crate) use expiry::TimeLimits;
pub(crate) use opening::{Early, open};
use ppnpack_protocol::ledger::{Change, Hold, Ledger, Record};
pub(crate) use reach::Reach;
pub(crate) use share::{Share, SharedRobot};

/// The maximum of requests that wait for the end of a placement.
const MOST_OUTCOMES: usize = 256;

/// The maximum of requests that wait for the end of a renewal.
const MOST_RENEWALS: usize = 64;

/// The pause before a journal that cannot be written is tried again.
const RETRY_AFTER: Duration = Duration::from_millis(500);

/// The failure of a placement that was aborted.
const BROKEN_OFF: &str = "it was broken off before anything was touched";

/// A status with which a request is refused, and why.
#[derive(Debug, PartialEq)]
struct Refusal(Status, String);

impl From<WireError> for Refusal {
    fn from(error: WireError) -> Self {
        Self(Status::Invalid, error.to_string())
    }
}

impl From<JournalError> for Refusal {
    fn from(error: JournalError) -> Self {
        Self(Status::Unavailable, error.to_string())
    }
}

/// A message to a desk.
pub(crate) enum Message {
    Place(Incoming<v1::PlaceRequest>),
    Outcome(Incoming<v1::OutcomeRequest>),
    Renew(Incoming<v1::RenewRequest>),
    Hold(Incoming<v1::HoldRequest>),
    Resume(Incoming<v1::ResumeRequest>),
    Changed(Incoming<v1::ChangedRequest>),
    State(Incoming<v1::CellStateRequest>),
    /// The robot has done its work.
    Ended(Ended),
    /// The robot gave up before it touched anything.
    CutOff,
    /// The robot took over the change with this number; these bodies lie in the container now.
    TakenOver(u64, Vec<Body>),
    /// The robot's thread is gone.
    RobotIsGone,
    /// No more requests will come: finish what is under way.
    End,
}

/// The end of a robot's work, and the bodies in the container then.
#[derive(Debug, Clone)]
pub(crate) enum Ended {
    Placement(Finding, Vec<Body>),
    Renewal(Result<(), RobotError>, Vec<Body>),
}

/// The robot, as a desk has it.
pub(crate) struct DeskRobot {
    /// Held, as the robot's actor ends without it.
    pub(crate) _actor: Address<Infallible>,
    pub(crate) jobs: Jobs,
    pub(crate) reach: Reach,
    pub(crate) share: Share,
}

/// A desk at work.
pub(crate) struct Desk {
    ledger: Ledger,
    journal: CellJournal,
    robot: DeskRobot,
    streams: Streams,
    /// The end of this service, at once.
    cut_off: Shutdown,
    limits: TimeLimits,
    /// The time at which the placement under way takes too long.
    overdue_at: Option<Instant>,
    is_robot_busy: bool,
    /// Counts the changes that people made in the container.
    changes: u64,
    is_ending: bool,
    /// An end that could not be written down yet.
    unwritten: Option<Ended>,
    /// The reason why the journal cannot be written, and the time to try again.
    trouble: Option<(JournalError, Instant)>,
    outcomes: PendingRequests<Incoming<v1::OutcomeRequest>>,
    renewals: PendingRequests<Incoming<v1::RenewRequest>>,
}

impl Actor for Desk {
    type Message = Message;

    fn handle(&mut self, message: Message) {
        match message {
            Message::Place(incoming) => self.work_in_time(incoming, Self::place),
            Message::Outcome(incoming) => self.work_on(incoming, Self::outcome),
            Message::Renew(incoming) => self.work_in_time(incoming, Self::renew),
            // Late or not, it is better held.
            Message::Hold(incoming) => self.work_on(incoming, answered(Self::hold)),
            Message::Resume(incoming) => self.work_in_time(incoming, answered(Self::resume)),
            Message::Changed(incoming) => self.work_in_time(incoming, answered(Self::changed)),
            Message::State(incoming) => self.work_on(incoming, answered(Self::state)),
            Message::Ended(ended) => {
                self.is_robot_busy = false;
                self.robot.share.end();
                self.end(ended);
            }
            Message::TakenOver(change, bodies) if change == self.changes => self.find(bodies),
            // That of a later change is still to come.
            Message::TakenOver(..) => {}
            Message::CutOff => self.was_cut_off(),
            // The process ends.
            Message::RobotIsGone => self.is_robot_busy = false,
            Message::End => self.is_ending = true,
        }
    }

    fn tick(&mut self) {
        let trouble = self.trouble.as_ref();
        if trouble.is_some_and(|(_, again)| *again <= Instant::now()) {
            match self.unwritten.take() {
                Some(ended) => self.end(ended),
                // Tries whether the journal can be written again; the health check says so.
                None => drop(self.commit(self.ledger.no_change())),
            }
        }
        self.hold_where_moved();
        for incoming in self.outcomes.take_expired() {
            self.refuse_outcome(incoming);
        }
        self.hold_where_overdue();
        self.follow_robot();
        let why = |_: &Incoming<_>| "the container is still being renewed".to_owned();
        self.renewals.refuse_expired(why);
        self.streams.tell_due_state(&self.ledger);
    }

    fn next_tick(&self) -> Option<Instant> {
        let expiries = [
            self.outcomes.next_expiry(),
            self.renewals.next_expiry(),
            self.trouble.as_ref().map(|(_, again)| *again),
            self.overdue_at,
        ];
        let first = expiries.into_iter().flatten();
        Some(first.fold(self.streams.next_state, Instant::min))
    }

    /// When the end is asked for and nothing is under way.
    fn has_ended(&self) -> bool {
        let has_written = self.unwritten.is_none() || self.cut_off.is_requested();
        self.is_ending && !self.is_robot_busy && has_written
    }
}

impl Desk {
    pub(crate) fn new(
        ledger: Ledger,
        journal: CellJournal,
        robot: DeskRobot,
        streams: Streams,
        cut_off: Shutdown,
        limits: TimeLimits,
    ) -> Self {
        let mut desk = Self {
            ledger,
            journal,
            robot,
            streams,
            cut_off,
            limits,
            overdue_at: None,
            is_robot_busy: false,
            changes: 0,
            is_ending: false,
            unwritten: None,
            trouble: None,
            outcomes: PendingRequests::new(MOST_OUTCOMES),
            renewals: PendingRequests::new(MOST_RENEWALS),
        };
        // In its own thread: a robot that hangs there keeps no hold waiting.
        desk.send_change();
        desk.robot.share.open(&desk.ledger.head().holds);
        // Holds may have come while the journal was opened.
        desk.follow_robot();
        desk
    }

    /// Works on a request in time; refuses it where its caller has stopped to wait.
    fn work_in_time<R: Request>(
        &mut self,
        incoming: Incoming<R>,
        work: impl FnOnce(&mut Self, Incoming<R>),
    ) {
        self.work_on(incoming, |desk, incoming| {
            if incoming.has_expired() {
                let message = "the time limit passed before it was looked at";
                return incoming.refuse(Status::TimedOut, message);
            }
            work(desk, incoming);
        });
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

    fn state(&mut self, _: &Incoming<v1::CellStateRequest>) -> Result<v1::CellStateReply, Refusal> {
        Ok(v1::CellStateReply {
            header: None,
            state: Some(self.streams.state_of(&self.ledger)),
        })
    }

    /// Writes down a change and makes it; says how long the journal took.
    fn commit(&mut self, change: Change) -> Result<v1::StageTiming, JournalError> {
        let began = Instant::now();
        match self.journal.write(&self.ledger, &change) {
            Ok(()) => {
                self.trouble = None;
                self.ledger.apply(change);
                Ok(header::stage("journal", began.elapsed()))
            }
            Err(error) => {
                let again = Instant::now() + RETRY_AFTER;
                self.trouble = Some((error.clone(), again));
                Err(error)
            }
        }
    }

    /// Holds the cell where its journal is not in its place any more: a restart would not know the
    /// requests that were acknowledged.
    fn hold_where_moved(&mut self) {
        let moved = self.trouble.as_ref().and_then(|(error, _)| error.moved());
        if let Some(reason) = moved {
            let head = self.ledger.head();
            let hold = Hold::own("moved", head.state_number, reason);
            if head.holds.iter().all(|own| own.id != hold.id) {
                self.robot.share.hold(hold, false);
            }
        }
    }

    /// Ends a placement that the robot gave up before it touched anything. Where the service ends,
    /// its next start settles that.
    fn was_cut_off(&mut self) {
        self.is_robot_busy = false;
        self.robot.share.end();
        if !self.cut_off.is_requested() {
            let finding = Finding::failed(Ending::NotPlaced, BROKEN_OFF);
            let bodies = self.ledger.head().bodies.clone();
            self.end(Ended::Placement(finding, bodies));
        }
    }

    /// Takes over the robot's word on the bodies in the container.
    fn find(&mut self, bodies: Vec<Body>) {
        if bodies == self.ledger.head().bodies {
            return;
        }
        // Where it cannot be written down, the bodies are told with the next change.
        if self.commit(self.ledger.find_bodies(bodies)).is_ok() {
            self.streams.tell_state(&self.ledger);
            self.show();
        }
    }

    /// Writes down the end of what was under way, and tells it.
    fn end(&mut self, ended: Ended) {
        self.overdue_at = None;
        // Of the ledger as it is now: it may have been held since.
        let change = match ended.clone() {
            Ended::Placement(finding, bodies) => self.ledger.end_placement(finding, bodies),
            Ended::Renewal(Ok(()), bodies) => self.ledger.end_renewal(bodies),
            Ended::Renewal(Err(_), bodies) => self.ledger.abandon_renewal(bodies),
        };
        let record = change.written.clone().map(|(_, record)| record);
        if self.commit(change).is_err() {
            self.unwritten = Some(ended);
            return;
        }
        self.unwritten = None;
        match (record, ended) {
            (Some(Record::Placement { placement, outcome }), _) => {
                self.tell_outcome(&placement, outcome.as_ref());
            }
            (Some(Record::Renewal { state_number, .. }), _) => {
                self.tell_renewed(&Ok(state_number.unwrap_or_default()));
            }
            (None, Ended::Renewal(Err(error), _)) => self.tell_renewed(&Err(error)),
            (None, _) => {}
        }
        self.streams.tell_state(&self.ledger);
        self.show();
    }

    /// Has the robot do this as soon as it can.
    fn send(&self, job: Job) {
        self.robot.jobs.put(job.kind(), job);
    }

    /// Has the robot take over the bodies that people left, and show them then.
    fn send_change(&mut self) {
        self.changes += 1;
        let bodies = self.ledger.head().bodies.clone();
        self.send(Job::Changed(self.changes, bodies));
        self.show();
    }

    /// Has the robot show the present state, where nothing is under way that changes it.
    fn show(&self) {
        if self.ledger.under_way().is_none() {
            self.send(Job::Show(self.ledger.head().state_number));
        }
    }
}

/// Work on a request that ends with its answer or its refusal.
fn answered<R: Request>(
    work: impl FnOnce(&mut Desk, &Incoming<R>) -> Result<R::Reply, Refusal>,
) -> impl FnOnce(&mut Desk, Incoming<R>) {
    |desk, incoming| match work(desk, &incoming) {
        Ok(reply) => incoming.reply(reply, Done::default()),
        Err(Refusal(status, message)) => incoming.refuse(status, message),
    }
}
