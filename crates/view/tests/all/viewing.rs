//! Viewers of Foxglove's protocol: what they see, that nothing is read without one, and that one
//! that does not read holds nobody up.

use std::collections::BTreeMap;
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD};
use nalgebra::{Isometry3, Point3};
use ppnpack_service::alive;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::process::Process;
use ppnpack_service::stream::Publisher;
use ppnpack_view::View;
use ppnpack_wire::convert::cloud::{self, Capture};
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::v1;
use prost::Message as _;
use prost_reflect::{DescriptorPool, DynamicMessage};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// The longest that anything here may take.
const PATIENCE: Duration = Duration::from_secs(20);

fn cell() -> Cell {
    Cell::new("cell-1").unwrap()
}

/// A cell that is there, and publishes what a test says.
struct Rig {
    plans: Publisher<v1::Decision>,
    clouds: Publisher<v1::PointCloud>,
    records: Publisher<v1::PlanningRecord>,
    view: View,
    _alive: alive::Token,
    _process: Process,
    _hub: Hub,
}

impl Rig {
    fn new() -> Self {
        let hub = embedded::hub().unwrap();
        let process = embedded::process(&hub, Service::Planner, "planner-1").unwrap();
        let address: SocketAddr = "127.0.0.1:0".parse().unwrap();
        Self {
            plans: Publisher::new(&process, &cell(), Stream::Plan).unwrap(),
            clouds: Publisher::new(&process, &cell(), Stream::Cloud).unwrap(),
            records: Publisher::new(&process, &cell(), Stream::Record).unwrap(),
            view: View::start(&embedded::session(&hub).unwrap(), address).unwrap(),
            _alive: alive::announce(&process, Some(&cell())).unwrap(),
            _process: process,
            _hub: hub,
        }
    }
}

fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

struct Viewer {
    socket: WebSocket<TcpStream>,
    /// By topic, as they were advertised.
    channels: BTreeMap<String, Value>,
}

impl Viewer {
    /// A viewer that has heard of these channels.
    fn new(rig: &Rig, topics: &[&str]) -> Self {
        let address = rig.view.address();
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut request = format!("ws://{address}").into_client_request().unwrap();
        let protocol = "foxglove.sdk.v1".parse().unwrap();
        request
            .headers_mut()
            .insert("sec-websocket-protocol", protocol);
        let (socket, _) = tungstenite::client(request, stream).unwrap();
        let mut viewer = Self {
            socket,
            channels: BTreeMap::new(),
        };
        // The server knows a channel only some time after it has told of it, but before it tells of
        // the next: this is the last.
        let last = "/cell-1/planned_scene";
        for topic in topics.iter().chain([&last]) {
            while !viewer.channels.contains_key(*topic) {
                viewer.read();
            }
        }
        viewer
    }

    /// Subscribes channels, each by its number among these.
    fn look_at(&mut self, topics: &[&str]) {
        let subscriptions = topics.iter().enumerate();
        let subscriptions = subscriptions
            .map(|(id, topic)| json!({"id": id, "channelId": self.channels[*topic]["id"]}));
        let subscriptions: Vec<Value> = subscriptions.collect();
        let message = json!({"op": "subscribe", "subscriptions": subscriptions});
        self.socket
            .send(Message::text(message.to_string()))
            .unwrap();
    }

    /// The number of the subscription and the payload of the next message, where one came.
    fn read(&mut self) -> Option<(u32, Vec<u8>)> {
        match self.socket.read().unwrap() {
            Message::Text(text) => {
                let said: Value = serde_json::from_str(&text).unwrap();
                if said["op"] == "advertise" {
                    for channel in said["channels"].as_array().unwrap() {
                        let topic = channel["topic"].as_str().unwrap().to_owned();
                        self.channels.insert(topic, channel.clone());
                    }
                }
                None
            }
            // An opcode, the subscription, the time.
            Message::Binary(data) if data[0] == 1 => {
                let subscription = u32::from_le_bytes(data[1..5].try_into().unwrap());
                Some((subscription, data[13..].to_vec()))
            }
            _ => None,
        }
    }

    fn next(&mut self) -> (u32, Vec<u8>) {
        loop {
            if let Some(message) = self.read() {
                return message;
            }
        }
    }

    /// The plan that comes next within a time, where one does.
    fn plan_within(&mut self, time: Duration) -> Option<v1::Decision> {
        self.socket.get_ref().set_read_timeout(Some(time)).unwrap();
        match self.socket.read() {
            Ok(Message::Binary(data)) if data[0] == 1 => v1::Decision::decode(&data[13..]).ok(),
            _ => None,
        }
    }

    /// A message of a channel, decoded by the schema that was advertised with it.
    fn decoded(&self, topic: &str, payload: &[u8]) -> DynamicMessage {
        let channel = &self.channels[topic];
        assert_eq!(
            (&channel["encoding"], &channel["schemaEncoding"]),
            (&json!("protobuf"), &json!("protobuf"))
        );
        let schema = channel["schema"].as_str().unwrap();
        let schema = STANDARD
            .decode(schema)
            .or_else(|_| STANDARD_NO_PAD.decode(schema));
        let pool = DescriptorPool::decode(schema.unwrap().as_slice()).unwrap();
        let name = channel["schemaName"].as_str().unwrap();
        DynamicMessage::decode(pool.get_message_by_name(name).unwrap(), payload).unwrap()
    }
}

fn decision(step: u64) -> v1::Decision {
    v1::Decision {
        item_id: "a".to_owned(),
        step,
        ..v1::Decision::default()
    }
}

#[test]
fn a_viewer_sees_what_it_looks_at_and_nothing_is_read_for_others() {
    let rig = Rig::new();
    let topics = ["/cell-1/plan", "/cell-1/cloud", "/cell-1/planned_scene"];
    let mut viewer = Viewer::new(&rig, &topics);
    assert!(!rig.plans.has_readers() && !rig.records.has_readers());
    viewer.look_at(&["/cell-1/plan"]);
    until("plans are read", || rig.plans.has_readers());
    assert!(!rig.clouds.has_readers() && !rig.records.has_readers());
    rig.plans.put(&decision(7)).unwrap();
    let (_, payload) = viewer.next();
    assert_eq!(
        v1::Decision::decode(payload.as_slice()).unwrap(),
        decision(7)
    );
    let decoded = viewer.decoded("/cell-1/plan", &payload);
    let step = decoded.get_field_by_name("step").unwrap().as_u64();
    assert_eq!(step, Some(7));
    viewer.look_at(&["/cell-1/plan", "/cell-1/planned_scene"]);
    until("records are read", || rig.records.has_readers());
    drop(viewer);
    until("nothing is read any more", || {
        !rig.plans.has_readers() && !rig.records.has_readers()
    });
    rig.view.finish().unwrap();
}

#[test]
fn a_stream_is_read_to_be_drawn() {
    let rig = Rig::new();
    let mut viewer = Viewer::new(&rig, &["/cell-1/drawn_cloud"]);
    viewer.look_at(&["/cell-1/drawn_cloud"]);
    until("clouds are read", || rig.clouds.has_readers());
    let capture = Capture {
        sequence: 1,
        captured_at_ns: 5,
        state_number: 0,
        container_from_sensor: Isometry3::identity(),
    };
    let cloud = cloud::write(&capture, &[Point3::new(1.0, 2.0, 3.0)]);
    // A message that cannot be drawn is left out.
    rig.clouds.put(&v1::PointCloud::default()).unwrap();
    rig.clouds.put(&cloud).unwrap();
    let (_, payload) = viewer.next();
    let picture = viewer.decoded("/cell-1/drawn_cloud", &payload);
    let drawn = picture.get_field_by_name("data").unwrap();
    assert_eq!(drawn.as_bytes().unwrap().as_ref(), cloud.data);
    rig.view.finish().unwrap();
}

#[test]
fn a_viewer_that_does_not_read_holds_nobody_up() {
    const CLOUDS: usize = 400;
    let rig = Rig::new();
    let topics = ["/cell-1/plan", "/cell-1/cloud"];
    let mut stalled = Viewer::new(&rig, &topics);
    stalled.look_at(&topics);
    until("clouds are read", || rig.clouds.has_readers());
    let mut other = Viewer::new(&rig, &topics);
    other.look_at(&["/cell-1/plan"]);
    until("plans are read", || rig.plans.has_readers());
    // Once a message has come, the other viewer's subscription is known.
    let mut step = 0;
    let mut sees_a_plan = |rig: &Rig, other: &mut Viewer| {
        let first = step + 1;
        until("a plan is seen", || {
            step += 1;
            rig.plans.put(&decision(step)).unwrap();
            let seen = other.plan_within(Duration::from_millis(100));
            seen.is_some_and(|seen| seen.step >= first)
        });
    };
    sees_a_plan(&rig, &mut other);
    let cloud = v1::PointCloud {
        data: vec![7; 1 << 20],
        ..v1::PointCloud::default()
    };
    let mut slowest = Duration::ZERO;
    for _ in 0..CLOUDS {
        let began = Instant::now();
        rig.clouds.put(&cloud).unwrap();
        slowest = slowest.max(began.elapsed());
    }
    // Four hundred megabytes wait for somebody who reads none of them. On their way to the view,
    // messages are dropped as for any reader that does not keep up, plans too, so that not every
    // one comes.
    sees_a_plan(&rig, &mut other);
    assert_eq!(rig.view.viewers(), 2, "the stalled one is still there");
    assert!(slowest < Duration::from_secs(1), "{slowest:?}");
    drop(stalled);
    rig.view.finish().unwrap();
}

#[test]
fn a_viewer_sees_how_the_services_are() {
    let rig = Rig::new();
    let mut viewer = Viewer::new(&rig, &["/all/health"]);
    viewer.look_at(&["/all/health"]);
    let (_, payload) = viewer.next();
    let told = v1::HealthReply::decode(payload.as_slice()).unwrap();
    let instance = told.header.and_then(|header| header.versions).unwrap();
    assert_eq!((told.service.as_str(), told.is_ready), ("planner", true));
    assert_eq!(instance.instance, "planner-1");
    rig.view.finish().unwrap();
}
