//! The automatic mode is switched off at once, whatever plan is being made.

use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{self, announcement, block, cell, soon};
use ppnpack_service::embedded;
use ppnpack_service::rpc::{self, Client, Incoming};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, Status};

#[test]
fn a_plan_that_waits_for_minutes_holds_up_nobody_who_switches_the_automatic_mode_off() {
    let hub = embedded::hub().unwrap();
    let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
    // It never answers, and says when it is asked.
    let (asked, is_asked) = channel();
    let kept = Mutex::new(Vec::new());
    let heightmap = move |incoming: Incoming<v1::HeightmapRequest>| {
        kept.lock().unwrap().push(incoming);
        asked.send(()).ok();
    };
    let _perception = rpc::listen(&perception, None, heightmap).unwrap();
    let settings = common::settings(crate::common::coarse());
    let _planner = common::start(&hub, &settings, &[]);
    let client = Client::new(&embedded::session(&hub).unwrap());
    common::begin(&client);
    let announce = v1::AnnounceRequest {
        items: vec![announcement("a", block())],
        ..v1::AnnounceRequest::default()
    };
    client.call(&cell(), announce, soon()).unwrap();

    thread::scope(|scope| {
        let planned = scope.spawn(|| {
            let deadline = Instant::now() + Duration::from_secs(300);
            client.call(&cell(), v1::PlanRequest::default(), deadline)
        });
        is_asked.recv().unwrap();
        let off = client.call(&cell(), v1::AutomaticRequest::default(), soon());
        assert!(!off.unwrap().session.unwrap().is_automatic);
        let refused = planned.join().unwrap().unwrap_err();
        assert_eq!(refused.status(), Some(Status::Unavailable));
        assert!(refused.to_string().contains("switched off"), "{refused}");
    });
    // Plans are made again.
    let deadline = Instant::now() + Duration::from_millis(600);
    let late = client.call(&cell(), v1::PlanRequest::default(), deadline);
    assert!(!late.unwrap_err().to_string().contains("switched off"));
}
