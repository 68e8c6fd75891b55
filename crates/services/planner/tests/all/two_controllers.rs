//! Two controllers that do not know of each other.

use crate::common::{Rig, announce, announcement, block, cell, coarse, soon};
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, Status};

/// A controller that means this session.
struct Controller(Client);

impl Controller {
    fn of(rig: &Rig, session_id: &str) -> Self {
        Self(rig.client.clone().of_session(session_id))
    }

    fn ask<R: Request>(&self, request: R) -> Result<R::Reply, CallError> {
        self.0.call(&cell(), request, soon())
    }

    /// Is refused, as it means another session than this one.
    fn assert_not_meant<R: Request>(&self, request: R, own: &str) {
        let refused = self.ask(request).map(drop).unwrap_err();
        assert_eq!(refused.status(), Some(Status::Conflict), "{refused}");
        let text = format!("session {own} is under way");
        assert!(refused.to_string().contains(&text), "{refused}");
    }
}

fn begin(session_id: &str) -> v1::BeginRequest {
    v1::BeginRequest {
        session_id: session_id.to_owned(),
        ..v1::BeginRequest::default()
    }
}

fn announce_one(item_id: &str) -> v1::AnnounceRequest {
    announce([announcement(item_id, block())])
}

#[test]
fn a_controller_whose_session_another_one_replaced_hears_of_it_and_changes_nothing() {
    let rig = Rig::new(coarse());
    let [first, second] = ["first", "second"].map(|session| Controller::of(&rig, session));
    rig.call(begin("first"));
    first.ask(announce_one("a")).unwrap();
    // Where it has begun already, it may be said again, whatever it was to replace.
    second.ask(begin("first")).unwrap();
    // One that knows of another session before replaces nothing.
    second.assert_not_meant(begin("third"), "first");

    first.ask(begin("second")).unwrap();
    second.ask(announce_one("b")).unwrap();
    let known = rig.session();
    first.assert_not_meant(announce_one("c"), "second");
    let withdraw = v1::WithdrawRequest {
        item_id: "b".to_owned(),
        ..v1::WithdrawRequest::default()
    };
    first.assert_not_meant(withdraw, "second");
    first.assert_not_meant(v1::PlanRequest::default(), "second");
    let automatic = v1::AutomaticRequest {
        is_automatic: true,
        ..v1::AutomaticRequest::default()
    };
    first.assert_not_meant(automatic, "second");
    first.assert_not_meant(v1::SessionRequest::default(), "second");
    assert_eq!(rig.session(), known);
}

#[test]
fn an_on_that_comes_late_switches_on_nothing_that_was_switched_off_after_it() {
    let mut rig = Rig::new(coarse());
    rig.begin();
    let is_on = |rig: &Rig| {
        let on = v1::AutomaticRequest {
            header: Some(v1::RequestHeader {
                request_id: "on".to_owned(),
                ..v1::RequestHeader::default()
            }),
            is_automatic: true,
            ..v1::AutomaticRequest::default()
        };
        rig.call(on).session.unwrap().is_automatic
    };
    assert!(is_on(&rig));
    rig.switch(false);
    assert!(!is_on(&rig), "sent again");
    rig.restart(&[], |_| {});
    assert!(!is_on(&rig), "of before the planner began anew");
    rig.call(begin("next"));
    assert!(!is_on(&rig), "of the session before");
}
