//! A cell that is held, aborted, changed by hand and resumed.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::common::{
    self, Controller, Rig, Shared, changed, deadline, header, hold, place, renew, resume,
};
use ppnpack_bridge::Settings;
use ppnpack_bridge::robot::Robot;
use ppnpack_bridge::simulated::SimulatedSettings;
use ppnpack_service::rpc::CallError;
use ppnpack_service::stream::Latest;
use ppnpack_wire::convert;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1::{self, ExecutionPhase, OutcomeKind, Status};

fn reason(state: Option<v1::CellState>) -> Option<String> {
    state.unwrap().hold.map(|hold| hold.reason)
}

fn item_ids(state: &v1::CellState) -> Vec<&str> {
    let bodies = state.bodies.iter();
    bodies.map(|body| body.item_id.as_str()).collect()
}

#[test]
fn a_hold_is_answered_while_the_robot_moves_and_nothing_begins_until_it_is_resumed() {
    let (rig, script) = Rig::scripted(false, None);
    let controller = &rig.controller;
    let state = controller.state_number();
    controller.place(place("p1", state, 0.16));

    // The robot does not go on before the test lets it.
    let door = controller.call(hold("a door is open", false)).unwrap();
    assert_eq!(reason(door.state).as_deref(), Some("a door is open"));
    let again = controller.call(hold("a hand", false)).unwrap();
    let both = Some("a door is open; a hand".to_owned());
    assert_eq!(reason(again.state), both);

    // What was under way comes to its end, and is known.
    script.carry_out(controller, "p1");
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
    controller.refuses(renew("r1", state + 1), Status::Held);
    assert_eq!(script.done(), ["p1"]);

    // Each is ended by its name.
    controller.refuses(resume(&[]), Status::Invalid);
    let left = controller.resume(std::slice::from_ref(&again.hold_id));
    assert_eq!(reason(Some(left)).as_deref(), Some("a door is open"));
    controller.refuses(resume(&[again.hold_id]), Status::Stale);
    controller.refuses(next.clone(), Status::Held);
    for _ in 0..2 {
        let resumed = controller.resume(std::slice::from_ref(&door.hold_id));
        assert_eq!(reason(Some(resumed)), None);
    }
    // Its request may come late, when its item is planned anew: what was refused never begins.
    controller.refuses(next, Status::Stale);
    let anew = place("p3", controller.state_number(), 0.16);
    assert_eq!(controller.place(anew).phase(), ExecutionPhase::Accepted);
    script.carry_out(controller, "p3");
}

#[test]
fn a_resume_that_is_sent_again_does_not_end_a_later_hold() {
    let folder = tempfile::tempdir().unwrap();
    let journal = Some(folder.path().join("bridge.redb"));
    let (rig, _script) = Rig::scripted(true, journal.clone());
    let looks = rig.controller.call(hold("somebody looks", false)).unwrap();
    let request = v1::ResumeRequest {
        header: header("r1"),
        ..resume(&[looks.hold_id])
    };
    let resumed = rig.controller.call(request.clone()).unwrap();
    assert_eq!(reason(resumed.state), None);
    let door = rig.controller.call(hold("a door is open", false)).unwrap();
    rig.controller.refuses(request.clone(), Status::Stale);
    drop(rig);
    let (rig, _script) = Rig::scripted(true, journal);
    rig.controller.refuses(request, Status::Stale);
    assert_eq!(rig.controller.hold_ids(), [&*door.hold_id]);
    let resumed = rig.controller.resume(&[door.hold_id]);
    assert_eq!(reason(Some(resumed)), None);
}

#[test]
fn a_step_is_one_placement_which_holds_the_cell_as_it_begins() {
    let folder = tempfile::tempdir().unwrap();
    let journal = Some(folder.path().join("bridge.redb"));
    let (rig, script) = Rig::scripted(false, journal.clone());
    let looks = rig.controller.call(hold("somebody looks", false)).unwrap();
    let step = v1::ResumeRequest {
        most_placements: 1,
        ..resume(&[looks.hold_id])
    };
    let state = rig.controller.call(step.clone()).unwrap().state.unwrap();
    assert!(state.holds.is_empty() && state.hold.is_none());
    rig.controller.place(place("p1", state.state_number, 0.1));
    // Before the robot moves: the one who asked for the step may be gone.
    let holds = rig.controller.state().holds;
    let [held] = &holds[..] else {
        panic!("it is not held, or more than once");
    };
    assert_eq!(held.holder, "bridge");
    let placed = script.carry_out(&rig.controller, "p1");
    let next = place("p2", placed.state_number, 0.2);
    rig.controller.refuses(next.clone(), Status::Held);
    // The request for the step once more, which is late.
    rig.controller.refuses(step.clone(), Status::Stale);
    drop(rig);

    let (rig, script) = Rig::scripted(false, journal);
    rig.controller.refuses(step, Status::Stale);
    rig.controller.refuses(next, Status::Held);
    let state = rig.controller.resume(std::slice::from_ref(&held.id));
    for (id, x_m) in [("p3", 0.2), ("p4", 0.25)] {
        let state_number = rig.controller.state_number();
        assert!(state_number >= state.state_number);
        rig.controller.place(place(id, state_number, x_m));
        script.carry_out(&rig.controller, id);
    }
}

#[test]
fn a_real_cell_of_which_nothing_is_known_begins_held() {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("bridge.redb");
    let settings = Settings {
        journal: Some(journal.clone()),
        ..Settings::default()
    };
    for lose in [
        |_: &Path| {},
        |journal: &Path| std::fs::remove_file(journal).unwrap(),
        |journal: &Path| std::fs::write(journal, "no database").unwrap(),
    ] {
        lose(&journal);
        let (rig, _script) = Rig::unseen(false, &settings);
        let controller = &rig.controller;
        let state = controller.state();
        let request = place("p1", state.state_number, 0.16);
        controller.refuses(request, Status::Held);
        let told = reason(Some(state)).unwrap();
        assert!(told.contains("nothing is known of the cell"), "{told}");
        let resumed = controller.resume(&controller.hold_ids());
        assert_eq!(reason(Some(resumed)), None);
        // Somebody holds it, which is lost with the journal.
        controller.call(hold("a hand", false)).unwrap();
    }
    // What is known is known, and a simulated cell is what its journal says.
    let (rig, _script) = Rig::unseen(false, &settings);
    let held = reason(Some(rig.controller.state()));
    assert_eq!(held.as_deref(), Some("a hand"));
    let (rig, _script) = Rig::unseen(true, &Settings::default());
    assert_eq!(reason(Some(rig.controller.state())), None);
}

/// Waits until a cell is held by so many holds; gives their ids.
fn until_holds_are(controller: &Controller, count: usize) -> Vec<String> {
    let until = deadline();
    loop {
        let ids = controller.hold_ids();
        if ids.len() == count {
            return ids;
        }
        assert!(Instant::now() < until, "{ids:?} where {count} are expected");
    }
}

#[test]
fn containers_of_one_robot_are_held_and_go_on_together() {
    let names = ["cell-1", "cell-2"];
    let settings = Settings {
        robots: BTreeMap::from([("robot".to_owned(), names.map(str::to_owned).into())]),
        ..Settings::default()
    };
    let scripted = names.map(|_| common::scripted(false));
    let [(first, script), (second, _other)] = scripted;
    let robots: [Box<dyn Robot>; 2] = [Box::new(first), Box::new(second)];
    let cells = names.map(|name| Cell::new(name).unwrap());
    let robots: BTreeMap<Cell, Box<dyn Robot>> = cells.into_iter().zip(robots).collect();
    let rig = Rig::new(|process| ppnpack_bridge::start_robots(process, &settings, robots).unwrap());
    let [left, right] = names.map(|name| rig.controller.at(name));
    // Of neither anything is known.
    let ids = until_holds_are(&left, 2);
    left.resume(&ids[..1]);
    assert_eq!(until_holds_are(&right, 1), &ids[1..]);
    right.resume(&ids);
    until_holds_are(&left, 0);

    // A hold at the one breaks off what is placed into the other.
    left.place_now("p1");
    let held = right.call(hold("a hand", true)).unwrap();
    let outcome = left.outcome("p1");
    assert_eq!(outcome.kind(), OutcomeKind::NotPlaced);
    assert_eq!(until_holds_are(&left, 1), [&*held.hold_id]);
    let refused = place("p2", left.state_number(), 0.16);
    left.refuses(refused.clone(), Status::Held);

    // One placement of a step in the one holds the other, too.
    let step = v1::ResumeRequest {
        most_placements: 1,
        ..resume(&[held.hold_id])
    };
    right.call(step).unwrap();
    until_holds_are(&left, 0);
    left.refuses(refused, Status::Stale);
    left.place_now("p3");
    let elsewhere = place("p4", right.state_number(), 0.16);
    let status = right.refused(elsewhere);
    assert!(matches!(status, Status::Held | Status::Stale), "{status:?}");
    script.carry_out(&left, "p3");
    assert_eq!(until_holds_are(&right, 1), left.hold_ids());
}

#[test]
fn a_hold_that_comes_before_the_journal_can_be_opened_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let disk = folder.path().join("disk");
    std::fs::write(&disk, "no folder").unwrap();
    let (rig, _script) = Rig::scripted(true, Some(disk.join("bridge.redb")));
    let controller = &rig.controller;
    controller.refuses(hold("a door is open", false), Status::Unavailable);
    std::fs::remove_file(&disk).unwrap();
    std::fs::create_dir(&disk).unwrap();
    let until = deadline();
    let state = loop {
        match controller.call(v1::CellStateRequest::default()) {
            Ok(reply) => break reply.state,
            Err(error) => assert!(Instant::now() < until, "{error}"),
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
    let held = controller.call(hold("stop", true)).unwrap();
    let outcome = controller.outcome("p1");
    assert_eq!(outcome.kind(), OutcomeKind::NotPlaced);
    let failure = &outcome.failure;
    assert!(failure.contains("broken off"), "{failure}");
    assert_eq!(outcome.state_number, state);
    assert_eq!(script.done(), Vec::<String>::new());

    // The next one is not broken off by that.
    controller.resume(&[held.hold_id]);
    controller.place_now("p2");
    script.carry_out(controller, "p2");
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
    let clouds: Latest<v1::PointCloud> = rig.subscribe(Stream::Cloud);

    controller.refuses(changed(&["no id"]), Status::Invalid);
    let reply = controller.call(changed(&["item-p1", "item-p9"])).unwrap();
    let after = reply.state.unwrap();
    assert_eq!(after.state_number, before.state_number + 1);
    assert_eq!(item_ids(&after), ["item-p2"]);
    let old = place("p3", before.state_number, 0.08);
    controller.refuses(old, Status::Stale);

    // The cell itself has it no more: it can be placed there again.
    let cloud = common::cloud_of(&clouds, after.state_number);
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
    let states: Latest<v1::CellState> = rig.subscribe(Stream::State);
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
    script.carry_out(controller, "p1");
    controller.refuses(place("p2", state + 1, 0.16), Status::Held);
}

/// Holds a cell whose robot hangs where the test has it, after more than the robot's queue could
/// take.
fn hold_while_it_hangs(hangs: impl Fn(&Shared) -> &Mutex<()>) {
    /// Far more than an answer takes, far less than a test waits for one.
    const AT_ONCE: Duration = Duration::from_secs(5);
    let (rig, script) = Rig::scripted(true, None);
    let controller = &rig.controller;
    let first = controller.state_number();
    for (id, state) in [("p1", first), ("p2", first + 1)] {
        controller.place(place(id, state, 0.16));
        script.carry_out(controller, id);
    }
    let clouds: Latest<v1::PointCloud> = rig.subscribe(Stream::Cloud);

    let hanging = hangs(&script.shared).lock().unwrap();
    let taken_out = [vec!["item-p1"], vec!["item-p2"]];
    for removed in taken_out.into_iter().chain(vec![Vec::new(); 98]) {
        controller.call_for(changed(&removed), AT_ONCE).unwrap();
    }
    for _ in 0..100 {
        let request = v1::CellStateRequest::default();
        controller.call_for(request, AT_ONCE).unwrap();
    }
    let held = controller.call_for(hold("a door is open", false), AT_ONCE);
    let held = held.unwrap();
    assert_eq!(reason(held.state).as_deref(), Some("a door is open"));

    drop(hanging);
    let state = controller.resume(&[held.hold_id]);
    assert_eq!(state.state_number, first + 2 + 100 + 1);
    assert!(state.bodies.is_empty());
    // The robot heard of all that was taken out, though not of each change by itself.
    common::cloud_of(&clouds, state.state_number);
    controller.place(place("p3", state.state_number, 0.16));
    script.carry_out(controller, "p3");
    assert_eq!(item_ids(&controller.state()), ["item-p3"]);
}

#[test]
fn a_robot_that_hangs_as_it_takes_over_a_change_keeps_nobody_from_holding_the_cell() {
    hold_while_it_hangs(|robot| &robot.taking_over);
}

#[test]
fn a_sensor_that_hangs_keeps_nobody_from_holding_the_cell() {
    hold_while_it_hangs(|robot| &robot.capturing);
}

#[test]
fn a_hand_is_not_taken_note_of_while_the_robot_moves() {
    let (rig, script) = Rig::scripted(false, None);
    let controller = &rig.controller;
    let state = controller.state_number();
    controller.place(place("p1", state, 0.16));
    controller.refuses(changed(&[]), Status::Busy);
    script.go.send(()).unwrap();
    controller.outcome("p1");
    let changed = controller.call(changed(&[])).unwrap().state.unwrap();
    assert_eq!(changed.state_number, state + 2);
    let held = controller.call(hold("", false)).unwrap();
    assert_eq!(reason(held.state).as_deref(), Some("it was asked for"));
}
