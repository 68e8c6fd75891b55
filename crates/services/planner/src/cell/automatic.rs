//! The automatic mode: plan, have the bridge place, take the outcome, see the container again,
//! until nothing is left.
//!
//! Nothing of it is remembered but what the session has on disk: after a restart the pending
//! decision is sent to the bridge again, which executes a placement once whatever is repeated.

use std::time::{Duration, Instant};

use ppnpack_protocol::pursuit::{self, Next};
use ppnpack_protocol::session::{End, Session};
use ppnpack_service::rpc::CallError;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, OutcomeKind, Status};

use super::CellPlanner;
use super::steps::{Entered, NotEntered};
use crate::refusal::Refusal;
use crate::step::Work;

/// Maximum time to plan one step, for each open container, with the wait for a heightmap.
const PLAN_LIMIT: Duration = Duration::from_secs(2);

/// Maximum time of one request to the bridge.
const BRIDGE_LIMIT: Duration = Duration::from_secs(1);

/// Pause before something that failed is tried again.
const PAUSE: Duration = Duration::from_millis(100);

/// Pause before a held cell is asked again whether it goes on.
const HELD_PAUSE: Duration = Duration::from_millis(200);

/// Pause in which an empty container, or anything else that changes the session, is waited for.
const RENEWAL_PAUSE: Duration = Duration::from_secs(5);

/// Interval at which the bridge is asked for an outcome that should have come by itself.
const ASK_EVERY: Duration = Duration::from_millis(500);

/// Maximum attempts at one item before somebody has to look.
const MAX_ATTEMPTS: u32 = 5;

/// The progress of the automatic mode.
#[derive(Debug, Default)]
pub(crate) struct Automatic {
    /// The decision that the bridge works on.
    placing: Option<Placing>,
    /// The time before which nothing is tried again.
    resume_at: Option<Instant>,
    /// The container whose bridge said last that the cell is held; nothing is planned meanwhile.
    held: Option<String>,
    /// The item that was not placed the last time, and how often in a row.
    refused: (String, u32),
}

#[derive(Debug)]
struct Placing {
    decision_id: String,
    since: Instant,
    asked: Instant,
    is_accepted: bool,
}

impl Automatic {
    /// Gives when the thread has to look again; `None` where only a request can change anything.
    pub(crate) fn wakes_at(&self, session: &Session) -> Option<Instant> {
        if !is_on(session) {
            return None;
        }
        let accepted = self.placing.as_ref().filter(|placing| placing.is_accepted);
        let asks_at = accepted.map(|placing| placing.asked + ASK_EVERY);
        Some(self.resume_at.or(asks_at).unwrap_or_else(Instant::now))
    }

    /// Ends a pause: what was waited for may be there.
    pub(super) fn go_on(&mut self) {
        self.resume_at = None;
    }

    fn pause(&mut self, pause: Duration) {
        self.resume_at = Some(Instant::now() + pause);
    }
}

fn is_on(session: &Session) -> bool {
    session.is_automatic() && !session.has_ended() && !session.items().is_empty()
}

impl CellPlanner {
    /// Goes on with the automatic mode, where it is on and not waiting.
    pub(crate) fn advance(&mut self) {
        if !is_on(&self.session) {
            self.automatic.placing = None;
            return;
        }
        // How the last item lies is known first: a missing one may be in the arm's way.
        if self.is_inspecting() {
            return;
        }
        let resume_at = self.automatic.resume_at;
        if resume_at.is_some_and(|at| Instant::now() < at) {
            return;
        }
        self.automatic.resume_at = None;
        if let Some(held) = self.automatic.held.clone()
            && !self.is_resumed(&held)
        {
            return;
        }
        let went = match self.session.pending().cloned() {
            Some(decision) => self.pursue(&decision),
            None => {
                self.next_step();
                Ok(())
            }
        };
        if let Err(refusal) = went {
            self.try_again(&refusal);
        }
    }

    fn try_again(&mut self, refusal: &Refusal) {
        tracing::warn!(cell = %self.cell, reason = refusal.message, "trying again");
        self.automatic.pause(PAUSE);
    }

    fn next_step(&mut self) {
        if self.step_under_way.is_some() {
            return;
        }
        let containers = self.session.containers().iter();
        let open = containers.filter(|container| container.is_open).count();
        if open == 0 && self.session.buffer(1).next().is_some() {
            // It goes on when one is opened.
            self.automatic.pause(RENEWAL_PAUSE);
            return;
        }
        let open = u32::try_from(open).unwrap_or(u32::MAX).max(1);
        self.begin_step(Work::Automatic(Instant::now() + PLAN_LIMIT * open));
    }

    /// Goes on after a step of the automatic mode.
    pub(super) fn go_on_after(&mut self, entered: Result<Entered, NotEntered>) {
        let went = match entered {
            Ok(Entered::Decision(_)) | Err(NotEntered::Again(None)) => Ok(()),
            Ok(Entered::NothingWaits) => self.end_or_renew(self.session.end_of_items()),
            Ok(Entered::NothingFits(reasons)) => self.end_or_renew(End::NothingFits(reasons)),
            Err(NotEntered::Again(Some(refusal)) | NotEntered::Refused(refusal)) => Err(refusal),
        };
        if let Err(refusal) = went {
            self.try_again(&refusal);
        }
    }

    /// Ends the automatic mode, or has a container renewed: items that are left are for the next
    /// one, where one comes.
    fn end_or_renew(&mut self, end: End) -> Result<(), Refusal> {
        if end != End::AllPacked {
            if self.session.is_renewing() {
                self.automatic.pause(RENEWAL_PAUSE);
                return Ok(());
            }
            if self.close_fullest()? {
                return Ok(());
            }
        }
        self.finish(end)
    }

    fn finish(&mut self, end: End) -> Result<(), Refusal> {
        tracing::info!(cell = %self.cell, session = self.session.id(), ?end, "the automatic mode has ended");
        self.session.end(end)
    }

    /// Has a decision carried out, or looks how it went.
    fn pursue(&mut self, decision: &v1::Decision) -> Result<(), Refusal> {
        let now = Instant::now();
        let placing = match self.automatic.placing.take() {
            Some(placing) if placing.decision_id == decision.decision_id => placing,
            _ => Placing {
                decision_id: decision.decision_id.clone(),
                since: now,
                asked: now,
                is_accepted: false,
            },
        };
        let limit = Duration::from_secs_f64(self.settings.place_limit_s);
        if placing.since.elapsed() > limit {
            let failure = format!(
                "decision {} was not carried out within {} s",
                decision.decision_id, self.settings.place_limit_s
            );
            return self.finish(End::Failed(failure));
        }
        let is_accepted = placing.is_accepted;
        self.automatic.placing = Some(placing);
        if is_accepted {
            self.ask_outcome(decision, now)
        } else {
            self.place(decision)
        }
    }

    fn ask_bridge<R: Request>(
        &mut self,
        container: &str,
        request: R,
        limit: Duration,
    ) -> Result<R::Reply, CallError> {
        // The settings name its containers: a session with others has failed.
        let place = self.place_of(container);
        let place = place.map_err(|error| CallError::Zenoh(error.to_string()))?;
        place.bridge.call(request, Instant::now() + limit)
    }

    fn place(&mut self, decision: &v1::Decision) -> Result<(), Refusal> {
        let answer = self.ask_bridge(
            &decision.container,
            v1::PlaceRequest::from(decision),
            BRIDGE_LIMIT,
        );
        if let (Ok(_), Some(placing)) = (&answer, &mut self.automatic.placing) {
            placing.is_accepted = true;
            placing.asked = Instant::now();
        }
        if let Err(error) = &answer
            && error.status() == Some(Status::Held)
        {
            tracing::info!(cell = %self.cell, reason = %error, "waiting until the cell is resumed");
            self.automatic.held = Some(decision.container.clone());
            // Another container of the robot may be held: this one's state does not say so.
            self.automatic.pause(HELD_PAUSE);
        }
        let answer = answer.map(|reply| reply.execution);
        self.go_on_with(decision, &answer, pursuit::after_place)
    }

    /// Does what comes next about a decision by what the bridge answered.
    fn go_on_with(
        &mut self,
        decision: &v1::Decision,
        answer: &Result<Option<v1::Execution>, CallError>,
        next: impl FnOnce(pursuit::Answer<'_>) -> Next,
    ) -> Result<(), Refusal> {
        let refused = answer.as_ref().err();
        let refused = refused.map_or_else(String::new, ToString::to_string);
        match next(answer.as_ref().map(Option::as_ref).map_err(status)) {
            Next::Wait => Ok(()),
            Next::Settle(outcome) => {
                self.settle(&decision.item_id, &decision.decision_id, &outcome)
            }
            Next::SettleAs(kind) => self.settle_here(decision, kind, &refused),
            Next::PlaceAgain => {
                self.automatic.placing = None;
                Ok(())
            }
            Next::AskAgain => Err(Refusal::unavailable(format_args!("bridge: {refused}"))),
            Next::GiveUp => {
                let failure = format!("the bridge refuses the placement: {refused}");
                self.finish(End::Failed(failure))
            }
        }
    }

    /// Says whether the held cell goes on; else it is asked again after a pause.
    fn is_resumed(&mut self, container: &str) -> bool {
        let asked = self.ask_bridge(container, v1::CellStateRequest::default(), BRIDGE_LIMIT);
        let state = asked.ok().and_then(|reply| reply.state);
        let is_resumed = state.is_some_and(|state| state.hold.is_none());
        if is_resumed {
            tracing::info!(cell = %self.cell, "the cell goes on");
            self.automatic.held = None;
            self.containers_changed();
        } else {
            self.automatic.pause(HELD_PAUSE);
        }
        is_resumed
    }

    /// Settles a decision of which the bridge has no outcome, at the state that the cell has now.
    fn settle_here(
        &mut self,
        decision: &v1::Decision,
        kind: OutcomeKind,
        failure: &str,
    ) -> Result<(), Refusal> {
        let request = v1::CellStateRequest::default();
        let asked = self.ask_bridge(&decision.container, request, BRIDGE_LIMIT);
        let silent = |error| Refusal::unavailable(format_args!("bridge: {error}"));
        let state = asked.map_err(silent)?.state.unwrap_or_default();
        let kind = pursuit::as_known(kind, decision, &state);
        let outcome = pursuit::settled_as(decision, kind, failure, state.state_number);
        self.automatic.placing = None;
        self.enter_outcome(&decision.decision_id, &outcome)
    }

    fn ask_outcome(&mut self, decision: &v1::Decision, now: Instant) -> Result<(), Refusal> {
        match &mut self.automatic.placing {
            Some(placing) if placing.asked.elapsed() < ASK_EVERY => {
                self.automatic.resume_at = Some(placing.asked + ASK_EVERY);
                return Ok(());
            }
            Some(placing) => placing.asked = now,
            None => return Ok(()),
        }
        let request = v1::OutcomeRequest {
            placement_id: decision.decision_id.clone(),
            ..v1::OutcomeRequest::default()
        };
        let answer = self.ask_bridge(&decision.container, request, BRIDGE_LIMIT / 10);
        let answer = answer.map(|reply| reply.execution);
        self.go_on_with(decision, &answer, pursuit::after_outcome)
    }

    /// Takes an outcome that the bridge told of by itself.
    pub(crate) fn on_outcome(&mut self, outcome: &v1::Outcome) {
        let Some(pending) = self.session.pending() else {
            return;
        };
        if !is_on(&self.session) || pending.decision_id != outcome.placement_id {
            return;
        }
        let (item_id, decision_id) = (pending.item_id.clone(), pending.decision_id.clone());
        if let Err(refusal) = self.settle(&item_id, &decision_id, outcome) {
            // It is asked for again.
            tracing::warn!(cell = %self.cell, reason = refusal.message, "an outcome is not entered");
        }
    }

    fn settle(
        &mut self,
        item_id: &str,
        decision_id: &str,
        outcome: &v1::Outcome,
    ) -> Result<(), Refusal> {
        // What cannot be is believed by nobody: somebody has to look.
        let until = Instant::now() + BRIDGE_LIMIT;
        if let Err(refusal) = self.check_reported(decision_id, outcome, until) {
            let said = refusal.message;
            let failure = format!("the bridge says what cannot be of item {item_id}: {said}");
            return self.finish(End::Failed(failure));
        }
        self.enter_outcome(decision_id, outcome)?;
        self.automatic.placing = None;
        self.automatic.resume_at = None;
        if outcome.kind() != OutcomeKind::NotPlaced {
            self.automatic.refused = Default::default();
            return Ok(());
        }
        let (refused, before) = std::mem::take(&mut self.automatic.refused);
        let attempts = if refused == item_id { before + 1 } else { 1 };
        if attempts < MAX_ATTEMPTS {
            self.automatic.refused = (item_id.to_owned(), attempts);
            return Ok(());
        }
        let failure = format!(
            "item {item_id} was not placed in {MAX_ATTEMPTS} attempts, the last time because: {}",
            outcome.failure
        );
        self.finish(End::Failed(failure))
    }
}

/// Gives the status with which the bridge refused; `None` where nobody answered.
fn status(error: &CallError) -> Option<Status> {
    match error {
        CallError::TimedOut => Some(Status::TimedOut),
        _ => error.status(),
    }
}
