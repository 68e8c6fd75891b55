//! The action `Pack`: items are packed in a session of their own, by the planner's automatic mode.
//!
//! A packing takes minutes, tells how it goes and can be broken off, which is what actions are for; a single placement is decided in
//! milliseconds and cannot be taken back, so there is none for it. Cancelled, the items that wait are withdrawn: the planner brings what is
//! under way to its end, in its own way, and nothing is left pending.

use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use ppnpack_ros::action::{ActionServer, Goal, Status, Work};
use ppnpack_ros::messages::ppnpack_actions::{Pack, PackFeedback, PackGoal, PackResult};
use ppnpack_ros::messages::ppnpack_msgs::{Announcement, Item};
use ppnpack_ros::names::Name;
use ppnpack_service::Shutdown;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::CallError;
use ppnpack_service::stream::Latest;
use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1::{self, ItemState, SessionEnd};

use crate::cells::Common;
use crate::convert::messages;
use crate::error::FaceError;
use crate::requests::Requests;

/// The most items that are announced at once.
const MOST_ITEMS: usize = 1_000;

/// How long the bridge may take to tell the cell's state. In a cell with several containers none answers under the cell's own name.
const STATE_LIMIT: Duration = Duration::from_secs(2);

/// How often it is looked whether the goal is cancelled.
const LOOK: Duration = Duration::from_millis(100);

/// After how long without news the planner is asked: messages of streams may be lost.
const ASKED_AFTER: Duration = Duration::from_secs(2);

/// Serves the action.
pub(super) fn serve(common: &Common, name: &Name, cell: &Cell) -> Result<ActionServer, FaceError> {
    let packing = Packing {
        process: common.process.clone(),
        requests: common.requests.clone(),
        cell: cell.clone(),
        is_busy: Arc::default(),
        shutdown: common.shutdown.clone(),
        working: Arc::downgrade(&common.working),
    };
    let on_goal = move |goal: &PackGoal| packing.accept(goal);
    Ok(ActionServer::new::<Pack>(&common.node, name, on_goal)?)
}

/// Packs in a cell, one goal at a time.
#[derive(Clone)]
struct Packing {
    process: Process,
    requests: Requests,
    cell: Cell,
    is_busy: Arc<AtomicBool>,
    shutdown: Shutdown,
    working: Weak<SyncSender<Infallible>>,
}

/// A goal is carried out until it is dropped.
struct Busy(Arc<AtomicBool>);

impl Drop for Busy {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

/// Why a packing did not come to an end of its own.
enum Failure {
    /// The stack did not do what it was asked.
    Call(CallError),
    /// Something else, for people.
    Other(String),
}

impl From<CallError> for Failure {
    fn from(error: CallError) -> Self {
        Self::Call(error)
    }
}

impl From<FaceError> for Failure {
    fn from(error: FaceError) -> Self {
        Self::Other(error.to_string())
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Call(error) => write!(formatter, "{error}"),
            Self::Other(reason) => formatter.write_str(reason),
        }
    }
}

impl Packing {
    /// The work that carries a goal out; `None` where there are no items, too many, another goal is under way, or the service ends.
    fn accept(&self, goal: &PackGoal) -> Option<Work<Pack>> {
        if !(1..=MOST_ITEMS).contains(&goal.items.len()) {
            return None;
        }
        let working = self.working.upgrade()?;
        if self.is_busy.swap(true, Ordering::AcqRel) {
            return None;
        }
        let (packing, busy) = (self.clone(), Busy(Arc::clone(&self.is_busy)));
        Some(Box::new(move |goal: Goal<Pack>| {
            let (status, result) = packing.carry_out(&goal);
            // Whoever hears of its end may send the next one.
            drop(busy);
            goal.end(status, result);
            drop(working);
        }))
    }

    fn carry_out(&self, goal: &Goal<Pack>) -> (Status, PackResult) {
        goal.execute();
        let session_id = match goal.message().session_id.as_str() {
            "" => format!("ros-{}", goal.id()),
            given => given.to_owned(),
        };
        tracing::info!(cell = %self.cell, session = session_id, "packing for ROS");
        match self.pack(goal, &session_id) {
            Ok(session) => ended(&session, goal.is_canceling()),
            Err(failure) => {
                let message = failure.to_string();
                tracing::warn!(cell = %self.cell, session = session_id, reason = message, "packing for ROS failed");
                let result = PackResult {
                    message,
                    ..PackResult::default()
                };
                (Status::Aborted, result)
            }
        }
    }

    /// Packs, and gives the session at its end, with the items of the goal.
    fn pack(&self, goal: &Goal<Pack>, session_id: &str) -> Result<v1::Session, Failure> {
        let latest = Latest::<v1::Session>::subscribe(
            &self.process,
            &self.cell,
            Stream::Session,
            MAX_MESSAGE_BYTES,
        );
        let latest = latest.map_err(FaceError::from)?;
        // Another controller may begin another session at any time: nothing of that is changed.
        let own = self.requests.of_session(session_id);
        self.begin(&own, &goal.message().items, session_id)?;
        let (mut items, mut told) = (Items::new(&goal.message().items), BTreeSet::new());
        loop {
            let mut session = self.news(goal, &latest)?;
            if session.session_id != session_id {
                // One that was on its way may be older.
                session = self.session()?;
            }
            if session.session_id != session_id {
                let other = session.session_id;
                return Err(Failure::Other(format!("session {other} was begun instead")));
            }
            let of_session = std::mem::take(&mut session.items);
            session.items = items.update(&of_session);
            if let Some(feedback) = feedback(&session, &mut told) {
                goal.feedback(feedback).map_err(FaceError::from)?;
            }
            if session.end() != SessionEnd::Unspecified {
                return Ok(session);
            }
            if goal.is_canceling() {
                self.withdraw(&own, &of_session)?;
            }
        }
    }

    /// Begins the session, announces the items and has the planner pack them.
    fn begin(
        &self,
        own: &Requests,
        items: &[Announcement],
        session_id: &str,
    ) -> Result<(), Failure> {
        let state = v1::CellStateRequest::default();
        let state = self.requests.ask_within(&self.cell, state, STATE_LIMIT);
        let state = match state {
            Ok(reply) => reply.state.unwrap_or_default(),
            // A cell with several containers has no state of its own: the planner looks at theirs.
            Err(CallError::NoAnswer { .. } | CallError::TimedOut) => v1::CellState::default(),
            Err(error) => return Err(error.into()),
        };
        let begin = v1::BeginRequest {
            session_id: session_id.to_owned(),
            least_state_number: state.state_number,
            ..v1::BeginRequest::default()
        };
        self.requests.ask(&self.cell, begin)?;
        let announce = v1::AnnounceRequest {
            items: items.iter().map(messages::read_announcement).collect(),
            ..v1::AnnounceRequest::default()
        };
        own.ask(&self.cell, announce)?;
        let automatic = v1::AutomaticRequest {
            is_automatic: true,
            ..v1::AutomaticRequest::default()
        };
        own.ask(&self.cell, automatic)?;
        Ok(())
    }

    /// The session as it is told next; as it is, where nothing is told for a while or the goal is cancelled.
    fn news(
        &self,
        goal: &Goal<Pack>,
        latest: &Latest<v1::Session>,
    ) -> Result<v1::Session, Failure> {
        let until = Instant::now() + ASKED_AFTER;
        loop {
            if self.shutdown.is_requested() {
                return Err(Failure::Other("the service ends".to_owned()));
            }
            let arrived = latest.wait(Instant::now() + LOOK);
            if let Some(Ok(session)) = arrived.map(|arrived| arrived.message) {
                return Ok(session);
            }
            if goal.is_canceling() || Instant::now() >= until {
                return self.session();
            }
        }
    }

    /// The session that is under way, whichever it is.
    fn session(&self) -> Result<v1::Session, Failure> {
        let request = v1::SessionRequest::default();
        match self.requests.ask(&self.cell, request) {
            Ok(reply) => Ok(reply.session.unwrap_or_default()),
            Err(error @ (CallError::NoAnswer { .. } | CallError::TimedOut)) => {
                Err(Failure::Other(format!(
                    "{error}; a planner that comes back goes on with the session by itself: hold the cell where it must not"
                )))
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Takes back what waits; what was decided meanwhile stays.
    fn withdraw(&self, own: &Requests, items: &[v1::SessionItem]) -> Result<(), Failure> {
        let waits = |item: &&v1::SessionItem| {
            matches!(item.state(), ItemState::Waiting | ItemState::SetAside)
        };
        for item in items.iter().filter(waits) {
            let request = v1::WithdrawRequest {
                item_id: item.item_id.clone(),
                ..v1::WithdrawRequest::default()
            };
            match own.ask(&self.cell, request) {
                Ok(_) | Err(CallError::Refused { .. }) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }
}

/// The items of a goal as its session told them last: it forgets those of containers that were closed long ago.
struct Items {
    /// The place of each in the order in which they were announced.
    places: BTreeMap<String, usize>,
    told: Vec<Option<v1::SessionItem>>,
}

impl Items {
    fn new(announced: &[Announcement]) -> Self {
        let mut places = BTreeMap::new();
        for item in announced {
            let next = places.len();
            places.entry(item.item_id.clone()).or_insert(next);
        }
        Self {
            told: vec![None; places.len()],
            places,
        }
    }

    /// Those that were told, in their order, now that the session has these.
    fn update(&mut self, of_session: &[v1::SessionItem]) -> Vec<v1::SessionItem> {
        for item in of_session {
            let place = self.places.get(&item.item_id);
            if let Some(told) = place.and_then(|place| self.told.get_mut(*place)) {
                *told = Some(item.clone());
            }
        }
        self.told.iter().flatten().cloned().collect()
    }
}

/// What was packed or lost since this was told last; `None` where nothing was.
fn feedback(session: &v1::Session, told: &mut BTreeSet<String>) -> Option<PackFeedback> {
    let is_done =
        |item: &&v1::SessionItem| matches!(item.state(), ItemState::Packed | ItemState::Gone);
    let done = session.items.iter().filter(is_done);
    let new = done.filter(|item| told.insert(item.item_id.clone()));
    let items: Vec<Item> = new.map(messages::item).collect();
    (!items.is_empty()).then(|| PackFeedback {
        packed: count(session, ItemState::Packed),
        waiting: count(session, ItemState::Waiting),
        items,
    })
}

/// How a goal ended whose session did.
fn ended(session: &v1::Session, is_canceling: bool) -> (Status, PackResult) {
    let end = session.end();
    let is_whole = session
        .items
        .iter()
        .all(|item| item.state() != ItemState::Withdrawn);
    let status = match end {
        SessionEnd::Failed => Status::Aborted,
        // All was packed before the goal was cancelled.
        _ if is_canceling && !is_whole => Status::Canceled,
        _ => Status::Succeeded,
    };
    let message = match end {
        SessionEnd::Failed => session.failure.clone(),
        _ => messages::reasons(&session.reasons),
    };
    let result = PackResult {
        end: match status {
            Status::Canceled => 0,
            _ => messages::number(session.end),
        },
        items: session.items.iter().map(messages::item).collect(),
        packed: count(session, ItemState::Packed),
        message,
    };
    (status, result)
}

fn count(session: &v1::Session, state: ItemState) -> u32 {
    let items = session.items.iter();
    let count = items.filter(|item| item.state() == state).count();
    u32::try_from(count).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn session(end: SessionEnd, states: &[ItemState]) -> v1::Session {
        let items = states.iter().zip('a'..).map(|(state, id)| v1::SessionItem {
            item_id: id.to_string(),
            state: (*state).into(),
            ..v1::SessionItem::default()
        });
        v1::Session {
            items: items.collect(),
            end: end.into(),
            failure: "the robot stands".to_owned(),
            ..v1::Session::default()
        }
    }

    #[test]
    fn each_item_is_told_of_once() {
        use ItemState::{Decided, Gone, Packed, Waiting};
        let mut told = BTreeSet::new();
        let under_way = |states: &[ItemState]| session(SessionEnd::Unspecified, states);
        assert_eq!(feedback(&under_way(&[Decided, Waiting]), &mut told), None);
        let first = feedback(&under_way(&[Packed, Decided, Waiting]), &mut told).unwrap();
        assert_eq!((first.packed, first.waiting), (1, 1));
        let ids = |feedback: &PackFeedback| -> Vec<String> {
            let items = feedback.items.iter();
            items.map(|item| item.item_id.clone()).collect()
        };
        assert_eq!(ids(&first), ["a"]);
        let second = feedback(&under_way(&[Packed, Gone, Packed]), &mut told).unwrap();
        assert_eq!(ids(&second), ["b", "c"]);
        assert_eq!(
            feedback(&under_way(&[Packed, Gone, Packed]), &mut told),
            None
        );
    }

    #[test]
    fn items_that_the_session_forgets_stay_in_the_result() {
        use ItemState::{Packed, Waiting};
        let announced = |id: &str| Announcement {
            item_id: id.to_owned(),
            ..Announcement::default()
        };
        let mut items = Items::new(&["a", "b", "a", "c"].map(announced));
        let two = session(SessionEnd::Unspecified, &[Packed, Waiting]).items;
        assert_eq!(items.update(&two), two);
        // The last is of somebody else.
        let all = session(SessionEnd::Unspecified, &[Packed; 4]).items;
        assert_eq!(items.update(&all[1..]), all[..3]);
    }

    #[test]
    fn a_goal_ends_as_its_session_did() {
        use ItemState::{Packed, SetAside, Withdrawn};
        let cases = [
            (SessionEnd::AllPacked, Packed, false, Status::Succeeded, 1),
            (SessionEnd::NothingFits, Packed, false, Status::Succeeded, 2),
            (
                SessionEnd::OthersSetAside,
                SetAside,
                false,
                Status::Succeeded,
                4,
            ),
            (SessionEnd::Failed, Packed, false, Status::Aborted, 3),
            (SessionEnd::Failed, Withdrawn, true, Status::Aborted, 3),
            (SessionEnd::AllPacked, Withdrawn, true, Status::Canceled, 0),
            // It was packed before the cancellation came.
            (SessionEnd::AllPacked, Packed, true, Status::Succeeded, 1),
        ];
        for (end, state, is_canceling, status, number) in cases {
            let (ended_as, result) = ended(&session(end, &[state]), is_canceling);
            assert_eq!(
                (ended_as, result.end),
                (status, number),
                "{end:?} {state:?}"
            );
            let is_failed = end == SessionEnd::Failed;
            assert_eq!(result.message == "the robot stands", is_failed);
        }
    }
}
