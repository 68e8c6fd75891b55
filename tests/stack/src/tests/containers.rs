//! A cell with two containers, of which each is a process's business alone: what is decided for the one goes into the one, once,
//! whatever is killed meanwhile.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use crate::cell::CellClient;
use crate::process::Signal;
use crate::records::{self, Files};
use crate::stack::Stack;
use crate::tests::common::{
    self, OBJECTS, RECOVERY, assert_consistent, assert_recovered, wait_for,
};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, ItemState, SessionEnd, Status};

const CONTAINERS: [&str; 2] = ["left", "right"];

/// A stack of one cell whose robot serves two containers, and of which each is closed as soon as it is a little full.
fn stack() -> Stack {
    let cell = "{place_duration_s=0.1}";
    let options = common::with(&[
        (
            Service::Planner,
            "service.cells.cell-1.containers={left={},right={}}",
        ),
        (
            Service::Planner,
            "service.cells.cell-1.closing={renews=true,fill_percent=5.0}",
        ),
        (
            Service::Bridge,
            &format!("service.cells={{left={cell},right={cell}}}"),
        ),
        (
            Service::Bridge,
            "service.robots={cell-1=[\"left\",\"right\"]}",
        ),
    ]);
    Stack::start(&options).unwrap()
}

fn begin(cell: &CellClient, objects: &[&str], is_automatic: bool) {
    cell.ask(v1::BeginRequest {
        session_id: "s".to_owned(),
        is_automatic,
        ..v1::BeginRequest::default()
    })
    .unwrap();
    cell.announce(objects).unwrap();
}

fn containers(cell: &CellClient) -> [CellClient; 2] {
    CONTAINERS.map(|name| cell.container(name).unwrap())
}

/// Which items lie in which of the containers that stood somewhere one after another.
type Lying = BTreeMap<(String, u64), BTreeSet<String>>;

fn by_session(session: &v1::Session) -> Lying {
    let mut lying = Lying::new();
    let packed = session.items.iter();
    for item in packed.filter(|item| item.state() == ItemState::Packed) {
        let container = (item.container.clone(), item.container_sequence);
        lying
            .entry(container)
            .or_default()
            .insert(item.item_id.clone());
    }
    lying
}

fn by_journal(files: &Files) -> Lying {
    let mut lying = Lying::new();
    for name in CONTAINERS {
        let told = records::journal(files, name).unwrap();
        assert!(!told.is_unfinished && !told.has_forgotten);
        for (sequence, contents) in (0..).zip(told.containers) {
            let items: BTreeSet<String> = contents.placed.into_iter().collect();
            if !items.is_empty() {
                lying.insert((name.to_owned(), sequence), items);
            }
        }
    }
    lying
}

#[test]
fn two_containers_are_packed_and_renewed_while_processes_are_killed() {
    let mut stack = stack();
    let cell = stack.cell(0).unwrap();
    begin(&cell, &OBJECTS, true);
    let packed = |session: &v1::Session| common::count(session, ItemState::Packed);
    for name in [
        "bridge-1",
        "planner-1",
        "perception-1",
        "router",
        "bridge-1",
        "planner-1",
    ] {
        let before = packed(&cell.session().unwrap());
        wait_for(&cell, |session| {
            packed(session) >= before + 4 || session.end != 0
        });
        stack.signal(name, Signal::Kill).unwrap();
        stack.restart(name).unwrap();
        let ended = Instant::now();
        let when = format!("{name} killed");
        cell.ask_within(v1::SessionRequest::default(), RECOVERY)
            .unwrap();
        for container in containers(&cell) {
            // The session is the cell's.
            let until = ended + RECOVERY;
            assert_serves_container(&container, until, &when);
        }
        assert_recovered(ended, &when);
        assert_consistent(&cell, &when);
    }
    let session = wait_for(&cell, |session| session.end != 0);
    assert_eq!(session.end(), SessionEnd::AllPacked, "{}", session.failure);
    assert_eq!(packed(&session), OBJECTS.len());
    assert!(session.closed.len() >= 2, "{:?}", session.closed);
    assert_consistent(&cell, "at the end");
    for name in ["planner-1", "bridge-1"] {
        stack.signal(name, Signal::Terminate).unwrap();
    }
    let files = Files::in_folder(stack.folder.path());
    assert_eq!(by_journal(&files), by_session(&session));
}

fn assert_serves_container(container: &CellClient, until: Instant, when: &str) {
    let left = until.saturating_duration_since(Instant::now());
    let served = container.ask_within(v1::CellStateRequest::default(), left);
    served.unwrap_or_else(|error| panic!("{when}: bridge: {error}"));
    let left = until.saturating_duration_since(Instant::now());
    let served = container.ask_within(v1::HeightmapRequest::default(), left);
    served.unwrap_or_else(|error| panic!("{when}: perception: {error}"));
}

#[test]
fn a_robot_is_held_at_all_its_containers_and_places_into_one_at_a_time() {
    let mut stack = stack();
    let cell = stack.cell(0).unwrap();
    begin(&cell, &OBJECTS[..4], false);
    let [left, right] = containers(&cell);
    let decision = cell.plan().unwrap().unwrap();
    let (own, other) = match decision.container.as_str() {
        "left" => (left, right),
        _ => (right, left),
    };
    let state_number = other.state().unwrap().state_number;
    own.ask(v1::PlaceRequest::from(&decision)).unwrap();
    // It is on its way into the one; into the other nothing can be placed meanwhile.
    let elsewhere = v1::PlaceRequest {
        placement_id: "elsewhere".to_owned(),
        state_number,
        ..v1::PlaceRequest::from(&decision)
    };
    let refused = other.ask(elsewhere.clone()).unwrap_err();
    assert_eq!(refused.status(), Some(Status::Busy), "{refused}");
    let outcome = cell.place(&decision).unwrap();
    cell.report(&decision, outcome).unwrap();
    assert_consistent(&cell, "after a placement");

    let hold = v1::HoldRequest {
        reason: "a hand".to_owned(),
        ..v1::HoldRequest::default()
    };
    own.ask(hold).unwrap();
    let refused = other.ask(elsewhere.clone()).unwrap_err();
    assert_eq!(refused.status(), Some(Status::Held), "{refused}");
    // Also where the bridge was killed before each had it written down: nothing begins before it is known of all.
    stack.signal("bridge-1", Signal::Kill).unwrap();
    stack.restart("bridge-1").unwrap();
    let refused = other.ask(elsewhere).unwrap_err();
    assert_eq!(refused.status(), Some(Status::Held), "{refused}");
    let renewal = v1::RenewRequest {
        state_number: other.state().unwrap().state_number,
        ..v1::RenewRequest::default()
    };
    let refused = other.ask(renewal).unwrap_err();
    assert_eq!(refused.status(), Some(Status::Held), "{refused}");
    until_hold_is(&other, true);
    other.resume().unwrap();
    until_hold_is(&own, false);
    cell.acknowledge().unwrap();
    let session = wait_for(&cell, |session| session.end != 0);
    assert_eq!(session.end(), SessionEnd::AllPacked, "{}", session.failure);
    assert_consistent(&cell, "at the end");
}

/// Waits until the state of a container says whether it is held.
fn until_hold_is(container: &CellClient, is_held: bool) {
    let until = Instant::now() + RECOVERY;
    while container.state().unwrap().hold.is_some() != is_held {
        assert!(Instant::now() < until, "held: not {is_held}");
    }
}
