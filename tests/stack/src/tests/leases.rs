//! A second planner, bridge or perception of one cell, started by mistake.

use std::time::{Duration, Instant};

use crate::process::Signal;
use crate::stack::{Options, Stack};
use crate::tests::common::{self, OBJECTS, assert_consistent, count};
use ppnpack_service::ask_ready;
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::{Instance, Service};
use ppnpack_wire::v1::{self, ItemState, Status};

/// Waits until an instance says that this other one serves the cell.
fn wait_until_it_waits(stack: &Stack, service: Service, name: &str, other: &str) {
    wait_until_another_serves(stack, service, name, other, "cell cell-1");
}

fn wait_until_another_serves(
    stack: &Stack,
    service: Service,
    name: &str,
    other: &str,
    cells: &str,
) {
    let until = Instant::now() + Duration::from_secs(20);
    let (client, instance) = (Client::new(stack.session()), Instance::new(name).unwrap());
    let says = format!("another {service}, instance {other}, serves {cells}");
    loop {
        let health = client.health(service, &instance, until).unwrap();
        let mut checks = health.checks.iter();
        if checks.any(|check| check.message.contains(&says)) {
            assert!(!health.is_ready);
            return;
        }
        assert!(Instant::now() < until, "{name}: {:?}", health.checks);
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_second_bridge_waits_and_holds_the_cell_when_it_takes_over() {
    let options = Options::default();
    let mut stack = Stack::start(&options).unwrap();
    let cell = stack.cell(0).unwrap();
    cell.begin("first", &OBJECTS[..6], false).unwrap();
    cell.step().unwrap().unwrap();
    let decision = cell.plan().unwrap().unwrap();

    let second = stack.add_second(Service::Bridge, &options).unwrap();
    wait_until_it_waits(&stack, Service::Bridge, &second, "bridge-1");
    let outcome = cell.place(&decision).unwrap();
    cell.report(&decision, outcome).unwrap();
    assert_consistent(&cell, "with a second bridge that waits");
    let decision = cell.plan().unwrap().unwrap();

    stack.signal("bridge-1", Signal::Kill).unwrap();
    stack.wait_ready(&second).unwrap();
    let hold = cell.state().unwrap().hold.unwrap();
    assert!(hold.reason.contains("another bridge"), "{}", hold.reason);
    // It cannot know whether that was carried out.
    let refused = cell.ask(v1::PlaceRequest::from(&decision)).unwrap_err();
    assert_eq!(refused.status(), Some(Status::Forgotten), "{refused}");

    // The first one waits now.
    stack.restart("bridge-1").unwrap();
    wait_until_it_waits(&stack, Service::Bridge, "bridge-1", &second);
}

#[test]
fn a_second_planner_waits_and_goes_on_with_nothing_by_itself_when_it_takes_over() {
    let options = Options::default();
    let mut stack = Stack::start(&options).unwrap();
    let cell = stack.cell(0).unwrap();
    cell.begin("first", &OBJECTS[..6], false).unwrap();
    let second = stack.add_second(Service::Planner, &options).unwrap();
    wait_until_it_waits(&stack, Service::Planner, &second, "planner-1");
    cell.step().unwrap().unwrap();
    assert_eq!(cell.session().unwrap().session_id, "first");

    // Each has been the only one for a while, and the one knows nothing of the other's packing.
    stack.signal("planner-1", Signal::Kill).unwrap();
    stack.wait_ready(&second).unwrap();
    assert_eq!(cell.session().unwrap().session_id, "");
    // What the first one packed has the ids of the items of the second.
    cell.renew().unwrap();
    cell.begin("second", &OBJECTS[6..8], true).unwrap();
    let packed = common::wait_for(&cell, |session| {
        session.end() != v1::SessionEnd::Unspecified
    });
    assert!(count(&packed, ItemState::Packed) > 0);
    stack.restart("planner-1").unwrap();
    wait_until_it_waits(&stack, Service::Planner, "planner-1", &second);
    stack.signal(&second, Signal::Terminate).unwrap();
    stack.wait_ready("planner-1").unwrap();
    let session = cell.session().unwrap();
    assert_eq!(session.session_id, "first");
    assert_eq!(session.end(), v1::SessionEnd::Failed);
    assert!(
        session.failure.contains("another planner"),
        "{}",
        session.failure
    );
}

#[test]
fn a_second_bridge_of_the_same_name_waits_and_holds_the_cell_when_it_takes_over() {
    let mut stack = Stack::start(&Options::default()).unwrap();
    let cell = stack.cell(0).unwrap();
    cell.begin("first", &OBJECTS[..4], false).unwrap();
    cell.step().unwrap().unwrap();

    // As where no instance is set: bridge-1 is the name of both.
    let namesake = common::with(&[(Service::Bridge, "instance=bridge-1")]);
    let second = stack.add_second(Service::Bridge, &namesake).unwrap();
    let says = "another bridge, instance bridge-1, serves cell cell-1";
    let waits = |stack: &Stack| {
        let until = Instant::now() + Duration::from_secs(20);
        loop {
            // By its name, either may answer for its health.
            let admin = stack.admin(&second);
            let answer = admin.map(|admin| ask_ready(admin).unwrap_err());
            match answer {
                Ok(answer) if answer.contains(says) => return,
                answer => assert!(Instant::now() < until, "{answer:?}"),
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    waits(&stack);
    cell.step().unwrap().unwrap();
    assert_consistent(&cell, "with a namesake that waits");

    // Whoever waits does not take over where the router is away for a moment.
    stack.signal("router", Signal::Kill).unwrap();
    stack.restart("router").unwrap();
    stack.wait_ready("planner-1").unwrap();
    cell.step().unwrap().unwrap();
    assert!(cell.state().unwrap().hold.is_none());
    waits(&stack);

    stack.signal("bridge-1", Signal::Kill).unwrap();
    stack.wait_ready("bridge-1").unwrap();
    let hold = cell.state().unwrap().hold.unwrap();
    assert!(hold.reason.contains("another bridge"), "{}", hold.reason);
}

#[test]
fn a_second_perception_waits_and_serves_when_the_first_has_ended() {
    let options = Options::default();
    let mut stack = Stack::start(&options).unwrap();
    let cell = stack.cell(0).unwrap();
    cell.begin("first", &OBJECTS[..4], false).unwrap();
    let second = stack.add_second(Service::Perception, &options).unwrap();
    wait_until_another_serves(
        &stack,
        Service::Perception,
        &second,
        "perception-1",
        "all cells",
    );
    cell.step().unwrap().unwrap();
    stack.signal("perception-1", Signal::Kill).unwrap();
    stack.wait_ready(&second).unwrap();
    cell.step().unwrap().unwrap();
    assert_consistent(&cell, "with the second perception");
}
