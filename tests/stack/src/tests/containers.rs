//! A cell with two containers: a decision for one goes into that one, once, whatever is killed
//! meanwhile.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use crate::cell::CellClient;
use crate::process::Signal;
use crate::records::{self, Files};
use crate::stack::Stack;
use crate::tests::common::{
    self, OBJECTS, RECOVERY, assert_consistent, assert_recovered, refused, wait_for,
    wait_until_packed,
};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, ItemState, Status};

const CONTAINERS: [&str; 2] = ["left", "right"];

/// A stack of one cell whose robot serves two containers; each is closed when it is a little full.
fn start() -> (Stack, CellClient) {
    let containers = "service.cells.cell-1.containers={left={},right={}}";
    let closing = "service.cells.cell-1.closing={renews=true,fill_percent=5.0}";
    let cell = "{place_duration_s=0.1}";
    let cells = format!("service.cells={{left={cell},right={cell}}}");
    let robots = "service.robots={cell-1=[\"left\",\"right\"]}";
    let options = common::with(&[
        (Service::Planner, containers),
        (Service::Planner, closing),
        (Service::Bridge, &cells),
        (Service::Bridge, robots),
    ]);
    common::started(&options)
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

/// The items in each container, by its place and its number among those that stood there.
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
    let (mut stack, cell) = start();
    begin(&cell, &OBJECTS, true);
    let packed = |session: &v1::Session| common::count(session, ItemState::Packed);
    let killed = ["bridge-1", "planner-1", "perception-1", "router"];
    for name in killed.into_iter().chain(["bridge-1", "planner-1"]) {
        let before = common::count_packed(&cell);
        wait_for(&cell, |session| {
            packed(session) >= before + 4 || session.end != 0
        });
        stack.kill(name).unwrap();
        let ended = Instant::now();
        let when = format!("{name} killed");
        cell.ask_within(v1::SessionRequest::default(), RECOVERY)
            .unwrap();
        for container in containers(&cell) {
            // The session is the cell's.
            let until = ended + RECOVERY;
            common::assert_serves_container(&container, until, &when);
        }
        assert_recovered(ended, &when);
        assert_consistent(&cell, &when);
    }
    let session = wait_until_packed(&cell);
    assert_eq!(packed(&session), OBJECTS.len());
    assert!(session.closed.len() >= 2, "{:?}", session.closed);
    assert_consistent(&cell, "at the end");
    for name in ["planner-1", "bridge-1"] {
        stack.signal(name, Signal::SIGTERM).unwrap();
    }
    let files = Files::in_folder(stack.folder.path());
    assert_eq!(by_journal(&files), by_session(&session));
}

#[test]
fn a_robot_is_held_at_all_its_containers_and_places_into_one_at_a_time() {
    let (mut stack, cell) = start();
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
    refused(&other, elsewhere.clone(), Status::Busy);
    cell.carry_out(&decision).unwrap();
    assert_consistent(&cell, "after a placement");

    own.hold("a hand").unwrap();
    refused(&other, elsewhere.clone(), Status::Held);
    // Also where the bridge was killed before each had it written down: nothing begins before it is
    // known of all.
    stack.kill("bridge-1").unwrap();
    refused(&other, elsewhere, Status::Held);
    let renewal = v1::RenewRequest {
        state_number: other.state().unwrap().state_number,
        ..v1::RenewRequest::default()
    };
    refused(&other, renewal, Status::Held);
    until_hold_is(&other, true);
    other.resume().unwrap();
    until_hold_is(&own, false);
    cell.acknowledge().unwrap();
    wait_until_packed(&cell);
    assert_consistent(&cell, "at the end");
}

/// Waits until the state of a container says whether it is held.
fn until_hold_is(container: &CellClient, is_held: bool) {
    common::within(RECOVERY, || {
        let hold = container.state().unwrap().hold;
        match hold.is_some() == is_held {
            true => Ok(()),
            false => Err(format!("{hold:?}")),
        }
    });
}
