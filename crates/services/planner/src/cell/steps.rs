//! The steps of a cell: asked for, planned on a thread of their own, and entered.

use std::mem::discriminant;
use std::time::{Duration, Instant};

use ppnpack_protocol::session::End;
use ppnpack_service::clock::Boottime;
use ppnpack_service::rpc::{Done, Incoming};
use ppnpack_wire::header;
use ppnpack_wire::header::RequestHeader;
use ppnpack_wire::v1::{self, Status};

use super::CellPlanner;
use super::session::Version;
use crate::counts;
use crate::refusal::Refusal;
use crate::settings::MAX_ALTERNATIVES;
use crate::step::{Chosen, Decided, NotPlanned, Planned, Request, Step, Stepped, Work};

/// Minimum time in which it is worth to look once more for a picture.
const LEAST_LOOK: Duration = Duration::from_millis(100);

/// Why a request is refused that was made before the session began.
const ANOTHER_SESSION: &str = "another session has begun: plan again";

/// A step that is being made.
#[derive(Debug)]
pub(super) struct UnderWay {
    begun: Instant,
    /// The session that it was given.
    version: Version,
}

/// A request that waits for its step, and why one that was made before led to nothing.
pub(super) type Waiting = (Request, Option<Refusal>);

/// The result of a step as it is entered.
pub(super) enum Entered {
    Decision(Box<v1::Decision>),
    NothingFits(Vec<v1::ItemReason>),
    NothingWaits,
}

/// Why a result is not entered.
pub(super) enum NotEntered {
    /// It may come out otherwise: it has to be planned again.
    Again(Option<Refusal>),
    Refused(Refusal),
}

impl From<Refusal> for NotEntered {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

/// Does the same with a request of any kind.
macro_rules! of_any_kind {
    ($request:expr, $incoming:ident => $what:expr) => {
        match $request {
            Request::Plan($incoming) => $what,
            Request::Explain($incoming) => $what,
        }
    };
}

impl Request {
    fn header(&self) -> &RequestHeader {
        of_any_kind!(self, incoming => incoming.header())
    }

    /// Says that work on it begins.
    fn start(&mut self) {
        of_any_kind!(self, incoming => incoming.start());
    }

    fn answer_by(&self) -> Instant {
        of_any_kind!(self, incoming => incoming.answer_by())
    }

    /// Gives the time at which it came.
    fn came(&self) -> Boottime {
        of_any_kind!(self, incoming => incoming.came())
    }

    /// Says whether another one was sent as the same request.
    fn is_same(&self, other: &Self) -> bool {
        let id = &self.header().request_id;
        let is_of_kind = discriminant(self) == discriminant(other);
        is_of_kind && !id.is_empty() && *id == other.header().request_id
    }

    /// Leaves it to another one of the same request to be answered.
    fn leave(self) {
        of_any_kind!(self, incoming => incoming.leave());
    }

    fn refuse(self, refusal: Refusal) {
        let Refusal { status, message } = refusal;
        of_any_kind!(self, incoming => incoming.refuse(status, message));
    }
}

impl CellPlanner {
    /// Has a request wait for its step. One that its caller sent again, as it heard nothing, is
    /// planned once, and the one that came last is answered.
    pub(super) fn wait_for_step(&mut self, mut request: Request, unseen: Option<Refusal>) {
        let is_same = |(other, _): &Waiting| other.is_same(&request);
        if let Some((kept, why)) = self.waiting.find(is_same) {
            if kept.came() < request.came() {
                std::mem::swap(kept, &mut request);
            }
            *why = unseen.or(why.take());
            return request.leave();
        }
        let answer_by = request.answer_by();
        if let Err((request, _)) = self.waiting.keep((request, unseen), answer_by) {
            request.refuse(Refusal::new(Status::Busy, "too many wait already"));
        }
    }

    /// Refuses the requests whose time is over, and begins the step of the first of the others
    /// where none is under way.
    pub(super) fn go_on_with_requests(&mut self) {
        for (request, unseen) in self.waiting.take_expired() {
            let why = match self.is_inspecting() {
                true => "the time limit passed while the item placed before was inspected",
                false => "the time limit passed while another step was planned",
            };
            request.refuse(unseen.unwrap_or_else(|| Refusal::new(Status::TimedOut, why)));
        }
        while self.step_under_way.is_none() && !self.is_first_inspecting() {
            let Some((request, _)) = self.waiting.take_first() else {
                return;
            };
            self.begin_requested(request);
        }
    }

    /// Refuses the requests that wait, as another session has begun.
    pub(super) fn refuse_waiting(&mut self) {
        for (request, _) in self.waiting.take(|_| true) {
            request.refuse(Refusal::new(Status::Conflict, ANOTHER_SESSION));
        }
    }

    fn begin_requested(&mut self, mut request: Request) {
        request.start();
        let is_possible = self.must_be_meant(request.header());
        let answered = is_possible.and_then(|()| match &request {
            Request::Plan(incoming) => self.answered_before(incoming),
            Request::Explain(_) => Ok(None),
        });
        match (answered, request) {
            (Ok(None), request) => self.begin_step(Work::Requested(request)),
            (Ok(Some(decision)), Request::Plan(incoming)) => {
                let reply = self.plan_reply(Entered::Decision(Box::new(decision)));
                incoming.reply(reply, Done::default());
            }
            (Ok(Some(_)), Request::Explain(_)) => {}
            (Err(refusal), request) => request.refuse(refusal),
        }
    }

    /// Gives the decision that a plan was answered with before, where it is still pending.
    fn answered_before(
        &self,
        incoming: &Incoming<v1::PlanRequest>,
    ) -> Result<Option<v1::Decision>, Refusal> {
        let alternatives = incoming.message().alternatives as usize;
        if alternatives > MAX_ALTERNATIVES {
            return Err(Refusal::invalid(format_args!(
                "alternatives: {alternatives} where at most {MAX_ALTERNATIVES} are possible"
            )));
        }
        let answered = self.session.answered(&incoming.header().request_id)?;
        if answered.is_none() && self.session.is_automatic() && !self.session.has_ended() {
            let on = "the automatic mode is on: switch it off to plan by request";
            return Err(Refusal::new(Status::Conflict, on));
        }
        Ok(answered.cloned())
    }

    /// Begins a step, where none is under way.
    pub(super) fn begin_step(&mut self, work: Work) {
        let changes = self.places.iter_mut();
        let step = Step {
            session: self.session.clone(),
            changes: changes
                .map(|place| std::mem::take(&mut place.change))
                .collect(),
            work,
        };
        self.step_under_way = Some(UnderWay {
            begun: Instant::now(),
            version: self.session.version(),
        });
        // Where its thread has ended, so does the process.
        self.stepper.send(step).ok();
    }

    /// Takes the result of the step that was under way.
    pub(super) fn on_stepped(&mut self, stepped: Stepped) {
        let Some(UnderWay { begun, version }) = self.step_under_way.take() else {
            return;
        };
        let done = || Done::in_one("work", begun.elapsed());
        match stepped {
            Stepped::Automatic(deadline, planned) => {
                let entered = self.enter(planned, version, deadline);
                self.go_on_after(entered);
            }
            Stepped::Plan(incoming, planned) => {
                match self.enter(planned, version, incoming.deadline()) {
                    Ok(entered) => incoming.reply(self.plan_reply(entered), done()),
                    Err(error) => self.not_entered(Request::Plan(incoming), version, error),
                }
            }
            Stepped::Explain(incoming, Ok(reply)) => incoming.reply(*reply, done()),
            Stepped::Explain(incoming, Err(error)) => {
                let error = match self.session.version() == version {
                    true => self.not_planned(error),
                    false => NotEntered::Again(None),
                };
                self.not_entered(Request::Explain(incoming), version, error);
            }
            Stepped::Inspection(decision_id, inspected) => {
                self.on_inspected(&decision_id, inspected);
            }
        }
    }

    /// Refuses a request, or has it wait for another step where it has the time.
    fn not_entered(&mut self, request: Request, version: Version, error: NotEntered) {
        let is_of_another = !self.session.version().is_of_same_session(&version);
        let is_late = request.answer_by() <= Instant::now() + LEAST_LOOK;
        match error {
            NotEntered::Again(_) if is_of_another => {
                request.refuse(Refusal::new(Status::Conflict, ANOTHER_SESSION));
            }
            NotEntered::Again(Some(unseen)) if is_late => request.refuse(unseen),
            NotEntered::Again(unseen) => self.wait_for_step(request, unseen),
            NotEntered::Refused(refusal) => request.refuse(refusal),
        }
    }

    /// Enters the result of a step, where it holds in the session as it is now; it is on disk when
    /// this returns.
    fn enter(
        &mut self,
        planned: Planned,
        version: Version,
        deadline: Instant,
    ) -> Result<Entered, NotEntered> {
        let Planned { set_aside, decided } = planned;
        let now = self.session.version();
        // A decision holds whatever arrived meanwhile.
        let holds = match decided {
            Ok(Decided::Decision(_)) => now.is_but_for_new_items(&version),
            _ => now == version,
        };
        if !holds {
            return Err(NotEntered::Again(None));
        }
        // All or none of it.
        self.session.change_unsaved(|session| {
            let mut reasons = set_aside.into_iter();
            reasons.try_for_each(|reason| session.set_aside(reason))
        })?;
        let entered = match decided {
            Ok(Decided::Decision(chosen)) => self.enter_decision(*chosen, deadline),
            Ok(Decided::NothingFits(reasons)) => Ok(Entered::NothingFits(reasons)),
            Ok(Decided::NothingWaits) => Ok(Entered::NothingWaits),
            Err(error) => Err(self.not_planned(error)),
        };
        self.session.save()?;
        entered
    }

    fn not_planned(&mut self, error: NotPlanned) -> NotEntered {
        match error {
            NotPlanned::Refused(refusal) => NotEntered::Refused(refusal),
            NotPlanned::Unseen(refusal) => NotEntered::Again(Some(refusal)),
            NotPlanned::Failed(why) => {
                tracing::error!(cell = %self.cell, why, "the session has failed");
                let ended = self.session.end(End::Failed(why.clone()));
                let refusal = ended.err().unwrap_or_else(|| Refusal::unavailable(why));
                NotEntered::Refused(refusal)
            }
        }
    }

    fn enter_decision(&mut self, chosen: Chosen, deadline: Instant) -> Result<Entered, NotEntered> {
        // Whoever asked may have left, and a decision that nobody knows of keeps others waiting.
        if Instant::now() >= deadline {
            let late = "the time limit passed while planning";
            return Err(Refusal::new(Status::TimedOut, late).into());
        }
        let Chosen {
            mut decision,
            before,
            plan,
            found,
        } = chosen;
        let saving = Instant::now();
        let entered = decision.clone();
        self.session.change(|session| session.decide(entered))?;
        decision
            .stages
            .push(header::stage("save", saving.elapsed()));
        counts::decisions(&self.cell, !decision.degraded.is_empty(), 1);
        self.news.record = self
            .recorder
            .record(self.session.id(), &plan, &found, Some(&decision));
        self.will_inspect(&decision, &before);
        self.news.decision = Some(decision.clone());
        Ok(Entered::Decision(Box::new(decision)))
    }

    fn plan_reply(&self, entered: Entered) -> v1::PlanReply {
        let mut reply = v1::PlanReply {
            set_aside: self.session.reasons_set_aside_now(),
            ..v1::PlanReply::default()
        };
        match entered {
            Entered::Decision(decision) => {
                reply.set_result(v1::PlanResult::Decided);
                reply.set_aside.clone_from(&decision.set_aside);
                reply.decision = Some(*decision);
            }
            Entered::NothingFits(reasons) => {
                reply.set_result(v1::PlanResult::NothingFits);
                reply.reasons = reasons;
            }
            Entered::NothingWaits => reply.set_result(v1::PlanResult::NothingWaits),
        }
        reply
    }
}
