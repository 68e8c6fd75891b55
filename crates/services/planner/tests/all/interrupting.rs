//! The automatic mode is switched off at once, whatever plan is being made.

use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::thread;

use crate::common::{self, Rig, cell, in_ms};
use ppnpack_service::rpc::Incoming;
use ppnpack_wire::v1::{self, Status};

#[test]
fn a_plan_that_cannot_be_made_in_time_is_refused_in_time() {
    let kept = Mutex::new(Vec::new());
    let rig = Rig::shown_by(common::coarse(), &[], move |incoming| {
        kept.lock().unwrap().push(incoming);
    });
    rig.begin_with(&["a"]);
    // A caller whose time is over hears nothing.
    rig.plan_unavailable(4_000);
}

#[test]
fn a_plan_that_waits_for_minutes_holds_up_nobody_who_switches_the_automatic_mode_off() {
    // Perception never answers, and says when it is asked.
    let (asked, is_asked) = channel();
    let kept = Mutex::new(Vec::new());
    let heightmap = move |incoming: Incoming<v1::HeightmapRequest>| {
        kept.lock().unwrap().push(incoming);
        asked.send(()).ok();
    };
    let rig = Rig::shown_by(common::coarse(), &[], heightmap);
    rig.begin_with(&["a"]);
    let plan = |span_ms| {
        let request = v1::PlanRequest::default();
        rig.client
            .call(&cell(), request, in_ms(span_ms))
            .unwrap_err()
    };
    thread::scope(|scope| {
        let planned = scope.spawn(|| plan(300_000));
        is_asked.recv().unwrap();
        rig.switch(false);
        let refused = planned.join().unwrap();
        assert_eq!(refused.status(), Some(Status::Unavailable));
        assert!(refused.to_string().contains("switched off"), "{refused}");
    });
    assert!(!rig.session().is_automatic);
    // Plans are made again.
    assert!(!plan(600).to_string().contains("switched off"));
}
