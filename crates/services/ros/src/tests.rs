//! A cell in ROS over real sessions: what it says comes, and what is asked is passed on.

use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use nalgebra::Isometry3;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{self, Done, Incoming, Listener};
use ppnpack_service::stream::Publisher;
use ppnpack_service::{Running, alive};
use ppnpack_wire::convert::pose;
use ppnpack_wire::keys::{Cell, Service as Of, Stream};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1;
use zenoh::pubsub::Subscriber;
use zenoh::query::ReplyKeyExpr;
use zenoh::sample::Sample;
use zenoh::{Session as ZenohSession, Wait};

use crate::rmw::cdr;
use crate::rmw::keys::{self, Name};
use crate::rmw::messages::{CellState, Hold, Service, Session, SetBool, TfMessage, Trigger, Typed};
use crate::{Ros, Settings};

const PATIENCE: Duration = Duration::from_secs(30);

/// How long a test waits between attempts.
const AGAIN: Duration = Duration::from_millis(50);

fn cell() -> Cell {
    Cell::new("cell-1").unwrap()
}

/// Gives the key of a topic, or of a service by its request.
fn key<M: Typed>(topic: &str) -> String {
    keys::data(0, &Name::new(topic).unwrap(), &M::key())
}

/// A cell that is there, its face, and somebody in ROS.
struct Rig {
    face: Option<Box<Ros>>,
    bridge: Process,
    states: Publisher<v1::CellState>,
    session: ZenohSession,
    _alive: alive::Token,
    hub: Hub,
}

impl Rig {
    fn new(settings: &Settings) -> Self {
        let hub = embedded::hub().unwrap();
        let bridge = embedded::process(&hub, Of::Bridge, "bridge-1").unwrap();
        let process = embedded::process(&hub, Of::Ros, "ros-1").unwrap();
        let session = embedded::session(&hub).unwrap();
        Self {
            _alive: alive::announce(&bridge, Some(&cell())).unwrap(),
            states: Publisher::new(&bridge, &cell(), Stream::State).unwrap(),
            face: Some(Box::new(crate::start(&process, settings).unwrap())),
            bridge,
            session,
            hub,
        }
    }

    /// The messages of a topic.
    fn listen<M: Typed>(&self, topic: &str) -> (Receiver<M>, Subscriber<()>) {
        let (sender, receiver) = sync_channel(64);
        let on_sample = move |sample: Sample| {
            let message = cdr::decode(&sample.payload().to_bytes()).unwrap();
            drop(sender.try_send(message));
        };
        let subscribed = self.session.declare_subscriber(key::<M>(topic));
        let subscribed = subscribed.callback(on_sample);
        (receiver, subscribed.wait().unwrap())
    }

    /// Asks for the last message of a topic as advanced subscribers of Zenoh do that come later.
    fn last<M: Typed>(&self, topic: &str) -> Option<(Sample, M)> {
        let asked = self
            .session
            .get(format!("{}/@adv/**?_max=1", key::<M>(topic)));
        let replies = asked.accept_replies(ReplyKeyExpr::Any).wait().unwrap();
        let reply = replies.recv_timeout(PATIENCE).ok()??;
        let sample = reply.into_result().unwrap();
        let message = cdr::decode(&sample.payload().to_bytes()).unwrap();
        Some((sample, message))
    }

    /// Asks a service, again until somebody answers.
    fn call<S: Service>(&self, service: &str, request: &S) -> S::Response {
        until("an answer", || {
            let payload = cdr::encode(request).unwrap();
            let asked = self.session.get(key::<S>(service)).payload(payload);
            let reply = asked.wait().unwrap().recv_timeout(PATIENCE).ok()??;
            let sample = reply.into_result().unwrap();
            Some(cdr::decode(&sample.payload().to_bytes()).unwrap())
        })
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        let face = self.face.take().unwrap();
        let ended = face.finish(Instant::now() + PATIENCE);
        if !std::thread::panicking() {
            assert_eq!(ended, Ok(()));
        }
    }
}

fn until<T>(what: &str, mut act: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + PATIENCE;
    while Instant::now() < deadline {
        if let Some(given) = act() {
            return given;
        }
        std::thread::sleep(AGAIN);
    }
    panic!("{what} does not come");
}

/// Does something again and again, until a message comes.
fn comes<T>(receiver: &Receiver<T>, mut act: impl FnMut()) -> T {
    until("a message", || {
        act();
        receiver.recv_timeout(AGAIN).ok()
    })
}

/// Answers requests, and tells what each says.
fn listen<R: Request>(process: &Process, told: fn(&R) -> String) -> (Listener, Receiver<String>) {
    let (sender, receiver) = sync_channel(8);
    let answer = move |incoming: Incoming<R>| {
        sender.try_send(told(incoming.message())).unwrap();
        incoming.reply(R::Reply::default(), Done::default());
    };
    (
        rpc::listen(process, Some(&cell()), answer).unwrap(),
        receiver,
    )
}

fn state() -> v1::CellState {
    let at = Isometry3::translation(0.1, 0.2, 0.03);
    v1::CellState {
        state_number: 7,
        bodies: vec![v1::Body {
            item_id: "a".to_owned(),
            object: "mug".to_owned(),
            container_from_item: Some(pose::write(&at)),
            is_inside: true,
            is_found: true,
        }],
        hold: Some(v1::Hold {
            reason: "a door is open".to_owned(),
            ..v1::Hold::default()
        }),
        holds: ["h1", "h2"]
            .map(|id| v1::Hold {
                id: id.to_owned(),
                ..v1::Hold::default()
            })
            .into(),
        ..v1::CellState::default()
    }
}

#[test]
fn a_state_comes_with_the_frames_of_its_items_also_to_whoever_comes_later() {
    let rig = Rig::new(&Settings::default());
    let topic = "/ppnpack/cell_1/state";
    let (states, _of_states) = rig.listen::<CellState>(topic);
    let (frames, _of_frames) = rig.listen::<TfMessage>("/tf");
    let put = || rig.states.put(&state()).unwrap();
    let came = comes(&states, put);
    assert_eq!(came.header.frame_id, "cell-1/container");
    assert_eq!((came.state_number, came.is_held), (7, true));
    assert_eq!(came.hold_reason, "a door is open");
    assert_eq!(came.bodies[0].object, "mug");
    assert_eq!(came.bodies[0].pose.position.y, 0.2);
    assert_eq!(came.bodies[0].pose.orientation.w, 1.0);
    let item = &comes(&frames, put).transforms[0];
    assert_eq!(item.header.frame_id, "cell-1/container");
    assert_eq!(item.child_frame_id, "cell-1/item/a");
    assert_eq!(item.transform.translation.z, 0.03);

    let (sample, last) = rig.last::<CellState>(topic).unwrap();
    assert_eq!(sample.key_expr().as_str(), key::<CellState>(topic));
    assert_eq!(last.state_number, 7);
    assert_eq!(sample.attachment().unwrap().len(), 33);
    let (_, fixed) = rig.last::<TfMessage>("/tf_static").unwrap();
    assert_eq!(fixed.transforms[0].child_frame_id, "cell-1/container");
}

#[test]
fn what_is_asked_is_passed_on_and_answered() {
    let settings = Settings {
        request_limit_s: 0.5,
        ..Settings::default()
    };
    let rig = Rig::new(&settings);
    let hold = |asked: &v1::HoldRequest| format!("{} {}", asked.reason, asked.is_aborting);
    let (_listener, holds) = listen(&rig.bridge, hold);
    let request = Hold {
        reason: "lunch".to_owned(),
        is_aborting: true,
    };
    let response = rig.call("/ppnpack/cell_1/hold", &request);
    assert!(response.success && response.message.is_empty());
    assert_eq!(holds.recv_timeout(PATIENCE).unwrap(), "lunch true");
    // Nobody resumes, and that is said.
    let response = rig.call("/ppnpack/cell_1/resume", &Trigger::default());
    assert!(!response.success);
    assert!(!response.message.is_empty());
}

#[test]
fn what_is_resumed_and_acknowledged_is_what_was_told_in_ros() {
    let rig = Rig::new(&Settings::default());
    let planner = embedded::process(&rig.hub, Of::Planner, "planner-1").unwrap();
    let _alive = alive::announce(&planner, Some(&cell())).unwrap();
    let sessions = Publisher::new(&planner, &cell(), Stream::Session).unwrap();
    let resume = |asked: &v1::ResumeRequest| asked.hold_ids.join(" ");
    let (_resumes, resumed) = listen(&rig.bridge, resume);
    let switch = |asked: &v1::AutomaticRequest| asked.failure_id.clone();
    let (_switches, switched) = listen(&planner, switch);

    let (states, _of_states) = rig.listen::<CellState>("/ppnpack/cell_1/state");
    comes(&states, || rig.states.put(&state()).unwrap());
    let done = rig.call("/ppnpack/cell_1/resume", &Trigger::default());
    assert!(done.success, "{}", done.message);
    assert_eq!(resumed.recv_timeout(PATIENCE).unwrap(), "h1 h2");

    let failed = v1::Session {
        session_id: "s".to_owned(),
        failure_id: "s-1".to_owned(),
        ..v1::Session::default()
    };
    let (told, _of_sessions) = rig.listen::<Session>("/ppnpack/cell_1/session");
    comes(&told, || sessions.put(&failed).unwrap());
    let done = rig.call("/ppnpack/cell_1/automatic", &SetBool { data: true });
    assert!(done.success, "{}", done.message);
    assert_eq!(switched.recv_timeout(PATIENCE).unwrap(), "s-1");
}

#[test]
fn a_session_that_began_before_is_told() {
    let rig = Rig::new(&Settings::default());
    let planner = embedded::process(&rig.hub, Of::Planner, "planner-1").unwrap();
    let answer = |incoming: Incoming<v1::SessionRequest>| {
        let session = v1::Session {
            session_id: "before".to_owned(),
            ..v1::Session::default()
        };
        incoming.reply(session.into(), Done::default());
    };
    let _listener = rpc::listen(&planner, Some(&cell()), answer).unwrap();
    let _alive = alive::announce(&planner, Some(&cell())).unwrap();
    let told = || rig.last::<Session>("/ppnpack/cell_1/session");
    let (_, session) = until("the session", told);
    assert_eq!(session.session_id, "before");
}
