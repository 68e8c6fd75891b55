//! A packing session: the items that came, the decisions on them and the outcomes.
//!
//! A pure state machine. Each operation either changes the session as a whole or refuses and
//! changes nothing; the caller keeps a copy until the change is on disk.

mod container;
mod failure;
pub mod item;
pub mod message;

use ppnpack_wire::v1::{self, ItemState};

pub use container::{closed_container, open_container};
pub use failure::{AFTER_ANOTHER, FROM_BACKUP};
pub use item::Packed;

/// Maximum number of items of a session.
const MAX_ITEMS: usize = 1_000;

/// Maximum number of decisions remembered after their outcome, to tell a repeated report or request
/// from a new one.
const SETTLED_KEPT: usize = 64;

/// Maximum number of sessions remembered after their end, so that a late request begins none of
/// them again.
const PAST_KEPT: usize = 64;

/// The reason for which an operation was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SessionError {
    /// Nothing was begun.
    #[error("no session is under way: begin one first")]
    NoSession,
    /// No item has this id.
    #[error("there is no item {0} in this session")]
    UnknownItem(String),
    /// No item was announced of this order.
    #[error("no item of order {0} was announced in this session")]
    UnknownOrder(String),
    /// No decision has this id.
    #[error("there is no decision {0} in this session")]
    UnknownDecision(String),
    /// The item has an id that another one has.
    #[error("item {0} was announced before as something else")]
    OtherItem(String),
    /// The item cannot be chosen or taken out.
    #[error("item {0} does not wait: it was decided on, set aside or withdrawn")]
    NotWaiting(String),
    /// No more items may be set aside.
    #[error("no more than {0} items may be set aside in this session")]
    AsideFull(usize),
    /// Another decision is made only after this one has its outcome.
    #[error("decision {0} awaits its outcome: report that first")]
    Pending(String),
    /// The decision of the session before has no outcome.
    #[error("decision {0} awaits its outcome: report that first, or begin with gives_up_pending")]
    PendingBefore(String),
    /// The id is that of an earlier session.
    #[error("session {0} was before this one, and is not begun again: use a new id")]
    Past(String),
    /// The request was carried out, and its decision is settled.
    #[error("the request was answered before with decision {0}, which has its outcome")]
    Answered(String),
    /// The decision was settled as something else.
    #[error("decision {0} was reported before with another outcome")]
    OtherOutcome(String),
    /// No container has this name.
    #[error("there is no container '{0}' in this session")]
    UnknownContainer(String),
    /// Another container stands there.
    #[error("number {asked} of container '{name}' was asked for, but number {known} {}", if *.is_open { "is open there" } else { "is opened there next" })]
    OtherContainer {
        /// Its name.
        name: String,
        /// The number of the container that was asked for.
        asked: u64,
        /// The number of the one that is there, or comes next.
        known: u64,
        /// Whether it is open.
        is_open: bool,
    },
    /// There is no room for more items.
    #[error("a session holds at most {MAX_ITEMS} items")]
    Full,
    /// The report has no outcome.
    #[error("the outcome has no kind")]
    NoKind,
    /// Nobody who acknowledges has seen this failure.
    #[error("the session has failed: {0}: look, then name this failure: failure_id of the session")]
    Failed(String),
}

/// The end of a session.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// Every item is in the container.
    AllPacked,
    /// All packed but for what is set aside.
    OthersSetAside,
    /// No item of the buffer has a place, each for this reason.
    NothingFits(Vec<v1::ItemReason>),
    /// Somebody has to look, for this reason.
    Failed(String),
}

/// A packing session; the default is that of a cell before its first one. It is the message that is
/// sent and written, which is changed here alone.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Session(v1::Session);

impl Session {
    /// Begins a session over these containers.
    pub fn begin(
        id: String,
        containers: Vec<v1::SessionContainer>,
        is_automatic: bool,
        set_aside_limit: usize,
    ) -> Self {
        Self(v1::Session {
            session_id: id,
            containers,
            is_automatic,
            set_aside_limit: u32::try_from(set_aside_limit).unwrap_or(u32::MAX),
            ..v1::Session::default()
        })
    }

    /// Puts the next session in place of this one, whose pending decision, if any, has to be given
    /// up.
    pub fn followed_by(&self, next: Self, gives_up_pending: bool) -> Result<Self, SessionError> {
        let (Self(next), Self(own)) = (next, self);
        if own.past_session_ids.contains(&next.session_id) {
            return Err(SessionError::Past(next.session_id));
        }
        if let Some(pending) = own.pending.as_ref().filter(|_| !gives_up_pending) {
            return Err(SessionError::PendingBefore(pending.decision_id.clone()));
        }
        let id = Some(own.session_id.clone()).filter(|id| !id.is_empty());
        let past = own.past_session_ids.iter().cloned().chain(id);
        let surplus = past.clone().count().saturating_sub(PAST_KEPT);
        Ok(Self(v1::Session {
            past_session_ids: past.skip(surplus).collect(),
            failures: own.failures,
            switched_by: own.switched_by.clone(),
            ..next
        }))
    }

    /// Gives its name; empty before the first session.
    pub fn id(&self) -> &str {
        &self.0.session_id
    }

    /// The number of decisions that were made.
    pub fn step(&self) -> u64 {
        self.0.step
    }

    /// Gives the decision that awaits its outcome.
    pub fn pending(&self) -> Option<&v1::Decision> {
        self.0.pending.as_ref()
    }

    /// Says whether the planner has its decisions carried out by itself.
    pub fn is_automatic(&self) -> bool {
        self.0.is_automatic
    }

    /// Says whether nothing more is planned by itself.
    pub fn has_ended(&self) -> bool {
        self.0.end() != v1::SessionEnd::Unspecified
    }

    /// Says whether somebody has to look before anything goes on by itself.
    pub fn has_failed(&self) -> bool {
        self.0.end() == v1::SessionEnd::Failed
    }

    /// Says whether the outcome of every decision is known: there is a session, nothing is pending,
    /// and it has not failed, as one from a backup has.
    pub fn is_settled(&self) -> bool {
        !self.id().is_empty() && self.pending().is_none() && !self.has_failed()
    }

    /// Gives the items in the order of their arrival.
    pub fn items(&self) -> &[v1::SessionItem] {
        &self.0.items
    }

    /// Gives the mean planned cycle time of the packed items, in seconds; `None` where no arm
    /// packed any.
    pub fn mean_cycle_s(&self) -> Option<f64> {
        let packed = self.items().iter();
        let packed = packed.filter(|item| item.state() == ItemState::Packed);
        // A cycle takes time: zero is none.
        let cycles_s = packed.map(|item| item.cycle_s).filter(|it| *it > 0.0);
        let cycles_s: Vec<f64> = cycles_s.collect();
        let sum_s: f64 = cycles_s.iter().sum();
        (!cycles_s.is_empty()).then(|| sum_s / cycles_s.len() as f64)
    }

    /// Gives the first `count` waiting items.
    pub fn buffer(&self, count: usize) -> impl Iterator<Item = &v1::SessionItem> {
        let items = self.items().iter();
        let waiting = items.filter(|item| item.state() == ItemState::Waiting);
        waiting.take(count)
    }

    /// Finds a waiting item by its id.
    pub fn waiting(&self, item_id: &str) -> Result<&v1::SessionItem, SessionError> {
        let mut items = self.items().iter();
        let item = items.find(|item| item.item_id == item_id);
        let item = item.ok_or_else(|| SessionError::UnknownItem(item_id.to_owned()))?;
        match item.state() {
            ItemState::Waiting => Ok(item),
            _ => Err(SessionError::NotWaiting(item_id.to_owned())),
        }
    }

    /// Adds waiting items in their order. Those that were announced before are left as they are,
    /// but those that are set aside wait again.
    pub fn announce(&mut self, waiting: Vec<v1::SessionItem>) -> Result<(), SessionError> {
        self.must_be_under_way()?;
        for mut item in waiting {
            let mut items = self.0.items.iter_mut();
            if let Some(known) = items.find(|known| known.item_id == item.item_id) {
                if !item::is_same(known, &item) {
                    return Err(SessionError::OtherItem(item.item_id));
                }
                item::wait_again(known);
                continue;
            }
            if self.0.items.len() >= MAX_ITEMS && !self.forget_one() {
                return Err(SessionError::Full);
            }
            item.arrival = self.0.forgotten_items + self.0.items.len() as u64;
            item::enter(&mut item, ItemState::Waiting);
            self.0.items.push(item);
        }
        self.go_on();
        Ok(())
    }

    /// Withdraws an item that waits or is set aside. One that is withdrawn already stays so.
    pub fn withdraw(&mut self, item_id: &str) -> Result<(), SessionError> {
        let item = self.item_mut(item_id)?;
        match item.state() {
            ItemState::Waiting | ItemState::Withdrawn | ItemState::SetAside => {
                item::enter(item, ItemState::Withdrawn);
            }
            _ => return Err(SessionError::NotWaiting(item_id.to_owned())),
        }
        self.go_on();
        Ok(())
    }

    /// Has an order expect no more items than were announced: its announced number counts no
    /// longer.
    pub fn expects_no_more(&mut self, order: &str) -> Result<(), SessionError> {
        self.must_be_under_way()?;
        let lines = self.0.items.iter_mut();
        let lines = lines.filter_map(|item| item.order_line.as_deref_mut());
        let mut of_order = lines.filter(|line| line.order == order).peekable();
        if of_order.peek().is_none() {
            return Err(SessionError::UnknownOrder(order.to_owned()));
        }
        of_order.for_each(|line| line.order_items = 0);
        Ok(())
    }

    /// Says whether one more item may be set aside.
    pub fn may_set_aside(&self) -> bool {
        self.reasons_set_aside().count() < self.set_aside_limit()
    }

    fn set_aside_limit(&self) -> usize {
        usize::try_from(self.0.set_aside_limit).unwrap_or(usize::MAX)
    }

    /// Sets a waiting item aside at the present step, as it has no valid placement.
    pub fn set_aside(&mut self, reason: v1::ItemReason) -> Result<(), SessionError> {
        if !self.may_set_aside() {
            return Err(SessionError::AsideFull(self.set_aside_limit()));
        }
        let step = self.0.step;
        let item = self.item_mut(&reason.item_id)?;
        if item.state() != ItemState::Waiting {
            return Err(SessionError::NotWaiting(reason.item_id));
        }
        item::enter(item, ItemState::SetAside);
        item.set_aside = Some(reason);
        item.set_aside_step = step;
        Ok(())
    }

    /// Gives the reasons of the items that are set aside.
    pub fn reasons_set_aside(&self) -> impl Iterator<Item = &v1::ItemReason> {
        let items = self.items().iter();
        items.filter_map(|item| item.set_aside.as_ref())
    }

    /// Gives the reasons of the items that were set aside at the present step.
    pub fn reasons_set_aside_now(&self) -> Vec<v1::ItemReason> {
        let items = self.items().iter();
        let now = items.filter(|item| item.set_aside_step == self.0.step);
        now.filter_map(|item| item.set_aside.clone()).collect()
    }

    /// Gives the end of the session where no item waits any more.
    pub fn end_of_items(&self) -> End {
        match self.reasons_set_aside().next() {
            Some(_) => End::OthersSetAside,
            None => End::AllPacked,
        }
    }

    /// Finds the decision that a request was answered with before, if it was.
    pub fn answered(&self, request_id: &str) -> Result<Option<&v1::Decision>, SessionError> {
        self.must_be_under_way()?;
        if let Some(pending) = self.pending() {
            return if pending.request_id == request_id {
                Ok(Some(pending))
            } else {
                Err(SessionError::Pending(pending.decision_id.clone()))
            };
        }
        let mut settled = self.0.settled.iter();
        match settled.find(|settled| settled.request_id == request_id) {
            Some(settled) if !request_id.is_empty() => {
                Err(SessionError::Answered(settled.decision_id.clone()))
            }
            _ => Ok(None),
        }
    }

    /// Enters a decision, which then awaits its outcome.
    pub fn decide(&mut self, decision: v1::Decision) -> Result<(), SessionError> {
        if let Some(pending) = self.pending() {
            return Err(SessionError::Pending(pending.decision_id.clone()));
        }
        item::enter(self.item_mut(&decision.item_id)?, ItemState::Decided);
        self.0.step += 1;
        self.go_on();
        self.0.pending = Some(decision);
        Ok(())
    }

    /// Enters the outcome of a decision. The same report again changes nothing. Where nobody knows
    /// where the item is, the automatic mode ends: it may lie in the robot's way.
    pub fn report(&mut self, decision_id: &str, outcome: &v1::Outcome) -> Result<(), SessionError> {
        let kind = outcome.kind();
        if kind == v1::OutcomeKind::Unspecified {
            return Err(SessionError::NoKind);
        }
        let mut settled = self.0.settled.iter();
        if let Some(settled) = settled.find(|settled| settled.decision_id == decision_id) {
            return match settled.kind() == kind {
                true => Ok(()),
                false => Err(SessionError::OtherOutcome(decision_id.to_owned())),
            };
        }
        let pending = &mut self.0.pending;
        let decision = pending.take_if(|pending| pending.decision_id == decision_id);
        let unknown = || SessionError::UnknownDecision(decision_id.to_owned());
        self.settle(decision.ok_or_else(unknown)?, outcome);
        Ok(())
    }

    /// Enters the outcome of the decision that was pending.
    fn settle(&mut self, decision: v1::Decision, outcome: &v1::Outcome) {
        let kind = outcome.kind();
        let container = self.container(&decision.container);
        let sequence = container.map_or(0, |container| container.sequence);
        if let Ok(item) = self.item_mut(&decision.item_id) {
            item::enter_outcome(item, &decision, outcome, sequence);
        }
        self.needs_state(&decision.container, Some(outcome.state_number));
        if self.is_automatic() && matches!(kind, v1::OutcomeKind::Lost | v1::OutcomeKind::Unknown) {
            self.end(End::Failed(gone(&decision.item_id, outcome)));
        }
        if self.0.settled.len() >= SETTLED_KEPT {
            self.0.settled.remove(0);
        }
        self.0.settled.push(v1::SettledDecision {
            decision_id: decision.decision_id,
            request_id: decision.request_id,
            kind: kind.into(),
        });
    }

    /// Enters the inspection of an item; says whether it was packed.
    pub fn inspected(
        &mut self,
        item_id: &str,
        inspection: v1::Inspection,
    ) -> Result<bool, SessionError> {
        Ok(item::inspected(self.item_mut(item_id)?, inspection))
    }

    /// Goes on, as more can be packed. A failure stays: the automatic mode goes on when somebody
    /// who has looked switches it on.
    fn go_on(&mut self) {
        if !self.has_failed() {
            self.set_end(None);
        }
    }

    /// Ends the session in this way.
    pub fn end(&mut self, end: End) {
        self.set_end(Some(end));
    }

    fn set_end(&mut self, end: Option<End>) {
        (self.0.reasons, self.0.failure) = (Vec::new(), String::new());
        let end = match end {
            None => v1::SessionEnd::Unspecified,
            Some(End::AllPacked) => v1::SessionEnd::AllPacked,
            Some(End::OthersSetAside) => v1::SessionEnd::OthersSetAside,
            Some(End::NothingFits(reasons)) => {
                self.0.reasons = reasons;
                v1::SessionEnd::NothingFits
            }
            Some(End::Failed(failure)) => {
                self.0.failure = failure;
                self.0.failures += 1;
                v1::SessionEnd::Failed
            }
        };
        self.0.set_end(end);
    }

    fn item_mut(&mut self, item_id: &str) -> Result<&mut v1::SessionItem, SessionError> {
        let mut items = self.0.items.iter_mut();
        let item = items.find(|item| item.item_id == item_id);
        item.ok_or_else(|| SessionError::UnknownItem(item_id.to_owned()))
    }

    fn must_be_under_way(&self) -> Result<(), SessionError> {
        match self.id().is_empty() {
            true => Err(SessionError::NoSession),
            false => Ok(()),
        }
    }
}

/// Says why the automatic mode ends where an item is not in its place.
fn gone(item_id: &str, outcome: &v1::Outcome) -> String {
    let what = match outcome.kind() {
        v1::OutcomeKind::Lost => "left the cell",
        _ => "may lie anywhere",
    };
    format!(
        "item {item_id} {what}: {}; look for it, then switch the automatic mode on again",
        outcome.failure
    )
}

#[cfg(test)]
mod tests;
