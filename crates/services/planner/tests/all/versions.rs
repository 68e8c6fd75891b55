//! A planner with bridges of other versions: older ones leave fields out, newer ones say what is
//! not known here.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::{self, announcement, block, carried_out};
use ppnpack_planner::CellSettings;
use ppnpack_service::rpc::Incoming;
use ppnpack_wire::v1::{self, ItemState, OutcomeKind, SessionEnd};

const STATE: u64 = 70;

/// A planner in automatic mode, and a bridge that answers as a test says.
struct Rig {
    own: common::Rig,
    /// How often the bridge was asked to place something.
    placed: Arc<AtomicUsize>,
}

impl Rig {
    /// A bridge that knows all since this state, in a later one, and answers requests to place an
    /// item so.
    fn new(
        [first_state_number, state_number]: [u64; 2],
        answer: impl Fn(&v1::PlaceRequest) -> Option<v1::PlaceReply> + Send + Sync + 'static,
    ) -> Self {
        let mut own = common::Rig::new(CellSettings {
            place_limit_s: 1.0,
            ..common::untried()
        });
        let mut seen = own.seen.lock().unwrap();
        (seen.state_number, seen.is_stuck) = (STATE, true);
        drop(seen);
        own.bridge_says(move || v1::CellState {
            state_number,
            first_state_number,
            ..v1::CellState::default()
        });
        let placed = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&placed);
        own.bridge_answers(move |incoming: &Incoming<v1::PlaceRequest>| {
            counted.fetch_add(1, Ordering::Relaxed);
            answer(incoming.message())
        });
        own.begin_automatic();
        own.announce([announcement("a", block())]);
        Self { own, placed }
    }

    fn failed(&self) -> v1::Session {
        let session = self.own.ended();
        assert_eq!(session.end(), SessionEnd::Failed);
        session
    }
}

/// An outcome without what an older bridge leaves out.
fn ended(request: &v1::PlaceRequest, kind: i32) -> Option<v1::PlaceReply> {
    let outcome = v1::Outcome {
        kind,
        container_from_item: None,
        state_number: STATE + 1,
        ..carried_out(request)
    };
    Some(v1::PlaceReply {
        execution: Some(v1::Execution {
            phase: v1::ExecutionPhase::Ended.into(),
            outcome: Some(outcome),
            ..v1::Execution::default()
        }),
        ..v1::PlaceReply::default()
    })
}

#[test]
fn an_older_bridge_that_does_not_say_since_when_it_knows_all_may_have_placed_what_it_calls_stale() {
    // It calls stale too what it has forgotten with its journal.
    let rig = Rig::new([0, 9_000], |_| None);
    let session = rig.failed();
    assert_eq!(session.settled[0].kind(), OutcomeKind::Unknown);
    assert_eq!(session.items[0].state(), ItemState::Gone);
    let failure = &session.failure;
    assert!(failure.contains("may lie anywhere"), "{failure}");
    assert_eq!(rig.placed.load(Ordering::Relaxed), 1);
}

#[test]
fn what_a_bridge_calls_stale_that_knows_all_since_was_not_placed() {
    let rig = Rig::new([STATE, STATE], |_| None);
    let session = rig.own.session_once(|session| !session.settled.is_empty());
    assert_eq!(session.settled[0].kind(), OutcomeKind::NotPlaced);
}

#[test]
fn an_outcome_of_a_kind_that_is_not_known_here_ends_the_automatic_mode() {
    let rig = Rig::new([0, 0], |request| ended(request, 99));
    let session = rig.failed();
    let failure = &session.failure;
    assert!(failure.contains("was not carried out"), "{failure}");
    assert_eq!(session.items[0].state(), ItemState::Decided);
}

#[test]
fn what_an_older_bridge_leaves_out_of_an_outcome_is_not_needed() {
    let kind = OutcomeKind::Placed.into();
    let rig = Rig::new([0, 0], move |request| ended(request, kind));
    let session = rig.own.ended();
    assert_eq!(session.end(), SessionEnd::AllPacked);
    let item = &session.items[0];
    assert_eq!(item.container_from_item, item.planned);
}
