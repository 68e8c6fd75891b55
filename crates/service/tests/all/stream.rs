//! Data and liveliness between two sessions on a hub.

use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use ppnpack_service::alive::{self, Alive};
use ppnpack_service::embedded::{self, hub};
use ppnpack_service::stream::{Latest, Publisher, subscribe};
use ppnpack_wire::keys::{Cell, Instance, Service, Stream};
use ppnpack_wire::{MAX_CLOUD_BYTES, MAX_MESSAGE_BYTES, v1};
use zenoh::Wait;

fn cell() -> Cell {
    Cell::new("c1").unwrap()
}

fn soon() -> Instant {
    Instant::now() + Duration::from_secs(20)
}

fn at(step: u64) -> v1::Session {
    v1::Session {
        step,
        ..v1::Session::default()
    }
}

/// Publishes a step until a reader of all steps has it: a publisher never waits, so what the
/// network cannot take at once is dropped.
fn deliver(publisher: &Publisher<v1::Session>, all: &Receiver<u64>, step: u64) {
    let deadline = soon();
    while Instant::now() < deadline {
        publisher.put(&at(step)).unwrap();
        while let Ok(seen) = all.recv_timeout(Duration::from_millis(50)) {
            if seen == step {
                return;
            }
        }
    }
    panic!("step {step} never came");
}

#[test]
fn a_reader_of_the_latest_sees_no_older_ones() {
    let hub = hub().unwrap();
    let writer = embedded::process(&hub, Service::Planner, "w").unwrap();
    let reader = embedded::process(&hub, Service::Planner, "r").unwrap();
    let stream = Stream::Session;
    let latest: Latest<v1::Session> =
        Latest::subscribe(&reader, &cell(), stream, MAX_MESSAGE_BYTES).unwrap();
    let (sender, all) = sync_channel(1000);
    let on_message = move |cell: Cell, session: v1::Session| {
        assert_eq!(cell.as_str(), "c1");
        sender.try_send(session.step).ok();
    };
    let session = reader.session();
    let _subscription = subscribe(session, None, stream, MAX_MESSAGE_BYTES, on_message).unwrap();
    let publisher = Publisher::new(&writer, &cell(), stream).unwrap();
    // The first ones may come before the subscriptions are known.
    deliver(&publisher, &all, 0);
    for step in 1..=20 {
        publisher.put(&at(step)).unwrap();
    }
    deliver(&publisher, &all, 21);
    let mut taken = Vec::new();
    while taken.last() != Some(&21) {
        taken.push(latest.wait(soon()).unwrap().message.unwrap().step);
    }
    // The reader of all may have had the last one before the reader of the latest.
    assert!(taken.len() <= 2, "{taken:?}");
    // Where the last one had to be published again, it comes again; nothing else does.
    while let Some(again) = latest.wait(Instant::now() + Duration::from_millis(50)) {
        assert_eq!(again.message.unwrap().step, 21);
    }
    assert!(latest.take().is_none());

    // What is malformed or too large is an error for one, and nothing for the other.
    let key = "ppnpack/v1/c1/session";
    let malformed = loop {
        writer.session().put(key, b"\xff\xff").wait().unwrap();
        if let Some(read) = latest.wait(Instant::now() + Duration::from_millis(50)) {
            break read.message;
        }
    };
    assert!(malformed.is_err());
    let small: Latest<v1::Session> = Latest::subscribe(&reader, &cell(), stream, 1).unwrap();
    deliver(&publisher, &all, 22);
    loop {
        if let Some(read) = small.wait(Instant::now() + Duration::from_millis(50)) {
            assert!(read.message.is_err());
            break;
        }
        publisher.put(&at(23)).unwrap();
    }
}

#[test]
fn what_is_too_large_for_others_is_not_published() {
    let hub = hub().unwrap();
    let writer = embedded::process(&hub, Service::Bridge, "w").unwrap();
    let publisher = Publisher::new(&writer, &cell(), Stream::Cloud).unwrap();
    let cloud = |bytes| v1::PointCloud {
        data: vec![0; bytes],
        ..v1::PointCloud::default()
    };
    publisher.put(&cloud(MAX_MESSAGE_BYTES)).unwrap();
    let refused = publisher.put(&cloud(MAX_CLOUD_BYTES + (1 << 20)));
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("zenoh.max_message_bytes"), "{refused}");
}

#[test]
fn who_is_alive_is_seen_to_come_and_go() {
    let hub = hub().unwrap();
    let watcher = embedded::session(&hub).unwrap();
    let early = embedded::process(&hub, Service::Heuristic, "h1").unwrap();
    let late = embedded::process(&hub, Service::Heuristic, "h2").unwrap();
    let other = embedded::process(&hub, Service::Ppn, "p1").unwrap();
    let names = |names: &[&str]| -> Vec<Instance> {
        let names = names.iter().map(|name| Instance::new(name).unwrap());
        names.collect()
    };
    let _first = alive::announce(&early, None).unwrap();
    let _other = alive::announce(&other, None).unwrap();
    let alive = Alive::watch(&watcher, Service::Heuristic).unwrap();
    assert!(alive.wait(soon(), |now| now == names(&["h1"])));
    let second = [
        alive::announce(&late, Some(&cell())).unwrap(),
        alive::announce(&late, Some(&Cell::new("c2").unwrap())).unwrap(),
    ];
    assert!(alive.wait(soon(), |now| now == names(&["h1", "h2"])));
    drop(second);
    assert!(alive.wait(soon(), |now| now == names(&["h1"])));
    // A session that is gone takes its tokens along.
    early.session().close().wait().unwrap();
    assert!(alive.wait(soon(), <[Instance]>::is_empty));
    assert!(!alive.wait(Instant::now(), |now| !now.is_empty()));
}
