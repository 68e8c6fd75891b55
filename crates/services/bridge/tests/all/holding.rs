//! A cell that is held, aborted, changed by hand and resumed.

use std::sync::Mutex;
use std::time::Duration;

use crate::common::{self, Rig, Script, changed, deadline, hold, place, renew};
use ppnpack_bridge::Settings;
use ppnpack_bridge::simulated::SimulatedSettings;
use ppnpack_service::rpc::CallError;
use ppnpack_service::stream::Latest;
use ppnpack_wire::MAX_CLOUD_BYTES;
use ppnpack_wire::convert;
use ppnpack_wire::keys::Stream;
use ppnpack_wire::v1::{self, ExecutionPhase, OutcomeKind, Status};

/// Why the cell is held, if it is.
fn reason(state: Option<v1::CellState>) -> Option<String> {
    state.unwrap().hold.map(|hold| hold.reason)
}

#[test]
fn a_hold_is_answered_while_the_robot_moves_and_nothing_begins_until_it_is_resumed() {
    let (rig, script) = Rig::scripted(false, None);
    let controller = &rig.controller;
    let state = controller.state_number();
    controller.place(place("p1", state, 0.16));

    // The robot does not go on before the test lets it.
    let held = controller.call(hold("a door is open", false)).unwrap();
    assert_eq!(reason(held.state).as_deref(), Some("a door is open"));
    let again = controller.call(hold("another reason", false)).unwrap();
    assert_eq!(reason(again.state).as_deref(), Some("a door is open"));

    // What was under way comes to its end, and is known.
    script.go.send(()).unwrap();
    assert_eq!(controller.outcome("p1").kind(), OutcomeKind::Placed);
    let known = controller.place(place("p1", state, 0.16));
    assert_eq!(known.phase(), ExecutionPhase::Ended);

    let next = place("p2", state + 1, 0.16);
    match controller.call(next.clone()) {
        Err(CallError::Refused {
            status, message, ..
        }) => {
            assert_eq!(status, Status::Held);
            assert!(message.contains("a door is open"), "{message}");
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(controller.refused(renew("r1", state + 1)), Status::Held);
    assert_eq!(script.done(), ["p1"]);

    for _ in 0..2 {
        let resumed = controller.call(v1::ResumeRequest::default()).unwrap();
        assert_eq!(reason(resumed.state), None);
    }
    // Its request may come late, when its item is planned anew: what was refused never begins.
    assert_eq!(controller.refused(next), Status::Stale);
    let anew = place("p3", controller.state_number(), 0.16);
    assert_eq!(controller.place(anew).phase(), ExecutionPhase::Accepted);
    script.go.send(()).unwrap();
    assert_eq!(controller.outcome("p3").kind(), OutcomeKind::Placed);
}

#[test]
fn a_resume_that_is_sent_again_does_not_end_a_later_hold() {
    let rig = Rig::simulated(SimulatedSettings::default());
    let resume = |id: &str| {
        let request = v1::ResumeRequest {
            header: Some(v1::RequestHeader {
                request_id: id.to_owned(),
                ..v1::RequestHeader::default()
            }),
        };
        reason(rig.controller.call(request).unwrap().state)
    };
    rig.controller.call(hold("somebody looks", false)).unwrap();
    assert_eq!(resume("r1"), None);
    rig.controller.call(hold("a door is open", false)).unwrap();
    assert_eq!(resume("r1").as_deref(), Some("a door is open"));
    assert_eq!(resume("r2"), None);
}

#[test]
fn a_hold_that_comes_before_the_journal_can_be_opened_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let disk = folder.path().join("disk");
    std::fs::write(&disk, "no folder").unwrap();
    let (rig, _script) = Rig::scripted(true, Some(disk.join("bridge.redb")));
    let controller = &rig.controller;
    assert_eq!(
        controller.refused(hold("a door is open", false)),
        Status::Unavailable
    );
    std::fs::remove_file(&disk).unwrap();
    std::fs::create_dir(&disk).unwrap();
    let until = deadline();
    let state = loop {
        match controller.call(v1::CellStateRequest::default()) {
            Ok(reply) => break reply.state,
            Err(error) => assert!(std::time::Instant::now() < until, "{error}"),
        }
    };
    assert_eq!(reason(state).as_deref(), Some("a door is open"));
}

#[test]
fn aborting_leaves_an_item_that_was_not_touched_where_it_is() {
    let (rig, script) = Rig::scripted(false, None);
    let controller = &rig.controller;
    let state = controller.state_number();
    controller.place(place("p1", state, 0.16));
    controller.call(hold("stop", true)).unwrap();
    let outcome = controller.outcome("p1");
    assert_eq!(outcome.kind(), OutcomeKind::NotPlaced);
    assert!(
        outcome.failure.contains("broken off"),
        "{}",
        outcome.failure
    );
    assert_eq!(outcome.state_number, state);
    assert_eq!(script.done(), Vec::<String>::new());

    // The next one is not broken off by that.
    controller.call(v1::ResumeRequest::default()).unwrap();
    controller.place(place("p2", controller.state_number(), 0.16));
    script.go.send(()).unwrap();
    assert_eq!(controller.outcome("p2").kind(), OutcomeKind::Placed);
}

#[test]
fn a_hand_in_the_container_makes_earlier_plans_stale_and_has_it_seen_anew() {
    let rig = Rig::simulated(SimulatedSettings::default());
    let controller = &rig.controller;
    let first = controller.state_number();
    for (index, (id, x_m)) in [("p1", 0.08), ("p2", 0.24)].into_iter().enumerate() {
        controller.place(place(id, first + index as u64, x_m));
        controller.outcome(id);
    }
    let before = controller.state();
    let clouds: Latest<v1::PointCloud> =
        Latest::subscribe(&rig.caller, &common::cell(), Stream::Cloud, MAX_CLOUD_BYTES).unwrap();

    let unchanged = controller.refused(changed(&["no id"]));
    assert_eq!(unchanged, Status::Invalid);
    let reply = controller.call(changed(&["item-p1", "item-p9"])).unwrap();
    let after = reply.state.unwrap();
    assert_eq!(after.state_number, before.state_number + 1);
    let left: Vec<&str> = after
        .bodies
        .iter()
        .map(|body| body.item_id.as_str())
        .collect();
    assert_eq!(left, ["item-p2"]);
    let old = place("p3", before.state_number, 0.08);
    assert_eq!(controller.refused(old), Status::Stale);

    // The cell itself has it no more: it can be placed there again.
    let cloud = loop {
        let cloud = clouds.wait(deadline()).unwrap().message.unwrap();
        if cloud.state_number == after.state_number {
            break cloud;
        }
    };
    assert!(!cloud.data.is_empty());
    let outcome = controller.carry_out("p4", after.state_number, 0.08);
    assert_eq!(outcome.kind(), OutcomeKind::Placed);
    assert!(outcome.slide_m < 0.01 && outcome.tilt_rad < 0.1);
}

#[test]
fn a_robot_that_takes_longer_than_its_motion_has_the_cell_held() {
    let settings = Settings {
        overdue_s: 0.1,
        ..Settings::default()
    };
    let (rig, script) = Rig::scripted_with(false, &settings);
    let controller = &rig.controller;
    let states: Latest<v1::CellState> =
        Latest::subscribe(&rig.caller, &common::cell(), Stream::State, MAX_CLOUD_BYTES).unwrap();
    let state = controller.state_number();
    let mut with_motion = place("p1", state, 0.16);
    with_motion.cycle = Some(Box::new(convert::cycle::write(&common::cycle(0.2))));
    controller.place(with_motion);
    let reason = loop {
        let told = states.wait(deadline()).unwrap().message.unwrap();
        if let Some(hold) = told.hold {
            break hold.reason;
        }
    };
    assert!(
        reason.contains("p1") && reason.contains("longer"),
        "{reason}"
    );
    script.go.send(()).unwrap();
    assert_eq!(controller.outcome("p1").kind(), OutcomeKind::Placed);
    assert_eq!(
        controller.refused(place("p2", state + 1, 0.16)),
        Status::Held
    );
}

/// Holds a cell whose robot hangs where the test has it, after all that could fill what waits for
/// the robot.
fn hold_while_it_hangs(hangs: impl Fn(&Script) -> &Mutex<()>) {
    /// Far more than an answer takes, far less than a test waits for one.
    const AT_ONCE: Duration = Duration::from_secs(5);
    let (rig, script) = Rig::scripted(true, None);
    let controller = &rig.controller;
    let first = controller.state_number();
    for (id, state) in [("p1", first), ("p2", first + 1)] {
        controller.place(place(id, state, 0.16));
        script.go.send(()).unwrap();
        assert_eq!(controller.outcome(id).kind(), OutcomeKind::Placed);
    }
    let clouds: Latest<v1::PointCloud> =
        Latest::subscribe(&rig.caller, &common::cell(), Stream::Cloud, MAX_CLOUD_BYTES).unwrap();

    let hanging = hangs(&script).lock().unwrap();
    let taken_out = [vec!["item-p1"], vec!["item-p2"]];
    for removed in taken_out.into_iter().chain(vec![Vec::new(); 98]) {
        controller.call_for(changed(&removed), AT_ONCE).unwrap();
    }
    for _ in 0..100 {
        let request = v1::CellStateRequest::default();
        controller.call_for(request, AT_ONCE).unwrap();
    }
    let held = controller.call_for(hold("a door is open", false), AT_ONCE);
    assert_eq!(
        reason(held.unwrap().state).as_deref(),
        Some("a door is open")
    );

    drop(hanging);
    let resumed = controller.call(v1::ResumeRequest::default()).unwrap();
    let state = resumed.state.unwrap();
    assert_eq!(state.state_number, first + 2 + 100 + 1);
    assert!(state.bodies.is_empty());
    // The robot heard of all that was taken out, though not of each change by itself.
    let is_shown = |cloud: v1::PointCloud| cloud.state_number == state.state_number;
    let mut clouds = std::iter::from_fn(|| clouds.wait(deadline()));
    assert!(clouds.any(|arrived| is_shown(arrived.message.unwrap())));
    controller.place(place("p3", state.state_number, 0.16));
    script.go.send(()).unwrap();
    assert_eq!(controller.outcome("p3").kind(), OutcomeKind::Placed);
    let bodies = controller.state().bodies;
    let ids: Vec<&str> = bodies.iter().map(|body| body.item_id.as_str()).collect();
    assert_eq!(ids, ["item-p3"]);
}

#[test]
fn a_robot_that_hangs_as_it_takes_over_a_change_keeps_nobody_from_holding_the_cell() {
    hold_while_it_hangs(|script| &script.taking_over);
}

#[test]
fn a_sensor_that_hangs_keeps_nobody_from_holding_the_cell() {
    hold_while_it_hangs(|script| &script.capturing);
}

#[test]
fn a_hand_is_not_taken_note_of_while_the_robot_moves() {
    let (rig, script) = Rig::scripted(false, None);
    let state = rig.controller.state_number();
    rig.controller.place(place("p1", state, 0.16));
    assert_eq!(rig.controller.refused(changed(&[])), Status::Busy);
    script.go.send(()).unwrap();
    rig.controller.outcome("p1");
    let changed = rig.controller.call(changed(&[])).unwrap().state.unwrap();
    assert_eq!(changed.state_number, state + 2);
    let held = rig
        .controller
        .call_for(hold("", false), Duration::from_secs(5));
    assert_eq!(
        reason(held.unwrap().state).as_deref(),
        Some("it was asked for")
    );
}
