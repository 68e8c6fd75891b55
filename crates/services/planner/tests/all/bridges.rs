//! What a session knows is held against what the bridge knows.

use std::sync::{Arc, Mutex};

use ppnpack_wire::v1::{self, ItemState, SessionEnd, Status};

use crate::common::{self, Rig, announce, announcement, block, placed, states};

type Told = Arc<Mutex<v1::CellState>>;

/// A planner, and a bridge that is in a state.
fn rig(state_number: u64) -> (Rig, Told) {
    let mut rig = Rig::new(common::untried());
    let told = Told::default();
    told.lock().unwrap().state_number = state_number;
    let shown = Arc::clone(&told);
    rig.bridge_says(move || shown.lock().unwrap().clone());
    // It is there.
    rig.call(v1::CellStateRequest::default());
    (rig, told)
}

fn body(item_id: &str) -> v1::Body {
    v1::Body {
        item_id: item_id.to_owned(),
        ..v1::Body::default()
    }
}

/// Plans until the session has failed; gives why it has, and what was said of the plan then.
fn failed(rig: &Rig) -> [String; 2] {
    loop {
        let refused = rig.plan_unavailable(3_000);
        let session = rig.session();
        if session.end() == SessionEnd::Failed {
            return [session.failure, refused];
        }
    }
}

#[test]
fn a_heightmap_of_a_state_that_the_cell_has_not_come_to_is_not_planned_on() {
    let (rig, told) = rig(1);
    rig.seen.lock().unwrap().is_stuck = true;
    rig.begin_with(&["a"]);
    let text = rig.plan_unavailable(2_000);
    assert!(
        text.contains("state 2 of cell cell-1, which has come to 1"),
        "{text}"
    );
    told.lock().unwrap().state_number = 2;
    assert_eq!(rig.decision().state_number, 2);
}

#[test]
fn a_session_that_knows_of_a_later_state_than_the_bridge_fails_and_goes_on_from_that_of_the_bridge()
{
    let (mut rig, told) = rig(5);
    {
        let mut seen = rig.seen.lock().unwrap();
        (seen.state_number, seen.is_stuck) = (5, true);
    }
    rig.begin_as(v1::BeginRequest {
        least_state_number: 70,
        ..v1::BeginRequest::default()
    });
    rig.announce([announcement("a", block())]);
    for text in failed(&rig) {
        assert!(
            text.contains("in state 5, and the session knows of state 70"),
            "{text}"
        );
    }

    // Somebody has looked.
    let counted = Arc::clone(&told);
    rig.bridge_counts_to(move || {
        let mut state = counted.lock().unwrap();
        state.state_number = 6;
        state.clone()
    });
    rig.seen.lock().unwrap().state_number = 6;
    rig.switch(true);
    let session = rig.session_once(|session| session.pending.is_some());
    assert_eq!(session.pending.unwrap().state_number, 6);
    assert_eq!(session.failure, "");
}

#[test]
fn a_session_that_was_on_disk_waits_for_the_bridge_and_fails_where_what_waits_in_it_lies_there() {
    let mut rig = Rig::new(common::untried());
    rig.begin_with(&["a", "b"]);
    let decision = rig.decision();
    rig.call(placed(&decision, decision.state_number + 1));
    rig.seen.lock().unwrap().hidden = "cell-1";
    rig.switch(true);
    let before = rig.session();
    rig.restart(&[], |_| {});
    // By itself nothing is decided before the bridge is there. Another planner went on meanwhile.
    rig.seen.lock().unwrap().hidden = "none";
    rig.bridge_says(|| v1::CellState {
        state_number: 10,
        bodies: ["a", "b"].map(body).to_vec(),
        ..v1::CellState::default()
    });
    let session = rig.ended();
    assert_eq!(session.end(), SessionEnd::Failed);
    let waiting = if decision.item_id == "a" { "b" } else { "a" };
    let failure = &session.failure;
    let says = format!("item {waiting} lies there: another planner");
    assert!(failure.starts_with(&says), "{failure}");
    assert_eq!(session.items, before.items);

    // Who has looked goes on.
    rig.switch(false);
    rig.withdraw(waiting);
    rig.announce([announcement("c", block())]);
    assert_eq!(rig.decision().item_id, "c");
}

#[test]
fn what_lies_in_a_container_is_not_announced_as_a_new_item() {
    let (rig, told) = rig(10);
    told.lock().unwrap().bodies = vec![body("a")];
    rig.begin();
    let items = || ["b", "a"].map(|item_id| announcement(item_id, block()));
    let says = "item a lies in container cell-1";
    rig.assert_refused(announce(items()), Status::Conflict, says);
    assert!(rig.session().items.is_empty());
    rig.announce([announcement("b", block())]);

    // It was taken out.
    told.lock().unwrap().bodies.clear();
    rig.announce(items());
    // What the session knows may be announced again, wherever it lies.
    told.lock().unwrap().bodies = vec![body("a")];
    rig.announce(items());
    assert_eq!(states(&rig.session()), [ItemState::Waiting; 2]);
}
