//! A second planner, bridge or perception of one cell, started by mistake.

use std::time::Instant;

use crate::cell::CellClient;
use crate::process::Signal;
use crate::stack::{Options, Stack};
use crate::tests::common::{self, OBJECTS, assert_consistent, count, started};
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
    let (client, instance) = (Client::new(stack.session()), Instance::new(name).unwrap());
    let says = format!("another {service}, instance {other}, serves {cells}");
    common::until(|| {
        let until = Instant::now() + common::PATIENCE;
        let health = client.health(service, &instance, until).unwrap();
        let mut checks = health.checks.iter();
        let waits = checks.any(|check| check.message.contains(&says));
        assert!(!(waits && health.is_ready));
        let seen = || format!("{:?}", health.checks);
        waits.then_some(()).ok_or_else(seen)
    });
}

/// Asserts that the cell is held, as another bridge served it.
fn assert_held_after_another(cell: &CellClient) {
    let reason = cell.state().unwrap().hold.unwrap().reason;
    assert!(reason.contains("another bridge"), "{reason}");
}

#[test]
fn a_second_bridge_waits_and_holds_the_cell_when_it_takes_over() {
    let options = Options::default();
    let (mut stack, cell) = started(&options);
    cell.begin("first", &OBJECTS[..6], false).unwrap();
    cell.step().unwrap().unwrap();
    let decision = cell.plan().unwrap().unwrap();

    let second = stack.add_second(Service::Bridge, &options).unwrap();
    wait_until_it_waits(&stack, Service::Bridge, &second, "bridge-1");
    cell.carry_out(&decision).unwrap();
    assert_consistent(&cell, "with a second bridge that waits");
    let decision = cell.plan().unwrap().unwrap();

    stack.signal("bridge-1", Signal::SIGKILL).unwrap();
    stack.wait_ready(&second).unwrap();
    assert_held_after_another(&cell);
    // It cannot know whether that was carried out.
    common::refused(&cell, v1::PlaceRequest::from(&decision), Status::Forgotten);

    // The first one waits now.
    stack.restart("bridge-1").unwrap();
    wait_until_it_waits(&stack, Service::Bridge, "bridge-1", &second);
}

#[test]
fn a_second_planner_waits_and_goes_on_with_nothing_by_itself_when_it_takes_over() {
    let options = Options::default();
    let (mut stack, cell) = started(&options);
    cell.begin("first", &OBJECTS[..6], false).unwrap();
    let second = stack.add_second(Service::Planner, &options).unwrap();
    wait_until_it_waits(&stack, Service::Planner, &second, "planner-1");
    cell.step().unwrap().unwrap();
    assert_eq!(cell.session().unwrap().session_id, "first");

    // Each has been the only one for a while, and the one knows nothing of the other's packing.
    stack.signal("planner-1", Signal::SIGKILL).unwrap();
    stack.wait_ready(&second).unwrap();
    assert_eq!(cell.session().unwrap().session_id, "");
    // What the first one packed has the ids of the items of the second.
    cell.renew().unwrap();
    cell.begin("second", &OBJECTS[6..8], true).unwrap();
    let packed = common::wait_for_end(&cell);
    assert!(count(&packed, ItemState::Packed) > 0);
    stack.restart("planner-1").unwrap();
    wait_until_it_waits(&stack, Service::Planner, "planner-1", &second);
    stack.signal(&second, Signal::SIGTERM).unwrap();
    stack.wait_ready("planner-1").unwrap();
    let session = cell.session().unwrap();
    assert_eq!(session.session_id, "first");
    assert_eq!(session.end(), v1::SessionEnd::Failed);
    let failure = session.failure;
    assert!(failure.contains("another planner"), "{failure}");
}

#[test]
fn a_second_bridge_of_the_same_name_waits_and_holds_the_cell_when_it_takes_over() {
    let (mut stack, cell) = started(&Options::default());
    cell.begin("first", &OBJECTS[..4], false).unwrap();
    cell.step().unwrap().unwrap();

    // As where no instance is set: bridge-1 is the name of both.
    let namesake = common::with(&[(Service::Bridge, "instance=bridge-1")]);
    let second = stack.add_second(Service::Bridge, &namesake).unwrap();
    let says = "another bridge, instance bridge-1, serves cell cell-1";
    let waits = |stack: &Stack| {
        common::until(|| {
            // By its name, either may answer for its health.
            let admin = stack.admin(&second).map_err(|error| error.to_string())?;
            let answer = ask_ready(admin).unwrap_err();
            answer.contains(says).then_some(()).ok_or(answer)
        });
    };
    waits(&stack);
    cell.step().unwrap().unwrap();
    assert_consistent(&cell, "with a namesake that waits");

    // Whoever waits does not take over where the router is away for a moment.
    stack.kill("router").unwrap();
    stack.wait_ready("planner-1").unwrap();
    cell.step().unwrap().unwrap();
    assert!(cell.state().unwrap().hold.is_none());
    waits(&stack);

    stack.signal("bridge-1", Signal::SIGKILL).unwrap();
    stack.wait_ready("bridge-1").unwrap();
    assert_held_after_another(&cell);
}

#[test]
fn a_second_perception_waits_and_serves_when_the_first_has_ended() {
    let options = Options::default();
    let (mut stack, cell) = started(&options);
    cell.begin("first", &OBJECTS[..4], false).unwrap();
    let second = stack.add_second(Service::Perception, &options).unwrap();
    let first = "perception-1";
    wait_until_another_serves(&stack, Service::Perception, &second, first, "all cells");
    cell.step().unwrap().unwrap();
    stack.signal(first, Signal::SIGKILL).unwrap();
    stack.wait_ready(&second).unwrap();
    cell.step().unwrap().unwrap();
    assert_consistent(&cell, "with the second perception");
}
