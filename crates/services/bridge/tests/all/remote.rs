//! A robot that is a program of its own, which is asked over the wire and may say anything.

use std::sync::{Arc, Mutex};

use nalgebra::Isometry3;
use ppnpack_bridge::RemoteSettings;
use ppnpack_bridge::simulated::SimulatedSettings;
use ppnpack_service::rpc::{self, Done, Incoming, Listener};
use ppnpack_wire::convert::pose;
use ppnpack_wire::v1::{self, OutcomeKind, Status};

use crate::common::{Rig, cell, hold, place, scripted};

/// An answer to a placement; `None` while the robot still moves.
type Answer = fn(&v1::CarryOutRequest) -> Option<v1::Outcome>;

/// The program of a robot, as a test has it.
struct Program {
    start: Mutex<String>,
    answer: Mutex<Answer>,
    /// The numbers of bodies that were taken over.
    taken: Mutex<Vec<usize>>,
    begun: Mutex<Vec<String>>,
}

impl Program {
    fn new(answer: Answer) -> Arc<Self> {
        Arc::new(Self {
            start: Mutex::new("first".to_owned()),
            answer: Mutex::new(answer),
            taken: Mutex::default(),
            begun: Mutex::default(),
        })
    }

    /// Answers the bridge's requests, until the listeners are dropped.
    fn listen(self: &Arc<Self>, rig: &Rig) -> (Listener, Listener, Listener) {
        let own = || Arc::clone(self);
        let (taking, carrying, bringing) = (own(), own(), own());
        let cell = cell();
        let listened = (
            rpc::listen(&rig.caller, Some(&cell), move |it| taking.take_over(it)),
            rpc::listen(&rig.caller, Some(&cell), move |it| carrying.carry_out(it)),
            rpc::listen(&rig.caller, Some(&cell), move |it| bringing.bring(it)),
        );
        (
            listened.0.unwrap(),
            listened.1.unwrap(),
            listened.2.unwrap(),
        )
    }

    fn take_over(&self, incoming: Incoming<v1::TakeOverRequest>) {
        self.taken
            .lock()
            .unwrap()
            .push(incoming.message().bodies.len());
        let reply = v1::TakeOverReply {
            start: self.start.lock().unwrap().clone(),
            ..v1::TakeOverReply::default()
        };
        incoming.reply(reply, Done::default());
    }

    fn carry_out(&self, incoming: Incoming<v1::CarryOutRequest>) {
        let request = incoming.message();
        if request.start != *self.start.lock().unwrap() {
            return incoming.refuse(Status::Stale, "it was started anew");
        }
        let id = request.placement.clone().unwrap().placement_id;
        let mut begun = self.begun.lock().unwrap();
        if !begun.contains(&id) {
            begun.push(id);
        }
        let answer = *self.answer.lock().unwrap();
        let reply = v1::CarryOutReply {
            outcome: answer(request),
            ..v1::CarryOutReply::default()
        };
        incoming.reply(reply, Done::default());
    }

    fn bring(&self, incoming: Incoming<v1::BringEmptyRequest>) {
        let reply = v1::BringEmptyReply {
            has_ended: true,
            ..v1::BringEmptyReply::default()
        };
        incoming.reply(reply, Done::default());
    }
}

fn rig() -> Rig {
    Rig::simulated(SimulatedSettings {
        remote: Some(RemoteSettings { is_simulated: true }),
        ..SimulatedSettings::default()
    })
}

/// The end of an item that was placed, without a word on where it lies.
fn placed(_: &v1::CarryOutRequest) -> Option<v1::Outcome> {
    Some(v1::Outcome {
        kind: OutcomeKind::Placed.into(),
        is_inside: true,
        ..v1::Outcome::default()
    })
}

/// The same with something else in it.
fn placed_but(change: impl FnOnce(&mut v1::Outcome)) -> Option<v1::Outcome> {
    let mut outcome = placed(&v1::CarryOutRequest::default())?;
    change(&mut outcome);
    Some(outcome)
}

#[test]
fn a_program_places_and_renews_and_the_bridge_keeps_account() {
    let rig = rig();
    let program = Program::new(placed);
    let _listened = program.listen(&rig);
    let controller = &rig.controller;
    let before = controller.state_number();
    let outcome = controller.carry_out("p1", before, 0.16);
    assert_eq!(
        (outcome.kind(), outcome.is_found),
        (OutcomeKind::Placed, false)
    );
    assert_eq!(outcome.state_number, before + 1);
    let bodies = controller.state().bodies;
    assert_eq!(bodies.len(), 1);
    // As planned, as nobody looked.
    let planned = place("p1", before, 0.16).container_from_item;
    assert_eq!(bodies[0].container_from_item, planned);
    assert!(!bodies[0].is_found);
    controller.renew("r1");
    assert_eq!(controller.state().bodies, []);
    assert_eq!(*program.begun.lock().unwrap(), ["p1"]);
}

#[test]
fn what_cannot_be_is_unknown_whatever_the_program_says() {
    let lies: [Answer; 7] = [
        |_| placed_but(|it| it.kind = 0),
        |_| placed_but(|it| it.placement_id = "another".to_owned()),
        |_| placed_but(|it| it.item_id = "another".to_owned()),
        |_| placed_but(|it| it.slide_m = f64::NAN),
        |_| placed_but(|it| it.tilt_rad = f64::INFINITY),
        |_| {
            placed_but(|it| {
                let away = Isometry3::translation(9e5, 0.1, 0.1);
                it.container_from_item = Some(pose::write(&away));
            })
        },
        |_| placed_but(|it| it.container_from_item = Some(v1::Pose::default())),
    ];
    let rig = rig();
    let program = Program::new(placed);
    let _listened = program.listen(&rig);
    for (number, lie) in lies.into_iter().enumerate() {
        *program.answer.lock().unwrap() = lie;
        let state = rig.controller.state_number();
        let outcome = rig.controller.carry_out(&format!("p{number}"), state, 0.16);
        assert_eq!(outcome.kind(), OutcomeKind::Unknown, "lie {number}");
        assert!(outcome.failure.contains("cannot be"), "{}", outcome.failure);
        assert_eq!(rig.controller.state().bodies, []);
    }
}

#[test]
fn a_program_that_is_started_anew_takes_over_first() {
    let rig = rig();
    let program = Program::new(placed);
    let _listened = program.listen(&rig);
    let controller = &rig.controller;
    controller.carry_out("p1", controller.state_number(), 0.16);
    *program.start.lock().unwrap() = "second".to_owned();
    let outcome = controller.carry_out("p2", controller.state_number(), 0.08);
    assert_eq!(outcome.kind(), OutcomeKind::Placed);
    assert_eq!(*program.taken.lock().unwrap(), [0, 1]);
    assert_eq!(*program.begun.lock().unwrap(), ["p1", "p2"]);
}

#[test]
fn what_an_earlier_start_may_have_begun_is_unknown_and_not_begun_again() {
    let rig = rig();
    let program = Program::new(|_| None);
    let _listened = program.listen(&rig);
    let controller = &rig.controller;
    controller.place_now("p1");
    while program.begun.lock().unwrap().is_empty() {
        std::thread::yield_now();
    }
    *program.start.lock().unwrap() = "second".to_owned();
    *program.answer.lock().unwrap() = placed;
    assert_eq!(controller.outcome("p1").kind(), OutcomeKind::Unknown);
    assert_eq!(*program.begun.lock().unwrap(), ["p1"]);
    // The next one begins once it has taken over.
    let outcome = controller.carry_out("p2", controller.state_number(), 0.16);
    assert_eq!(outcome.kind(), OutcomeKind::Placed);
}

#[test]
fn without_a_program_nothing_is_placed_and_holds_are_answered() {
    let rig = rig();
    let controller = &rig.controller;
    controller.place_now("p1");
    let held = controller.call(hold("the robot does not answer", false));
    let state = held.unwrap().state.unwrap();
    assert_eq!(state.executing_placement_id, "p1");
    let outcome = controller.outcome("p1");
    assert_eq!(outcome.kind(), OutcomeKind::NotPlaced);
    assert!(
        outcome.failure.contains("the robot's program"),
        "{}",
        outcome.failure
    );
}

#[test]
fn a_robot_that_hangs_as_it_takes_over_keeps_no_hold_waiting() {
    let (robot, script) = scripted(true);
    let hanging = script.shared.taking_over.lock().unwrap();
    let robots = [(cell(), Box::new(robot) as _)].into_iter().collect();
    let settings = ppnpack_bridge::Settings::default();
    let rig = Rig::new(|process| ppnpack_bridge::start_robots(process, &settings, robots).unwrap());
    rig.controller.call(hold("a door", false)).unwrap();
    assert_eq!(rig.controller.state().holds.len(), 1);
    drop(hanging);
}
