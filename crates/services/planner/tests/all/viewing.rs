//! A planner that serves viewers itself.

use std::collections::{BTreeMap, BTreeSet};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use crate::common::rig::Rig;
use crate::common::soon;
use ppnpack_wire::v1;
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Error, Message, WebSocket};

/// What is looked at: the decisions, and the scene that is drawn of the records, which a planner makes for readers alone.
const TOPICS: [&str; 2] = ["/cell-1/plan", "/cell-1/planned_scene"];

/// How long a step may take to be seen before the next one is planned.
const PAUSE: Duration = Duration::from_millis(200);

/// A viewer of these topics, each by its number among them.
fn look(address: SocketAddr, topics: &[&str]) -> WebSocket<TcpStream> {
    let stream = TcpStream::connect(address).unwrap();
    let mut request = format!("ws://{address}").into_client_request().unwrap();
    let protocol = "foxglove.sdk.v1".parse().unwrap();
    request
        .headers_mut()
        .insert("sec-websocket-protocol", protocol);
    let (mut socket, _) = tungstenite::client(request, stream).unwrap();
    let mut channels: BTreeMap<String, Value> = BTreeMap::new();
    while !topics.iter().all(|topic| channels.contains_key(*topic)) {
        if let Message::Text(text) = socket.read().unwrap() {
            let said: Value = serde_json::from_str(&text).unwrap();
            for channel in said["channels"].as_array().into_iter().flatten() {
                let topic = channel["topic"].as_str().unwrap().to_owned();
                channels.insert(topic, channel["id"].clone());
            }
        }
    }
    let subscriptions = topics.iter().enumerate();
    let subscriptions =
        subscriptions.map(|(id, topic)| json!({"id": id, "channelId": channels[*topic]}));
    let subscriptions: Vec<Value> = subscriptions.collect();
    let message = json!({"op": "subscribe", "subscriptions": subscriptions});
    socket.send(Message::text(message.to_string())).unwrap();
    socket
}

/// The numbers of the subscriptions of which something comes within a pause.
fn seen(socket: &mut WebSocket<TcpStream>) -> BTreeSet<u32> {
    socket.get_ref().set_read_timeout(Some(PAUSE)).unwrap();
    let mut seen = BTreeSet::new();
    loop {
        match socket.read() {
            Ok(Message::Binary(data)) if data[0] == 1 => {
                seen.insert(u32::from_le_bytes(data[1..5].try_into().unwrap()));
            }
            Ok(_) => {}
            Err(Error::Io(_)) => return seen,
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn a_planner_shows_its_own_steps_to_viewers() {
    let address = "127.0.0.1:0".parse().unwrap();
    let rig = Rig::viewed_at(Some(address), None, crate::common::coarse());
    rig.announce(&["a"]);
    let mut socket = look(rig.view_address().unwrap(), &TOPICS);
    let mut all_seen = BTreeSet::new();
    let deadline = soon();
    while all_seen.len() < TOPICS.len() {
        assert!(std::time::Instant::now() < deadline, "{all_seen:?}");
        rig.call(v1::PlanRequest::default());
        all_seen.extend(seen(&mut socket));
    }
    // Viewers keep nobody from ending.
    rig.finish();
}

#[test]
fn a_planner_that_is_not_told_to_serves_no_viewers() {
    let rig = Rig::new(None, crate::common::coarse());
    assert_eq!(rig.view_address(), None);
    rig.finish();
}
