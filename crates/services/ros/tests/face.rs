//! A cell in ROS over real sessions: what it says comes, and what is asked is passed on.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use nalgebra::Isometry3;
use ppnpack_ros::action::{Action, SendGoalRequest, SendGoalResponse};
use ppnpack_ros::cdr;
use ppnpack_ros::description::Message;
use ppnpack_ros::keys::{self, TypeKey};
use ppnpack_ros::messages::ppnpack_actions::{Pack, PackGoal};
use ppnpack_ros::messages::ppnpack_msgs::{Announcement, CellState, Session};
use ppnpack_ros::messages::ppnpack_srvs::{Hold, HoldRequest, HoldResponse};
use ppnpack_ros::messages::std_srvs::{Trigger, TriggerRequest};
use ppnpack_ros::messages::tf2_msgs::TfMessage;
use ppnpack_ros::messages::unique_identifier_msgs::Uuid;
use ppnpack_ros::messages::visualization_msgs::MarkerArray;
use ppnpack_ros::names::Name;
use ppnpack_ros::service::Service;
use ppnpack_ros_service::Settings;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::process::Process;
use ppnpack_service::rpc::{self, Done, Incoming, Listener};
use ppnpack_service::stream::Publisher;
use ppnpack_service::{Running, alive};
use ppnpack_wire::convert::pose;
use ppnpack_wire::keys::{Cell, Service as Of, Stream};
use ppnpack_wire::v1;
use zenoh::pubsub::Subscriber;
use zenoh::query::ReplyKeyExpr;
use zenoh::sample::Sample;
use zenoh::{Session as ZenohSession, Wait};

/// Far more than anything here takes.
const PATIENCE: Duration = Duration::from_secs(30);

/// What a test waits between attempts.
const AGAIN: Duration = Duration::from_millis(50);

fn cell() -> Cell {
    Cell::new("cell-1").unwrap()
}

fn name(name: &str) -> Name {
    Name::new(name).unwrap()
}

/// A cell that is there, its face, and somebody in ROS.
struct Rig {
    face: Option<Box<ppnpack_ros_service::Ros>>,
    bridge: Process,
    states: Publisher<v1::CellState>,
    session: ZenohSession,
    _alive: alive::Token,
    _process: Process,
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
            face: Some(Box::new(
                ppnpack_ros_service::start(&process, settings).unwrap(),
            )),
            bridge,
            session,
            _process: process,
            hub,
        }
    }

    /// The messages of a topic.
    fn listen<M: Message>(&self, topic: &str) -> (Receiver<M>, Subscriber<()>) {
        let (sender, receiver) = sync_channel(64);
        let on_sample = move |sample: Sample| {
            let message = cdr::decode(&sample.payload().to_bytes()).unwrap();
            drop(sender.try_send(message));
        };
        let key = keys::data(0, &name(topic), &TypeKey::of_message::<M>());
        let subscribed = self.session.declare_subscriber(key).callback(on_sample);
        (receiver, subscribed.wait().unwrap())
    }

    /// What is given to whoever comes later to a topic, as advanced subscribers of Zenoh ask for it.
    fn last<M: Message>(&self, topic: &str) -> Option<Sample> {
        let key = keys::data(0, &name(topic), &TypeKey::of_message::<M>());
        let replies = self
            .session
            .get(format!("{key}/@adv/**?_max=1"))
            .accept_replies(ReplyKeyExpr::Any)
            .wait()
            .unwrap();
        let reply = replies.recv_timeout(PATIENCE).ok().flatten()?;
        Some(reply.into_result().unwrap())
    }

    /// Asks a service, again until somebody answers.
    fn call<S: Service>(&self, service: &str, request: &S::Request) -> S::Response {
        let key = keys::data(0, &name(service), &TypeKey::of_service::<S>());
        let until = Instant::now() + PATIENCE;
        while Instant::now() < until {
            let payload = cdr::encode(request).unwrap();
            let replies = self
                .session
                .get(key.as_str())
                .payload(payload)
                .wait()
                .unwrap();
            if let Ok(Some(reply)) = replies.recv_timeout(PATIENCE) {
                let sample = reply.into_result().unwrap();
                return cdr::decode(&sample.payload().to_bytes()).unwrap();
            }
            std::thread::sleep(AGAIN);
        }
        panic!("nobody answers {service}");
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

/// Does something again and again, until it comes to this.
fn comes<T>(receiver: &Receiver<T>, mut act: impl FnMut(), is_it: impl Fn(&T) -> bool) -> T {
    let until = Instant::now() + PATIENCE;
    while Instant::now() < until {
        act();
        if let Ok(message) = receiver.recv_timeout(AGAIN)
            && is_it(&message)
        {
            return message;
        }
    }
    panic!("nothing comes");
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
        }),
        ..v1::CellState::default()
    }
}

#[test]
fn a_state_comes_with_the_frames_of_its_items() {
    let rig = Rig::new(&Settings::default());
    let (states, _of_states) = rig.listen::<CellState>("/ppnpack/cell_1/state");
    let (frames, _of_frames) = rig.listen::<TfMessage>("/tf");
    let put = || rig.states.put(&state()).unwrap();
    let came = comes(&states, put, |_| true);
    assert_eq!(came.header.frame_id, "cell-1/container");
    assert_eq!((came.state_number, came.is_held), (7, true));
    assert_eq!(came.hold_reason, "a door is open");
    assert_eq!(came.bodies[0].object, "mug");
    assert_eq!(came.bodies[0].pose.position.y, 0.2);
    assert_eq!(came.bodies[0].pose.orientation.w, 1.0);
    let put = || rig.states.put(&state()).unwrap();
    let tf = comes(&frames, put, |tf| !tf.transforms.is_empty());
    let item = &tf.transforms[0];
    assert_eq!(item.header.frame_id, "cell-1/container");
    assert_eq!(item.child_frame_id, "cell-1/item/a");
    assert_eq!(item.transform.translation.z, 0.03);
}

#[test]
fn whoever_comes_later_is_given_what_is_so() {
    let rig = Rig::new(&Settings::default());
    let (states, _subscription) = rig.listen::<CellState>("/ppnpack/cell_1/state");
    comes(&states, || rig.states.put(&state()).unwrap(), |_| true);
    let topic = "/ppnpack/cell_1/state";
    let sample = rig.last::<CellState>(topic).unwrap();
    let key = keys::data(0, &name(topic), &TypeKey::of_message::<CellState>());
    assert_eq!(sample.key_expr().as_str(), key);
    let last: CellState = cdr::decode(&sample.payload().to_bytes()).unwrap();
    assert_eq!(last.state_number, 7);
    assert_eq!(sample.attachment().unwrap().len(), 33);
}

#[test]
fn what_nobody_followed_is_not_given_to_who_comes_later() {
    let rig = Rig::new(&Settings::default());
    let topic = "/ppnpack/cell_1/scene";
    let (drawn, subscription) = rig.listen::<MarkerArray>(topic);
    comes(&drawn, || rig.states.put(&state()).unwrap(), |_| true);
    assert!(rig.last::<MarkerArray>(topic).is_some());
    drop(subscription);
    let until = Instant::now() + PATIENCE;
    while rig.last::<MarkerArray>(topic).is_some() {
        assert!(Instant::now() < until, "it is kept");
        std::thread::sleep(AGAIN);
    }
}

#[test]
fn what_is_asked_is_passed_on_and_answered() {
    let settings = Settings {
        request_limit_s: 0.5,
        ..Settings::default()
    };
    let rig = Rig::new(&settings);
    let (sender, holds) = sync_channel(8);
    let hold = move |incoming: Incoming<v1::HoldRequest>| {
        sender.try_send(incoming.message().clone()).unwrap();
        incoming.reply(v1::HoldReply::default(), Done::default());
    };
    let _listener = rpc::listen(&rig.bridge, Some(&cell()), hold).unwrap();
    let request = HoldRequest {
        reason: "lunch".to_owned(),
        is_aborting: true,
    };
    let response = rig.call::<Hold>("/ppnpack/cell_1/hold", &request);
    let done = HoldResponse {
        success: true,
        message: String::new(),
    };
    assert_eq!(response, done);
    let held = holds.recv_timeout(PATIENCE).unwrap();
    assert_eq!((held.reason.as_str(), held.is_aborting), ("lunch", true));
    // Nobody resumes, and that is said.
    let response = rig.call::<Trigger>("/ppnpack/cell_1/resume", &TriggerRequest::default());
    assert!(!response.success);
    assert!(!response.message.is_empty());
}

/// Answers for a planner which session is under way.
fn tell_session(planner: &Process) -> Listener {
    let answer = |incoming: Incoming<v1::SessionRequest>| {
        let session = v1::Session {
            session_id: "before".to_owned(),
            ..v1::Session::default()
        };
        let reply = v1::SessionReply {
            session: Some(session),
            ..v1::SessionReply::default()
        };
        incoming.reply(reply, Done::default());
    };
    rpc::listen(planner, Some(&cell()), answer).unwrap()
}

/// The service by which goals of the action are sent.
struct SendPack;

impl Service for SendPack {
    type Request = SendGoalRequest<Pack>;
    type Response = SendGoalResponse<Pack>;

    fn type_name() -> String {
        format!("{}_SendGoal", Pack::type_name())
    }
}

#[test]
fn a_goal_changes_no_other_session_than_its_own() {
    let rig = Rig::new(&Settings::default());
    let planner = embedded::process(&rig.hub, Of::Planner, "planner-1").unwrap();
    let (sender, sessions) = sync_channel(8);
    let _listeners = (
        tell_session(&planner),
        rpc::listen(
            &rig.bridge,
            Some(&cell()),
            |incoming: Incoming<v1::CellStateRequest>| {
                incoming.reply(v1::CellStateReply::default(), Done::default());
            },
        )
        .unwrap(),
        rpc::listen(
            &planner,
            Some(&cell()),
            |incoming: Incoming<v1::BeginRequest>| {
                incoming.reply(v1::BeginReply::default(), Done::default());
            },
        )
        .unwrap(),
        rpc::listen(
            &planner,
            Some(&cell()),
            move |incoming: Incoming<v1::AnnounceRequest>| {
                sender
                    .try_send(incoming.header().session_id.clone())
                    .unwrap();
                incoming.refuse(v1::Status::Conflict, "another session is under way");
            },
        )
        .unwrap(),
    );
    let _alive = alive::announce(&planner, Some(&cell())).unwrap();
    let request = SendGoalRequest {
        goal_id: Uuid { uuid: [7; 16] },
        goal: PackGoal {
            session_id: "own".to_owned(),
            items: vec![Announcement::default()],
        },
    };
    let response = rig.call::<SendPack>("/ppnpack/cell_1/pack/_action/send_goal", &request);
    assert!(response.accepted);
    let meant = sessions.recv_timeout(PATIENCE).unwrap();
    assert_eq!(meant.as_deref(), Some("own"));
}

#[test]
fn a_session_that_began_before_is_told() {
    let rig = Rig::new(&Settings::default());
    let planner = embedded::process(&rig.hub, Of::Planner, "planner-1").unwrap();
    let _listener = tell_session(&planner);
    let _alive = alive::announce(&planner, Some(&cell())).unwrap();
    let until = Instant::now() + PATIENCE;
    let told = loop {
        if let Some(told) = rig.last::<Session>("/ppnpack/cell_1/session") {
            break told;
        }
        assert!(Instant::now() < until, "no session is told");
        std::thread::sleep(AGAIN);
    };
    let session: Session = cdr::decode(&told.payload().to_bytes()).unwrap();
    assert_eq!(session.session_id, "before");
}
