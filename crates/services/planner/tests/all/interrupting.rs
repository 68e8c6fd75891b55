//! Nobody waits for a plan that is being made.

use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::thread;

use crate::common::{self, Rig, announcement, block, cell, in_ms};
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
fn a_plan_that_waits_for_minutes_holds_up_nobody() {
    // Perception does not answer, and says when it is asked.
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
        rig.client.call(&cell(), request, in_ms(span_ms))
    };
    thread::scope(|scope| {
        let planned = scope.spawn(|| plan(300_000));
        is_asked.recv().unwrap();
        // Others are answered at once, also those that change what is planned on.
        rig.announce([announcement("b", block())]);
        rig.switch(true);
        let refused = planned.join().unwrap().unwrap_err();
        assert_eq!(refused.status(), Some(Status::Conflict), "{refused}");
        rig.switch(false);
    });
    // One that waits for long lets others by, which are refused in time.
    is_asked.try_iter().count();
    thread::scope(|scope| {
        let planned = scope.spawn(|| plan(300_000));
        is_asked.recv().unwrap();
        let refused = plan(6_000).unwrap_err();
        assert_eq!(refused.status(), Some(Status::Unavailable), "{refused}");
        // One of the session before is refused when another begins.
        rig.call(v1::BeginRequest {
            session_id: "next".to_owned(),
            ..v1::BeginRequest::default()
        });
        let refused = planned.join().unwrap().unwrap_err();
        assert_eq!(refused.status(), Some(Status::Conflict), "{refused}");
    });
}
