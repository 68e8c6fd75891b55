//! Faults of real processes. Each test has a set-up, a fault, a recovery and an invariant.
//!
//! The invariants are those of `docs/reliability.md`: nothing that was acknowledged is lost,
//! nothing is placed twice or for another state of the container, and a fresh request succeeds
//! within five seconds of the end of the fault.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use crate::cell::CellClient;
use crate::process::Signal;
use crate::stack::Options;
use crate::tests::common::{
    self, INSTANCES, OBJECTS, RECOVERY, assert_consistent, assert_degraded, assert_recovered,
    assert_serves_again, finish, slow_robot, started,
};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, OutcomeKind, Status};

/// The points of a step at which a process is killed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    BeforePlan,
    Decided,
    Placing,
    Placed,
}

const STAGES: [Stage; 4] = [
    Stage::BeforePlan,
    Stage::Decided,
    Stage::Placing,
    Stage::Placed,
];

/// Makes one step, with a fault at one of its stages. A controller may repeat all that it does.
fn step_with(cell: &CellClient, at: Stage, fault: &mut dyn FnMut()) -> Option<v1::Decision> {
    let mut at_stage = |stage| {
        if stage == at {
            fault();
        }
    };
    at_stage(Stage::BeforePlan);
    let decision = cell.plan().unwrap()?;
    at_stage(Stage::Decided);
    cell.ask(v1::PlaceRequest::from(&decision)).unwrap();
    at_stage(Stage::Placing);
    let outcome = cell.place(&decision).unwrap();
    at_stage(Stage::Placed);
    cell.report(&decision, outcome).unwrap();
    Some(decision)
}

#[test]
fn each_service_is_killed_at_each_stage_of_a_step() {
    let (mut stack, cell) = started(&slow_robot(Options::default()));
    cell.begin("kills", &OBJECTS, false).unwrap();
    for name in INSTANCES {
        for stage in STAGES {
            let mut ended = Instant::now();
            let mut kill = || {
                stack.kill(name).unwrap();
                ended = Instant::now();
            };
            let decision = step_with(&cell, stage, &mut kill);
            let when = format!("{name} killed at {stage:?}");
            assert!(decision.is_some(), "{when}: nothing was decided");
            assert_serves_again(&cell, ended, &when);
            assert_consistent(&cell, &when);
        }
    }
    finish(&cell);
}

#[test]
fn everything_is_killed_while_the_planner_packs_by_itself() {
    let (mut stack, cell) = started(&slow_robot(Options::default()));
    cell.begin("all-killed", &OBJECTS[..12], true).unwrap();
    for round in 0..3 {
        let packed = |session: &v1::Session| common::count(session, v1::ItemState::Packed);
        let before = common::count_packed(&cell);
        common::wait_for(&cell, |session| {
            packed(session) > before || session.end != 0
        });
        for name in INSTANCES {
            stack.signal(name, Signal::SIGKILL).unwrap();
        }
        for name in INSTANCES {
            stack.restart(name).unwrap();
        }
        let when = format!("everything killed, round {round}");
        assert_serves_again(&cell, Instant::now(), &when);
        assert_consistent(&cell, &when);
    }
    let session = common::wait_for_end(&cell);
    assert_ne!(session.end(), v1::SessionEnd::Failed, "{}", session.failure);
    assert_consistent(&cell, "at the end");
}

/// Asserts that steps are soon planned as they were asked for.
fn assert_asks_again(cell: &CellClient, when: &str) {
    let ended = Instant::now();
    while !cell.step().unwrap().unwrap().degraded.is_empty() {
        assert!(ended.elapsed() < RECOVERY, "{when}");
    }
    assert_recovered(ended, when);
    assert_consistent(cell, "afterwards");
}

#[test]
fn a_stopped_heuristic_service_is_done_without_until_it_goes_on() {
    let (mut stack, cell) = started(&Options::default());
    cell.begin("stopped", &OBJECTS, false).unwrap();
    assert_eq!(cell.step().unwrap().unwrap().degraded, Vec::<String>::new());

    stack.signal("heuristic-1", Signal::SIGSTOP).unwrap();
    assert_degraded(&cell.step().unwrap().unwrap(), "heuristic-1");
    assert_consistent(&cell, "while it is stopped");

    stack.signal("heuristic-1", Signal::SIGCONT).unwrap();
    assert_asks_again(&cell, "a stopped heuristic service is asked again");
}

#[test]
fn a_heuristic_service_decides_what_the_planner_decides() {
    let decisions = |evaluate: &'static str| {
        let (_stack, cell) = started(&Options {
            evaluate,
            ..Options::default()
        });
        cell.begin("same", &OBJECTS, false).unwrap();
        let mut decisions = Vec::new();
        while let Some(decision) = cell.step().unwrap() {
            assert_eq!(decision.degraded, Vec::<String>::new());
            let value = decision.value.to_bits();
            decisions.push((decision.item_id, decision.placement, value));
        }
        decisions
    };
    let alone = decisions("in-process");
    assert!(alone.len() > 10);
    assert_eq!(decisions("services"), alone);
}

#[test]
fn a_stopped_bridge_places_once_when_it_goes_on() {
    let (mut stack, cell) = started(&Options::default());
    cell.begin("stopped-bridge", &OBJECTS, false).unwrap();
    let decision = cell.plan().unwrap().unwrap();
    let before = cell.state().unwrap();
    stack.signal("bridge-1", Signal::SIGSTOP).unwrap();
    let limit = Duration::from_millis(300);
    for _ in 0..3 {
        let request = v1::PlaceRequest::from(&decision);
        let answer = cell.ask_within(request, limit);
        assert!(answer.is_err(), "a stopped bridge answered");
    }
    stack.signal("bridge-1", Signal::SIGCONT).unwrap();
    let ended = Instant::now();
    let outcome = cell.place(&decision).unwrap();
    assert_recovered(ended, "a stopped bridge places");
    assert_eq!(outcome.kind(), OutcomeKind::Placed, "{}", outcome.failure);
    assert_eq!(cell.state().unwrap().state_number, before.state_number + 1);
    cell.report(&decision, outcome).unwrap();
    assert_consistent(&cell, "afterwards");
}

#[test]
fn a_stopped_perception_delays_plans_and_none_is_made_on_an_old_heightmap() {
    let (mut stack, cell) = started(&Options::default());
    cell.begin("stopped-perception", &OBJECTS, false).unwrap();
    let decision = cell.plan().unwrap().unwrap();
    stack.signal("perception-1", Signal::SIGSTOP).unwrap();
    cell.carry_out(&decision).unwrap();
    let refused = cell.ask_within(v1::PlanRequest::default(), Duration::from_secs(1));
    let planned = "planned on a heightmap from before the placement";
    assert!(refused.is_err(), "{planned}");
    stack.signal("perception-1", Signal::SIGCONT).unwrap();
    let ended = Instant::now();
    assert!(cell.step().unwrap().is_some());
    assert_serves_again(&cell, ended, "a stopped perception goes on");
    assert_consistent(&cell, "afterwards");
}

#[test]
fn clouds_that_queued_while_perception_was_stopped_show_nothing_that_was_done_meanwhile() {
    let options = common::with(&[
        (Service::Bridge, "service.cells.cell-1.is_stateless=true"),
        (Service::Bridge, "service.cloud_rate_hz=20"),
    ]);
    let (mut stack, cell) = started(&options);
    cell.begin("queued", &["toy_brick"; 20], false).unwrap();
    let is_noticed = "clouds that are held up are noticed from now on";
    common::until(|| {
        let log = stack.log("perception-1").unwrap();
        log.contains(is_noticed).then_some(()).ok_or(log)
    });
    let mut poses = BTreeSet::new();
    for _ in 0..4 {
        let decision = cell.plan().unwrap().unwrap();
        stack.signal("perception-1", Signal::SIGSTOP).unwrap();
        // The first of the clouds that queue show the cell as it was.
        cell.carry_out(&decision).unwrap();
        let refused = cell.ask_within(v1::PlanRequest::default(), Duration::from_secs(1));
        assert!(refused.is_err(), "planned while perception was stopped");
        stack.signal("perception-1", Signal::SIGCONT).unwrap();
        // All are alike: planned on a picture from before, the next one would go where this one
        // lies.
        let placement = decision.placement.unwrap();
        let place = format!("{placement:?}");
        assert!(poses.insert(place), "{placement:?} was planned twice");
    }
    assert_consistent(&cell, "afterwards");
}

#[test]
fn services_without_a_router_end_to_begin_anew_and_a_bridge_once_its_robot_stands_still() {
    // Longer than the patience and the grace of a process together.
    let slow = "service.cells.cell-1.place_duration_s=18";
    let (mut stack, cell) = started(&common::with(&[(Service::Bridge, slow)]));
    cell.begin("no-router", &OBJECTS[..4], false).unwrap();
    let decision = cell.plan().unwrap().unwrap();
    cell.ask(v1::PlaceRequest::from(&decision)).unwrap();
    let begun = Instant::now();
    stack.signal("router", Signal::SIGKILL).unwrap();
    let others = ["planner-1", "perception-1", "heuristic-1"];
    for name in others {
        stack.wait_failed(name).unwrap();
    }
    assert!(begun.elapsed() > Duration::from_secs(6), "a short cut");
    stack.wait_failed("bridge-1").unwrap();

    for name in others.into_iter().chain(["bridge-1", "router"]) {
        stack.restart(name).unwrap();
    }
    let ended = Instant::now();
    let outcome = cell.place(&decision).unwrap();
    assert_eq!(outcome.kind(), OutcomeKind::Placed, "{}", outcome.failure);
    cell.report(&decision, outcome).unwrap();
    assert_serves_again(&cell, ended, "a router that was away for long");
    assert_consistent(&cell, "afterwards");
}

#[test]
fn a_request_for_a_plan_that_is_repeated_gives_the_same_decision() {
    let (mut stack, cell) = started(&Options::default());
    cell.begin("same-plan", &OBJECTS, false).unwrap();
    let request = || v1::PlanRequest {
        header: Some(v1::RequestHeader {
            request_id: "plan-1".to_owned(),
            ..v1::RequestHeader::default()
        }),
        alternatives: 0,
    };
    let decision = cell.ask(request()).unwrap().decision.unwrap();
    stack.kill("planner-1").unwrap();
    let ended = Instant::now();
    let again = cell.ask(request()).unwrap().decision.unwrap();
    assert_recovered(ended, "a plan asked for again over a restart");
    assert_eq!(again.decision_id, decision.decision_id);
    assert_eq!(again.placement, decision.placement);
    common::refused(&cell, v1::PlanRequest::default(), Status::Conflict);
}

#[test]
fn a_damaged_session_store_is_put_aside_and_a_new_session_begins() {
    let (mut stack, cell) = started(&Options::default());
    cell.begin("damaged", &OBJECTS, false).unwrap();
    cell.step().unwrap().unwrap();
    stack.signal("planner-1", Signal::SIGTERM).unwrap();
    let sessions = stack.folder.path().join("sessions.cells");
    std::fs::write(sessions.join("cell-1.redb"), vec![0x5a; 20_000]).unwrap();
    stack.restart("planner-1").unwrap();
    let ended = Instant::now();
    stack.wait_ready("planner-1").unwrap();
    assert_eq!(cell.session().unwrap().session_id, "");
    assert_recovered(ended, "a damaged session store");
    let aside = std::fs::read_dir(sessions).unwrap();
    let aside = aside.filter(|entry| {
        let name = entry.as_ref().unwrap().file_name();
        name.to_string_lossy().contains("damaged")
    });
    assert_eq!(aside.count(), 1);
    cell.begin("not-empty", &[], false).unwrap();
    // Which of them lie there the planner does not know any more, but the bridge does.
    let refused = cell.announce(&OBJECTS).unwrap_err().to_string();
    assert!(refused.contains("lies in container cell-1"), "{refused}");
    cell.renew().unwrap();
    cell.begin("after-damage", &OBJECTS, false).unwrap();
    assert!(cell.step().unwrap().is_some());
}

#[test]
fn every_service_ends_cleanly_when_asked_to() {
    let (mut stack, cell) = started(&Options::default());
    cell.begin("end", &OBJECTS, true).unwrap();
    for name in INSTANCES {
        stack.signal(name, Signal::SIGTERM).unwrap();
        let log = stack.log(name).unwrap();
        assert!(log.contains("finished everything"), "{name}: {log}");
    }
}

#[test]
fn a_network_that_hangs_or_is_away_costs_time_once_and_the_search_is_exhaustive() {
    let options = Options {
        has_network: true,
        ..common::with(&[(Service::Planner, "service.cells.cell-1.propose_limit_s=0.2")])
    };
    let (mut stack, cell) = started(&options);
    cell.begin("network", &OBJECTS, false).unwrap();
    assert_eq!(cell.step().unwrap().unwrap().degraded, Vec::<String>::new());
    stack.signal("ppn-1", Signal::SIGSTOP).unwrap();
    for _ in 0..2 {
        assert_degraded(&cell.step().unwrap().unwrap(), "ppn");
    }
    stack.signal("ppn-1", Signal::SIGCONT).unwrap();
    stack.signal("ppn-1", Signal::SIGKILL).unwrap();
    assert_degraded(&cell.step().unwrap().unwrap(), "ppn");
    stack.restart("ppn-1").unwrap();
    stack.wait_ready("ppn-1").unwrap();
    assert_asks_again(&cell, "the network is asked again");
}
