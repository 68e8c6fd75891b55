//! Two controllers that do not know of each other.

use crate::common::{self, announcement, block, cell, soon};
use ppnpack_service::embedded;
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::v1::{self, Status};

fn begin(session_id: &str) -> v1::BeginRequest {
    v1::BeginRequest {
        session_id: session_id.to_owned(),
        ..v1::BeginRequest::default()
    }
}

fn announce(item_id: &str) -> v1::AnnounceRequest {
    v1::AnnounceRequest {
        items: vec![announcement(item_id, block())],
        ..v1::AnnounceRequest::default()
    }
}

/// Refused as it is meant for another session than this one.
fn assert_not_meant<T: std::fmt::Debug>(answer: Result<T, CallError>, own: &str) {
    let refused = answer.unwrap_err();
    assert_eq!(refused.status(), Some(Status::Conflict), "{refused}");
    let text = format!("session {own} is under way");
    assert!(refused.to_string().contains(&text), "{refused}");
}

#[test]
fn a_controller_whose_session_another_one_replaced_hears_of_it_and_changes_nothing() {
    let hub = embedded::hub().unwrap();
    let settings = common::settings(crate::common::coarse());
    let _planner = common::start(&hub, &settings, &[]);
    let session = embedded::session(&hub).unwrap();
    let (anybody, first, second) = (
        Client::new(&session),
        Client::new(&session).of_session("first"),
        Client::new(&session).of_session("second"),
    );
    anybody.call(&cell(), begin("first"), soon()).unwrap();
    first.call(&cell(), announce("a"), soon()).unwrap();
    // Where it has begun already, it may be said again, whatever it was to replace.
    second.call(&cell(), begin("first"), soon()).unwrap();
    // One that knows of another session before replaces nothing.
    assert_not_meant(second.call(&cell(), begin("third"), soon()), "first");

    first.call(&cell(), begin("second"), soon()).unwrap();
    second.call(&cell(), announce("b"), soon()).unwrap();
    let known = anybody.call(&cell(), v1::SessionRequest::default(), soon());
    let known = known.unwrap().session;
    let withdraw = v1::WithdrawRequest {
        item_id: "b".to_owned(),
        ..v1::WithdrawRequest::default()
    };
    assert_not_meant(first.call(&cell(), announce("c"), soon()), "second");
    assert_not_meant(first.call(&cell(), withdraw, soon()), "second");
    let plan = v1::PlanRequest::default();
    assert_not_meant(first.call(&cell(), plan, soon()), "second");
    let automatic = v1::AutomaticRequest {
        is_automatic: true,
        ..v1::AutomaticRequest::default()
    };
    assert_not_meant(first.call(&cell(), automatic, soon()), "second");
    let asked = first.call(&cell(), v1::SessionRequest::default(), soon());
    assert_not_meant(asked, "second");
    let again = second.call(&cell(), v1::SessionRequest::default(), soon());
    assert_eq!(again.unwrap().session, known);
}

#[test]
fn a_session_that_is_meant_has_a_possible_name() {
    let hub = embedded::hub().unwrap();
    let settings = common::settings(crate::common::coarse());
    let _planner = common::start(&hub, &settings, &[]);
    let session = embedded::session(&hub).unwrap();
    let odd = Client::new(&session).of_session("no name");
    let refused = odd.call(&cell(), announce("a"), soon()).unwrap_err();
    assert_eq!(refused.status(), Some(Status::Invalid), "{refused}");
    assert!(
        refused.to_string().contains("header.session_id"),
        "{refused}"
    );
}
