//! Placements, renewals and their streams, over a real session.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::common::{self, PATIENCE, Rig, deadline, place, renew};
use nalgebra::Isometry3;
use ppnpack_bridge::robot::{CutOff, Ending, Placement, Robot};
use ppnpack_bridge::simulated::{SimulatedRobot, SimulatedSettings};
use ppnpack_service::metrics;
use ppnpack_service::rpc::CallError;
use ppnpack_service::stream::Latest;
use ppnpack_service::{Running, Shutdown};
use ppnpack_wire::convert;
use ppnpack_wire::keys::Stream;
use ppnpack_wire::v1::{self, ExecutionPhase, OutcomeKind, Status};

#[test]
fn a_placement_is_carried_out_its_outcome_told_and_counted() {
    metrics::install().unwrap();
    let rig = Rig::simulated(SimulatedSettings::default());
    let controller = &rig.controller;
    let count = |kind: &str, count: u64| {
        let line = format!(
            "ppnpack_outcomes_total{{cell=\"cell-1\",kind=\"OUTCOME_KIND_{kind}\"}} {count}\n"
        );
        let text = metrics::render();
        assert!(text.contains(&line), "{line} is not in:\n{text}");
    };
    count("PLACED", 0);
    let before = controller.state();
    assert!(rig.process.health().is_ready());
    assert!(before.is_simulated && before.bodies.is_empty());
    let execution = controller.place(place("p1", before.state_number, 0.16));
    assert_eq!(execution.phase(), ExecutionPhase::Accepted);
    let outcome = controller.outcome("p1");
    assert_eq!(outcome.kind(), OutcomeKind::Placed);
    assert!(outcome.is_inside && outcome.failure.is_empty());
    assert!(outcome.slide_m < 0.01 && outcome.tilt_rad < 0.1);
    assert_eq!(outcome.state_number, before.state_number + 1);
    let after = controller.state();
    assert_eq!(after.state_number, outcome.state_number);
    assert_eq!(after.executing_placement_id, "");
    assert_eq!(after.bodies.len(), 1);
    let body = &after.bodies[0];
    assert_eq!([&*body.item_id, &*body.object], ["item-p1", "brick"]);
    assert_eq!(body.container_from_item, outcome.container_from_item);
    // A simulated cell knows where its items lie.
    assert!(body.is_found && outcome.is_found);
    count("PLACED", 1);
    count("LOST", 0);
}

#[test]
fn a_placement_asked_for_many_times_is_carried_out_once() {
    let (rig, script) = Rig::scripted(true, None);
    let controller = &rig.controller;
    let request = place("p1", controller.state_number(), 0.16);
    std::thread::scope(|scope| {
        let asked = || controller.place(request.clone()).phase();
        let asking: Vec<_> = (0..8).map(|_| scope.spawn(asked)).collect();
        for asking in asking {
            assert_eq!(asking.join().unwrap(), ExecutionPhase::Accepted);
        }
    });
    script.go.send(()).unwrap();
    let outcome = controller.outcome("p1");
    // Late, when the state of the cell is another one.
    let again = controller.place(request);
    assert_eq!(again.phase(), ExecutionPhase::Ended);
    assert_eq!(again.outcome, Some(outcome));
    assert_eq!(script.done(), ["p1"]);
}

#[test]
fn an_id_stands_for_one_placement() {
    let rig = Rig::simulated(SimulatedSettings::default());
    let controller = &rig.controller;
    let request = place("p1", controller.state_number(), 0.16);
    controller.place(request.clone());
    controller.outcome("p1");
    let changes: [fn(&mut v1::PlaceRequest); 4] = [
        |request| request.item_id = "other".to_owned(),
        |request| request.object = "cube".to_owned(),
        |request| request.state_number += 1,
        |request| request.container_from_item = place("", 0, 0.1).container_from_item,
    ];
    for change in changes {
        let mut other = request.clone();
        change(&mut other);
        controller.refuses(other, Status::Conflict);
    }
    assert_eq!(controller.state().bodies.len(), 1);
}

#[test]
fn what_was_planned_on_another_state_is_stale() {
    let rig = Rig::simulated(SimulatedSettings::default());
    let controller = &rig.controller;
    let state = controller.state_number();
    // No state that the bridge ever told.
    for (other, status) in [
        (state - 1, Status::Forgotten),
        (state + 1, Status::Forgotten),
        (0, Status::Stale),
    ] {
        controller.refuses(place("p1", other, 0.16), status);
    }
    controller.carry_out("p1", state, 0.1);
    controller.refuses(place("p2", state, 0.2), Status::Stale);
    controller.place(place("p2", state + 1, 0.2));
    assert_eq!(controller.outcome("p2").state_number, state + 2);
}

#[test]
fn while_one_is_carried_out_others_are_refused() {
    let (rig, script) = Rig::scripted(true, None);
    let controller = &rig.controller;
    let state = controller.state_number();
    controller.place(place("p1", state, 0.16));
    assert_eq!(controller.state().executing_placement_id, "p1");
    controller.refuses(place("p2", state, 0.16), Status::Busy);
    controller.refuses(renew("r1", 1), Status::Busy);
    let patience = Duration::from_millis(300);
    match controller.call_for(common::outcome("p1"), patience) {
        Err(CallError::Refused { status, reply, .. }) => {
            assert_eq!(status, Status::TimedOut);
            let reply: v1::OutcomeReply = reply.decode().unwrap();
            assert_eq!(reply.execution.unwrap().phase(), ExecutionPhase::Accepted);
        }
        other => panic!("{other:?}"),
    }
    script.carry_out(controller, "p1");
    assert_eq!(script.done(), ["p1"]);
}

#[test]
fn what_is_wrong_is_refused_and_nothing_done() {
    let rig = Rig::simulated(SimulatedSettings::default());
    let controller = &rig.controller;
    let state = controller.state_number();
    type Change = fn(&mut v1::PlaceRequest);
    let wrong: [(Change, Status); 5] = [
        (|it| it.placement_id.clear(), Status::Invalid),
        (|it| it.item_id = "a b".to_owned(), Status::Invalid),
        (|it| it.object.clear(), Status::Invalid),
        (|it| it.container_from_item = None, Status::Invalid),
        (|it| it.object = "anvil".to_owned(), Status::NotFound),
    ];
    for (change, status) in wrong {
        let mut request = place("p1", state, 0.16);
        change(&mut request);
        controller.refuses(request, status);
    }
    controller.refuses(common::outcome("p1"), Status::NotFound);
    controller.refuses(common::outcome(""), Status::Invalid);
    // Possible on the wire, but not in this cell.
    for x_m in [100.0, 0.6, -0.3] {
        controller.refuses(place("beside", state, x_m), Status::Invalid);
    }
    assert_eq!(controller.state_number(), state);
}

#[test]
fn faults_that_are_asked_for_happen() {
    let mut settings = SimulatedSettings::default();
    settings.faults.missed_picks = 1.0;
    let rig = Rig::simulated(settings.clone());
    let state = rig.controller.state_number();
    let outcome = rig.controller.carry_out("p1", state, 0.16);
    assert_eq!(outcome.kind(), OutcomeKind::NotPlaced);
    assert_eq!(outcome.state_number, state);
    assert_eq!(outcome.container_from_item, None);
    assert!(!outcome.failure.is_empty());

    (settings.faults.missed_picks, settings.faults.drops) = (0.0, 1.0);
    let rig = Rig::simulated(settings);
    let state = rig.controller.state_number();
    let outcome = rig.controller.carry_out("p1", state, 0.16);
    assert_eq!(outcome.kind(), OutcomeKind::Lost);
    assert_eq!(outcome.state_number, state + 1);
    assert!(rig.controller.state().bodies.is_empty());
}

#[test]
fn a_container_is_renewed_once_per_request() {
    let rig = Rig::simulated(SimulatedSettings::default());
    let controller = &rig.controller;
    let state = controller.state_number();
    controller.carry_out("p1", state, 0.16);
    let renewed = controller.renew("r1");
    assert_eq!(renewed, state + 2);
    assert!(controller.state().bodies.is_empty());
    controller.carry_out("p2", renewed, 0.16);
    let again = controller.renew("r1");
    assert_eq!(again, renewed, "the same request again");
    assert_eq!(controller.state().bodies.len(), 1);
    assert_eq!(controller.renew("r2"), renewed + 2);
}

#[test]
fn a_renewal_that_comes_late_takes_nothing_away_that_came_after() {
    let rig = Rig::simulated(SimulatedSettings::default());
    let controller = &rig.controller;
    let state = controller.state_number();
    controller.carry_out("p1", state, 0.16);
    controller.refuses(renew("r1", 0), Status::Invalid);
    controller.refuses(renew("r1", state), Status::Stale);
    assert_eq!(controller.state().bodies.len(), 1);
    let renewed = controller.call(renew("r1", state + 1)).unwrap();
    assert_eq!(renewed.state_number, state + 2);
    // What was done is known, whatever state is named.
    let again = controller.call(renew("r1", state)).unwrap();
    assert_eq!(again.state_number, renewed.state_number);
}

#[test]
fn changes_are_published() {
    let rig = Rig::simulated(SimulatedSettings::default());
    let outcomes: Latest<v1::Outcome> = rig.subscribe(Stream::Outcome);
    let clouds: Latest<v1::PointCloud> = rig.subscribe(Stream::Cloud);
    let states: Latest<v1::CellState> = rig.subscribe(Stream::State);
    // The last to be subscribed comes: so do the others from here on.
    let before = states.wait(deadline()).unwrap().message.unwrap();
    rig.controller.place(place("p1", before.state_number, 0.16));
    let outcome = outcomes.wait(deadline()).unwrap().message.unwrap();
    assert_eq!(outcome, rig.controller.outcome("p1"));
    let cloud = common::cloud_of(&clouds, outcome.state_number);
    assert!(cloud.sequence > 0 && cloud.captured_at_ns > 0);
    assert_eq!(cloud.data.len(), 128 * 128 * 12);
    let next = common::cloud_of(&clouds, outcome.state_number);
    assert_eq!(next.sequence, cloud.sequence + 1);
    assert_eq!(next.data, cloud.data);
    let mut states = std::iter::from_fn(|| states.wait(deadline()));
    let is_after = |state: v1::CellState| state.state_number == outcome.state_number;
    assert!(states.any(|arrived| is_after(arrived.message.unwrap())));
}

#[test]
fn what_was_cut_off_did_not_happen_in_a_simulated_cell_and_is_unknown_in_another() {
    for (is_simulated, kind, more) in [
        (true, OutcomeKind::NotPlaced, 0),
        (false, OutcomeKind::Unknown, 1),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let journal = Some(folder.path().join("bridge.redb"));
        let (rig, script) = Rig::scripted(is_simulated, journal.clone());
        let renewed = rig.controller.renew("r1");
        rig.controller.place(place("p1", renewed, 0.1));
        let first = script.carry_out(&rig.controller, "p1");
        rig.controller.place(place("p2", first.state_number, 0.2));
        drop(rig);

        let (rig, script) = Rig::scripted(is_simulated, journal);
        let outcome = rig.controller.outcome("p2");
        assert_eq!(outcome.kind(), kind);
        assert!(outcome.failure.contains("restarted"));
        assert_eq!(outcome.state_number, first.state_number + more);
        assert_eq!(rig.controller.outcome("p1"), first);
        assert_eq!(rig.controller.renew("r1"), renewed);
        assert_eq!(rig.controller.state().bodies.len(), 1);
        let again = rig.controller.place(place("p2", first.state_number, 0.2));
        assert_eq!(again.phase(), ExecutionPhase::Ended);
        assert!(script.done().is_empty());
    }
}

#[test]
fn without_a_journal_that_can_be_written_nothing_is_begun() {
    let folder = tempfile::tempdir().unwrap();
    let disk = folder.path().join("disk");
    std::fs::write(&disk, "no folder").unwrap();
    let (rig, script) = Rig::scripted(true, Some(disk.join("bridge.redb")));
    let controller = &rig.controller;
    controller.refuses(place("p1", 1, 0.16), Status::Unavailable);
    controller.refuses(renew("r1", 1), Status::Unavailable);
    let report = rig.process.health().report();
    let message = report[0].message.as_str();
    assert!(message.contains("bridge.redb"), "{message}");
    assert!(!report[0].is_passing);

    std::fs::remove_file(&disk).unwrap();
    rig.wait_until_ready();
    controller.place_now("p1");
    script.carry_out(controller, "p1");
}

#[test]
fn a_cell_whose_journal_is_gone_is_held() {
    let folder = tempfile::tempdir().unwrap();
    let [journal, elsewhere] = ["bridge.redb", "elsewhere"].map(|name| folder.path().join(name));
    let (rig, script) = Rig::scripted(true, Some(journal.clone()));
    let controller = &rig.controller;
    let request = place("p1", controller.state_number(), 0.16);
    std::fs::rename(&journal, &elsewhere).unwrap();
    controller.refuses(request, Status::Unavailable);
    let holds = controller.state().holds;
    assert!(holds[0].reason.contains("put that file back"), "{holds:?}");
    assert!(!rig.process.health().is_ready());
    let resume = common::resume(&[holds[0].id.clone()]);
    controller.refuses(resume.clone(), Status::Unavailable);

    std::fs::rename(&elsewhere, &journal).unwrap();
    rig.wait_until_ready();
    assert!(controller.state().hold.is_some());
    let resumed = controller.call(resume).unwrap();
    assert_eq!(resumed.state.unwrap().hold, None);
    controller.place_now("p2");
    script.carry_out(controller, "p2");
    assert_eq!(script.done(), ["p2"]);
}

#[test]
fn the_end_waits_for_what_is_under_way() {
    let (rig, script) = Rig::scripted(true, None);
    rig.controller.place_now("p1");
    let bridge = Box::new(rig.bridge);
    let ending = std::thread::spawn(move || bridge.finish(deadline()));
    script.go.send(()).unwrap();
    ending.join().unwrap().unwrap();
    assert_eq!(script.done(), ["p1"]);
}

#[test]
fn the_end_does_not_wait_longer_than_it_may() {
    let (rig, script) = Rig::scripted(true, None);
    rig.controller.place_now("p1");
    let bridge = Box::new(rig.bridge);
    let left = bridge.finish(Instant::now() + Duration::from_millis(100));
    assert!(left.unwrap_err().contains("bridge-cell-1"));
    assert!(script.done().is_empty());
}

#[test]
fn a_robot_that_panics_ends_the_process() {
    let (rig, script) = Rig::scripted(true, None);
    let mut request = place("p1", rig.controller.state_number(), 0.16);
    request.object = "panic".to_owned();
    rig.controller.place(request);
    script.go.send(()).unwrap();
    assert!(rig.process.shutdown().wait_timeout(PATIENCE));
    let fault = rig.process.supervisor().fault().unwrap();
    assert!(fault.contains("robot-cell-1"), "{fault}");
}

#[test]
fn a_desk_that_does_not_come_back_from_a_message_would_be_noticed() {
    let rig = Rig::simulated(SimulatedSettings::default());
    rig.controller.state();
    let watched = rig.process.supervisor().watched();
    assert_eq!(watched, ["bridge-cell-1"]);
}

#[test]
fn the_cycle_of_a_decision_reaches_the_robot_whose_placement_it_is() {
    let (rig, script) = Rig::scripted(true, None);
    let controller = &rig.controller;
    let cycle = common::cycle(2.5);
    let asked = place("one", controller.state_number(), 0.16);
    let decision = v1::Decision {
        decision_id: asked.placement_id.clone(),
        item_id: asked.item_id.clone(),
        object: asked.object.clone(),
        container_from_item: asked.container_from_item,
        state_number: asked.state_number,
        cycle: Some(Box::new(convert::cycle::write(&cycle))),
        ..v1::Decision::default()
    };
    let request = v1::PlaceRequest::from(&decision);
    controller.place(request.clone());
    script.go.send(()).unwrap();
    controller.outcome("one");
    let motions = script.shared.motions.lock().unwrap().clone();
    assert_eq!(motions.len(), 1);
    assert_eq!(motions[0].as_deref(), Some(&cycle));
    // Repeated when it has ended, it is the same placement still.
    let repeated = controller.place(request);
    assert_eq!(repeated.phase(), ExecutionPhase::Ended);
    assert_eq!(script.done(), ["one"]);
    // A motion that is none is refused.
    let mut wrong = place("two", controller.state_number(), 0.16);
    let mut message = convert::cycle::write(&cycle);
    message.cycle_s = f64::NAN;
    wrong.cycle = Some(Box::new(message));
    controller.refuses(wrong, Status::Invalid);
}

#[test]
fn the_simulated_robot_takes_as_long_as_the_motion_and_gives_up_only_before_it_holds_the_item() {
    let mut robot =
        SimulatedRobot::new(SimulatedSettings::default(), &common::catalogue()).unwrap();
    let mut placement = Placement {
        placement_id: "one".to_owned(),
        item_id: "item-one".to_owned(),
        object: "brick".to_owned(),
        container_from_item: Isometry3::translation(0.16, 0.16, 0.02),
        state_number: 1,
        cycle: Some(Arc::new(common::cycle(0.3))),
    };
    let stopped = Shutdown::default();
    stopped.request();
    assert_eq!(robot.place(&placement, &stopped).unwrap_err(), CutOff);
    assert!(robot.bodies().is_empty());

    let started = Instant::now();
    let finding = robot.place(&placement, &Shutdown::default()).unwrap();
    assert!(started.elapsed() >= Duration::from_millis(300));
    assert_eq!(finding.ending, Ending::Placed);

    placement.cycle = Some(Arc::new(common::cycle(1_800.0)));
    let end = Shutdown::default();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(Duration::from_secs(1));
            end.request();
        });
        let finding = robot.place(&placement, &end).unwrap();
        assert_eq!(finding.ending, Ending::Placed);
    });
    assert!(started.elapsed() < PATIENCE);
}
