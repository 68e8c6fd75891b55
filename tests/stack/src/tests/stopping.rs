//! Cells that are held, changed by hand, lose their past or have it restored, over real processes.

use std::path::Path;
use std::process::{Command, Output};
use std::thread;
use std::time::Duration;

use crate::cell::CellClient;
use crate::process::{Signal, beside};
use crate::stack::Options;
use crate::tests::common::{
    self, OBJECTS, assert_consistent, count, not_placed, refused, slow_robot, started, wait_for,
    wait_for_end, wait_until_packed,
};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, ItemState, OutcomeKind, SessionEnd, Status};

/// The maximum time for the answer to a hold, whatever the robot does.
const AT_ONCE: Duration = Duration::from_secs(1);

fn hold(cell: &CellClient, reason: &str) -> v1::CellState {
    let request = v1::HoldRequest {
        reason: reason.to_owned(),
        ..v1::HoldRequest::default()
    };
    cell.ask_within(request, AT_ONCE).unwrap().state.unwrap()
}

fn wait_for_placing(cell: &CellClient) {
    common::until(|| {
        let state = cell.state().unwrap();
        match state.executing_placement_id.is_empty() {
            true => Err(format!("{state:?}")),
            false => Ok(()),
        }
    });
}

/// Whether a decision was given up, as the cell is held, and none is pending.
fn stands_still(session: &v1::Session) -> bool {
    let last = session.settled.last().map(v1::SettledDecision::kind);
    session.pending.is_none() && last == Some(OutcomeKind::NotPlaced)
}

/// Has a program settle a restored file, and waits for its end.
fn after_restore(program: &str, setting: &str, file: &Path) -> Output {
    Command::new(beside(program).unwrap())
        .arg(format!("--set={setting}={}", file.display()))
        .arg("--after-restore")
        .output()
        .unwrap()
}

#[test]
fn a_held_cell_stands_still_and_goes_on_by_itself_when_it_is_resumed() {
    let (_stack, cell) = started(&slow_robot(Options::default()));
    cell.begin("held", &OBJECTS[..8], true).unwrap();
    wait_for(&cell, |session| count(session, ItemState::Packed) >= 1);
    let held = hold(&cell, "a door is open");
    assert_eq!(held.hold.unwrap().reason, "a door is open");

    // What was under way ends; what is decided next is given up and made anew when the cell goes
    // on.
    let packed = count(&wait_for(&cell, stands_still), ItemState::Packed);
    let before = cell.state().unwrap();

    // A hand takes the first item out.
    let removed = before.bodies[0].item_id.clone();
    let changed = v1::ChangedRequest {
        removed_item_ids: vec![removed],
        ..v1::ChangedRequest::default()
    };
    let changed = cell.ask(changed).unwrap().state.unwrap();
    assert_eq!(changed.state_number, before.state_number + 1);
    assert_eq!(changed.bodies.len(), before.bodies.len() - 1);
    let session = cell.session().unwrap();
    assert!(stands_still(&session), "{session:?}");
    assert_eq!(count(&session, ItemState::Packed), packed);
    assert_eq!(session.end(), SessionEnd::Unspecified);

    cell.resume().unwrap();
    let session = wait_until_packed(&cell);
    assert_eq!(cell.state().unwrap().bodies.len(), session.items.len() - 1);
}

#[test]
fn a_decision_that_nobody_carried_out_in_time_is_planned_anew() {
    let limit = Duration::from_millis(500);
    let setting = format!("service.decision_age_limit_s={:?}", limit.as_secs_f64());
    let (_stack, cell) = started(&common::with(&[(Service::Bridge, &setting)]));
    cell.begin("late", &OBJECTS, false).unwrap();
    let decision = cell.plan().unwrap().unwrap();
    let state = cell.state().unwrap();
    assert!(decision.decided_at_ns <= state.clock_ns);
    // This is what is waited for: that it is too old.
    thread::sleep(limit);
    let refused = refused(&cell, v1::PlaceRequest::from(&decision), Status::Stale);
    assert!(refused.to_string().contains("decided"), "{refused}");
    cell.report(&decision, not_placed(&cell)).unwrap();
    assert!(cell.step().unwrap().is_some());

    // By itself the planner is in time.
    cell.acknowledge().unwrap();
    let session = wait_for_end(&cell);
    assert_ne!(session.end(), SessionEnd::Failed, "{}", session.failure);
    assert_consistent(&cell, "afterwards");
}

#[test]
fn a_hold_outlives_kills_of_bridge_and_planner() {
    let (mut stack, cell) = started(&slow_robot(Options::default()));
    cell.begin("held-and-killed", &OBJECTS[..6], true).unwrap();
    wait_for_placing(&cell);
    hold(&cell, "somebody is in the cell");
    for name in ["bridge-1", "planner-1"] {
        stack.kill(name).unwrap();
    }
    let state = cell.state().unwrap();
    assert_eq!(state.hold.unwrap().reason, "somebody is in the cell");
    wait_for(&cell, stands_still);
    assert_eq!(cell.state().unwrap().state_number, state.state_number);
    cell.resume().unwrap();
    wait_until_packed(&cell);
    assert_consistent(&cell, "at the end");
}

#[test]
fn a_placement_that_is_lost_with_the_journal_is_unknown_and_not_made_again() {
    let (mut stack, cell) = started(&slow_robot(Options::default()));
    cell.begin("journal-lost", &OBJECTS[..6], true).unwrap();
    wait_for(&cell, |session| count(session, ItemState::Packed) >= 1);
    wait_for_placing(&cell);
    stack.signal("planner-1", Signal::SIGKILL).unwrap();
    let pending = cell.state().unwrap().executing_placement_id;
    stack.signal("bridge-1", Signal::SIGKILL).unwrap();
    std::fs::remove_file(stack.folder.path().join("bridge.redb")).unwrap();
    stack.restart("bridge-1").unwrap();
    stack.restart("planner-1").unwrap();

    let session = wait_for_end(&cell);
    assert_eq!(session.end(), SessionEnd::Failed);
    let failure = &session.failure;
    assert!(failure.contains("may lie anywhere"), "{failure}");
    let settled = session.settled.last().unwrap();
    if !pending.is_empty() {
        assert_eq!(settled.decision_id, pending);
    }
    assert_eq!(settled.kind(), OutcomeKind::Unknown);
    assert_eq!(count(&session, ItemState::Gone), 1);
    assert!(cell.state().unwrap().bodies.is_empty());
}

#[test]
fn restored_backups_are_held_and_nothing_old_is_carried_out() {
    let (mut stack, cell) = started(&Options::default());
    cell.begin("restored", &OBJECTS[..6], false).unwrap();
    cell.step().unwrap().unwrap();
    let old = cell.plan().unwrap().unwrap();
    let programs = ["bridge-1", "planner-1"];
    let files = ["bridge.redb", "sessions.redb", "sessions.cells/cell-1.redb"];
    let files = files.map(|file| stack.folder.path().join(file));
    let backups = files.clone().map(|file| file.with_extension("backup"));
    for name in programs {
        stack.signal(name, Signal::SIGKILL).unwrap();
    }
    for (file, backup) in files.iter().zip(&backups) {
        std::fs::copy(file, backup).unwrap();
    }
    for name in programs {
        stack.restart(name).unwrap();
    }
    // Since the backup the container has got further.
    cell.place(&old).unwrap();
    let after = cell.state().unwrap().state_number;
    for name in programs {
        stack.signal(name, Signal::SIGKILL).unwrap();
    }
    for (file, backup) in files.iter().zip(&backups) {
        std::fs::copy(backup, file).unwrap();
    }
    for (program, setting, file) in [
        ("ppnpack-bridge", "service.journal", &files[0]),
        ("ppnpack-planner", "service.store", &files[1]),
    ] {
        let output = after_restore(program, setting, file);
        let text = String::from_utf8_lossy(&output.stdout);
        let is_settled = output.status.success() && text.contains("cell-1");
        assert!(is_settled, "{output:?}");
        let missing = after_restore(program, setting, &file.with_extension("missing"));
        let text = String::from_utf8_lossy(&missing.stderr);
        assert!(!missing.status.success(), "{text}");
        assert!(text.contains("no such file"), "{text}");
    }
    for name in programs {
        stack.restart(name).unwrap();
    }

    let session = cell.session().unwrap();
    assert_eq!(session.end(), SessionEnd::Failed);
    assert!(session.failure.contains("backup"), "{}", session.failure);
    let state = cell.state().unwrap();
    assert!(state.state_number > after && state.hold.is_some());
    for _ in 0..2 {
        // Held or not, it may have been carried out.
        refused(&cell, v1::PlaceRequest::from(&old), Status::Forgotten);
        cell.resume().unwrap();
    }
}
