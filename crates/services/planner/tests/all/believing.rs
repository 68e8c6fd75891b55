//! What a bridge or a controller says that cannot be is not believed.

use ppnpack_service::rpc::Incoming;
use ppnpack_wire::v1::{self, SessionEnd, Status};

use crate::common::{self, Rig, announcement, block, carried_out, ended, placed};

/// A change of an outcome, and what is said of it.
type Lie = (fn(&mut v1::Outcome), &'static str);

fn position(outcome: &mut v1::Outcome) -> &mut v1::Vector3 {
    let pose = outcome.container_from_item.as_mut().unwrap();
    pose.position.as_mut().unwrap()
}

const LIES: [Lie; 8] = [
    (|it| it.placement_id = "another".to_owned(), "placement_id"),
    (|it| it.item_id = "another".to_owned(), "item_id"),
    (|it| it.slide_m = f64::NAN, "slide_m"),
    (|it| position(it).x_m = f64::NAN, "container_from_item"),
    (|it| position(it).x_m += 1.0, "m from where"),
    (|it| position(it).y_m = 900_000.0, "m from where"),
    (
        |it| {
            let pose = it.container_from_item.as_mut().unwrap();
            pose.orientation.as_mut().unwrap().w = 5.0;
        },
        "container_from_item",
    ),
    // A bridge that forgets to count up.
    (|it| it.state_number -= 1, "state_number"),
];

#[test]
fn a_report_that_cannot_be_is_refused() {
    let rig = Rig::new(common::untried());
    rig.begin_with(&["a"]);
    let decision = rig.decision();
    let before = rig.session();
    for (lie, named) in LIES {
        let mut report = placed(&decision, decision.state_number + 1);
        lie(report.outcome.as_mut().unwrap());
        let refused = rig.ask(report).unwrap_err();
        let expected = [Some(Status::Invalid), Some(Status::Conflict)];
        assert!(expected.contains(&refused.status()), "{refused}");
        assert!(refused.to_string().contains(named), "{refused}");
        assert_eq!(rig.session(), before);
    }
    rig.call(placed(&decision, decision.state_number + 1));
}

#[test]
fn a_bridge_that_says_what_cannot_be_ends_the_automatic_mode() {
    for (lie, named) in LIES {
        let mut rig = Rig::new(common::untried());
        rig.bridge_answers(move |incoming: &Incoming<v1::PlaceRequest>| {
            let request = incoming.message();
            let mut outcome = carried_out(request);
            lie(&mut outcome);
            Some(ended(request, outcome))
        });
        rig.begin();
        let automatic = v1::AutomaticRequest {
            header: Some(v1::RequestHeader {
                request_id: "on".to_owned(),
                ..v1::RequestHeader::default()
            }),
            is_automatic: true,
            ..v1::AutomaticRequest::default()
        };
        rig.call(automatic.clone());
        rig.announce([announcement("a", block())]);
        let session = rig.ended();
        assert_eq!(session.end(), SessionEnd::Failed);
        assert!(session.failure.contains(named), "{}", session.failure);
        // The request that switched it on, once more: nobody has looked.
        let again = rig.call(automatic).session.unwrap();
        assert_eq!(again.end(), SessionEnd::Failed);
        let unseen = v1::AutomaticRequest {
            is_automatic: true,
            failure_id: format!("{}-9", session.session_id),
            ..v1::AutomaticRequest::default()
        };
        rig.assert_refused(unseen, Status::Stale, named);
    }
}
