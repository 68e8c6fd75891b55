use nalgebra::Isometry3;
use ppnpack_wire::convert;
use ppnpack_wire::item_id::ItemId;

use super::SessionError::{
    Answered, AsideFull, NoKind, NoSession, NotWaiting, OtherItem, OtherOutcome, Past, Pending,
    PendingBefore, UnknownDecision, UnknownItem,
};
use super::*;
use crate::placing::KnownPose;

pub(super) fn announced(item_id: &str) -> v1::SessionItem {
    v1::SessionItem {
        item_id: item_id.to_owned(),
        object: "mug".to_owned(),
        shape: ItemId::of(&v1::Item::default()).to_bytes(),
        state: ItemState::Waiting.into(),
        ..v1::SessionItem::default()
    }
}

/// The container of a cell that has one.
fn only() -> Vec<v1::SessionContainer> {
    vec![open_container(String::new(), Vec::new(), 0)]
}

/// The last failure.
fn failure(session: &Session) -> Option<&str> {
    session.has_failed().then_some(&session.0.failure)
}

fn session_of(items: &[&str]) -> Session {
    session_with_aside(0, items)
}

/// A session that may set so many items aside.
fn session_with_aside(limit: usize, items: &[&str]) -> Session {
    let mut session = Session::begin("s".to_owned(), only(), false, limit);
    let items = items.iter().map(|item| announced(item));
    session.announce(items.collect()).unwrap();
    session
}

pub(super) fn decision(decision_id: &str, item_id: &str) -> v1::Decision {
    v1::Decision {
        decision_id: decision_id.to_owned(),
        request_id: format!("request-of-{decision_id}"),
        item_id: item_id.to_owned(),
        placement: Some(v1::RestingPlacement::default()),
        container_from_item: Some(convert::pose::write(&Isometry3::identity())),
        ..v1::Decision::default()
    }
}

pub(super) fn outcome(kind: v1::OutcomeKind) -> v1::Outcome {
    v1::Outcome {
        kind: kind.into(),
        state_number: 7,
        ..v1::Outcome::default()
    }
}

fn report(session: &mut Session, decision_id: &str, kind: v1::OutcomeKind) {
    session.report(decision_id, &outcome(kind)).unwrap();
}

fn too_large(item_id: &str) -> v1::ItemReason {
    v1::ItemReason {
        item_id: item_id.to_owned(),
        reason: v1::Reason::TooLarge.into(),
        text: "too large".to_owned(),
    }
}

fn waiting(session: &Session) -> Vec<&str> {
    let waiting = session.buffer(10);
    waiting.map(|item| item.item_id.as_str()).collect()
}

/// Acknowledges a failure.
fn acknowledge(session: &mut Session) {
    let failure_id = session.failure_id().unwrap();
    session.set_automatic(true, &failure_id).unwrap();
}

#[test]
fn nothing_is_done_before_a_session_begins() {
    let mut session = Session::default();
    assert_eq!(session.announce(vec![announced("a")]), Err(NoSession));
    assert_eq!(session.answered("r"), Err(NoSession));
}

#[test]
fn items_wait_in_their_order_and_announcing_them_again_changes_nothing() {
    let mut session = session_of(&["a", "b"]);
    let more = vec![announced("b"), announced("c")];
    session.announce(more).unwrap();
    assert_eq!(waiting(&session), ["a", "b", "c"]);
    // How many poses the cell allows, and how many items an order has, may be otherwise by then.
    let mut same = announced("a");
    same.poses = 3;
    same.order_line = Some(Box::new(v1::OrderLine {
        order_items: 7,
        ..v1::OrderLine::default()
    }));
    session.announce(vec![same]).unwrap();
    assert_eq!(session.items()[0], announced("a"));
    let changes: [fn(&mut v1::SessionItem); 5] = [
        |item| {
            item.rules = Some(v1::ItemRules {
                is_fragile: true,
                ..v1::ItemRules::default()
            });
        },
        |item| item.waits_at = Some(Box::default()),
        |item| item.allowed_poses = vec![0, 2],
        |item| {
            item.order_line = Some(Box::new(v1::OrderLine {
                order: "7".to_owned(),
                ..v1::OrderLine::default()
            }));
        },
        |item| item.shape = vec![7; 32],
    ];
    for change in changes {
        let mut other = announced("a");
        change(&mut other);
        assert_eq!(session.announce(vec![other]), Err(OtherItem("a".into())));
    }
}

#[test]
fn a_decision_awaits_its_outcome_before_the_next_one() {
    let mut session = session_of(&["a", "b"]);
    session.decide(decision("d1", "b")).unwrap();
    assert_eq!(waiting(&session), ["a"]);
    let early = session.decide(decision("d2", "a"));
    assert_eq!(early, Err(Pending("d1".into())));
    assert_eq!(session.answered("another"), Err(Pending("d1".into())));
    let again = session.answered("request-of-d1").unwrap();
    assert_eq!(again.unwrap().decision_id, "d1");

    report(&mut session, "d1", v1::OutcomeKind::Placed);
    assert!(session.pending().is_none());
    assert_eq!(session.least_state_number(""), 7);
    assert_eq!(session.items()[1].state(), ItemState::Packed);
    let again = session.answered("request-of-d1");
    assert_eq!(again, Err(Answered("d1".into())));
}

#[test]
fn an_item_that_was_not_placed_waits_again_and_a_lost_one_is_gone() {
    let mut session = session_of(&["a"]);
    session.decide(decision("d1", "a")).unwrap();
    report(&mut session, "d1", v1::OutcomeKind::NotPlaced);
    assert_eq!(waiting(&session), ["a"]);
    session.decide(decision("d2", "a")).unwrap();
    report(&mut session, "d2", v1::OutcomeKind::Lost);
    assert_eq!(session.items()[0].state(), ItemState::Gone);
}

#[test]
fn where_nobody_knows_where_an_item_is_the_automatic_mode_ends_until_it_is_switched_on_again() {
    for (kind, text) in [
        (v1::OutcomeKind::Lost, "left the cell"),
        (v1::OutcomeKind::Unknown, "may lie anywhere"),
    ] {
        let mut session = session_of(&["a", "b"]);
        session.set_automatic(true, "").unwrap();
        session.decide(decision("d1", "a")).unwrap();
        report(&mut session, "d1", kind);
        let end = failure(&session).unwrap().to_owned();
        assert!(end.contains(text), "{end}");
        report(&mut session, "d1", kind);
        session.announce(vec![announced("c")]).unwrap();
        assert_eq!(failure(&session), Some(end.as_str()));
        acknowledge(&mut session);
        assert!(!session.has_ended());

        // A controller that plans by request decides itself what to do.
        let mut session = session_of(&["a"]);
        session.decide(decision("d1", "a")).unwrap();
        report(&mut session, "d1", kind);
        assert!(!session.has_ended());
    }
    let mut session = session_of(&["a"]);
    session.set_automatic(true, "").unwrap();
    session.decide(decision("d1", "a")).unwrap();
    report(&mut session, "d1", v1::OutcomeKind::NotPlaced);
    assert!(!session.has_ended());
}

#[test]
fn a_session_is_put_away_once_and_no_pending_decision_with_it_unasked() {
    let next = |id: &str| Session::begin(id.to_owned(), only(), false, 0);
    let mut session = session_of(&["a"]);
    session.decide(decision("d1", "a")).unwrap();
    let refused = session.followed_by(next("t"), false);
    assert_eq!(refused, Err(PendingBefore("d1".into())));
    let second = session.followed_by(next("t"), true).unwrap();
    assert_eq!((second.id(), second.pending()), ("t", None));
    report(&mut session, "d1", v1::OutcomeKind::Placed);
    assert_eq!(session.followed_by(next("t"), false), Ok(second.clone()));
    // A request for the first one comes late.
    assert_eq!(second.followed_by(next("s"), true), Err(Past("s".into())));
    let mut last = second;
    for number in 0..PAST_KEPT {
        last = last.followed_by(next(&number.to_string()), false).unwrap();
        assert!(last.0.past_session_ids.len() <= PAST_KEPT);
    }
    assert!(last.followed_by(next("s"), false).is_ok());
    assert!(last.followed_by(next("0"), false).is_err());
}

#[test]
fn a_restored_session_has_failed_and_one_that_never_began_has_not() {
    let mut session = session_of(&["a"]);
    session.set_automatic(true, "").unwrap();
    session.restored(FROM_BACKUP);
    assert_eq!(failure(&session), Some(FROM_BACKUP));
    // A decision that was pending then may have been carried out, or its item by a later one.
    let mut session = session_of(&["a", "b"]);
    session.decide(decision("d1", "a")).unwrap();
    session.restored(FROM_BACKUP);
    assert_eq!(session.pending(), None);
    assert_eq!(session.items()[0].state(), ItemState::Gone);
    let placed = session.report("d1", &outcome(v1::OutcomeKind::Placed));
    assert_eq!(placed, Err(OtherOutcome("d1".to_owned())));
    let mut none = Session::default();
    none.restored(FROM_BACKUP);
    assert_eq!(none, Session::default());
}

#[test]
fn an_outcome_can_be_reported_twice_but_not_changed() {
    let mut session = session_of(&["a"]);
    session.decide(decision("d1", "a")).unwrap();
    let before = session.clone();
    let unclear = session.report("d1", &outcome(v1::OutcomeKind::Unspecified));
    assert_eq!(unclear, Err(NoKind));
    assert_eq!(session, before);
    report(&mut session, "d1", v1::OutcomeKind::Placed);
    let reported = session.clone();
    report(&mut session, "d1", v1::OutcomeKind::Placed);
    assert_eq!(session, reported);
    let lost = outcome(v1::OutcomeKind::Lost);
    assert_eq!(session.report("d1", &lost), Err(OtherOutcome("d1".into())));
    let unknown = session.report("d9", &lost);
    assert_eq!(unknown, Err(UnknownDecision("d9".into())));
}

#[test]
fn only_waiting_items_are_withdrawn() {
    let mut session = session_of(&["a", "b"]);
    session.decide(decision("d1", "a")).unwrap();
    assert_eq!(session.withdraw("a"), Err(NotWaiting("a".into())));
    session.withdraw("b").unwrap();
    session.withdraw("b").unwrap();
    assert!(waiting(&session).is_empty());
}

#[test]
fn a_session_is_read_as_it_was_written() {
    let mut items = ["a", "b", "c", "d", "e"].map(announced);
    let turned = Isometry3::rotation(nalgebra::Vector3::x());
    items[0].heightmap_from_item = Some(convert::pose::write(&turned));
    items[0].poses = 3;
    items[1].allowed_poses = vec![0, 2];
    let mut session = Session::begin("s".to_owned(), only(), false, 1);
    session.announce(items.into()).unwrap();
    let in_a_pose = v1::Decision {
        pose: 2,
        ..decision("d1", "a")
    };
    session.decide(in_a_pose).unwrap();
    report(&mut session, "d1", v1::OutcomeKind::Placed);
    session.withdraw("d").unwrap();
    session.set_aside(too_large("e")).unwrap();
    session.decide(decision("d2", "b")).unwrap();
    session.end(End::Failed("arm stuck".into()));
    let message = session.to_message(5);
    let states = message.items.iter().map(v1::SessionItem::state);
    use v1::ItemState::{Decided, Packed, SetAside, Waiting, Withdrawn};
    let expected = [Packed, Decided, Waiting, Withdrawn, SetAside];
    assert_eq!(states.collect::<Vec<_>>(), expected);
    assert_eq!(Session::from_message(message), Ok(session.clone()));
    session.end(End::NothingFits(vec![too_large("c")]));
    assert_eq!(Session::from_message(session.to_message(5)), Ok(session));
}

#[test]
fn only_waiting_items_are_set_aside() {
    let mut session = session_with_aside(9, &["a", "b", "c"]);
    session.decide(decision("d1", "a")).unwrap();
    session.withdraw("b").unwrap();
    session.set_aside(too_large("c")).unwrap();
    let before = session.clone();
    for item in ["a", "b", "c"] {
        let refused = session.set_aside(too_large(item));
        assert_eq!(refused, Err(NotWaiting(item.into())));
    }
    let none = session_of(&["a"]).set_aside(too_large("a"));
    assert_eq!(none, Err(AsideFull(0)));
    let unknown = session.set_aside(too_large("x"));
    assert_eq!(unknown, Err(UnknownItem("x".into())));
    assert_eq!(session.waiting("c"), Err(NotWaiting("c".into())));
    assert_eq!(session, before);
}

#[test]
fn a_session_ends_with_everything_packed_or_the_others_set_aside() {
    let mut session = session_with_aside(1, &["a", "b"]);
    session.decide(decision("d1", "a")).unwrap();
    report(&mut session, "d1", v1::OutcomeKind::Placed);
    assert_eq!(session.end_of_items(), End::AllPacked);
    session.set_aside(too_large("b")).unwrap();
    assert_eq!(session.end_of_items(), End::OthersSetAside);
    session.end(End::OthersSetAside);
    let message = session.to_message(5);
    assert_eq!(message.end(), v1::SessionEnd::OthersSetAside);
    assert_eq!(message.set_aside, [too_large("b")]);
    assert_eq!(message.set_aside_limit, 1);
    let b = &message.items[1];
    assert_eq!((&b.set_aside, b.set_aside_step), (&Some(too_large("b")), 1));
    assert_eq!(Session::from_message(message), Ok(session.clone()));
    // Who announces it again has it tried again.
    session.announce(vec![announced("b")]).unwrap();
    assert!(!session.has_ended());
}

#[test]
fn the_last_decisions_are_remembered_and_no_more() {
    let mut session = session_of(&["a"]);
    for step in 0..SETTLED_KEPT + 5 {
        let id = format!("d{step}");
        session.decide(decision(&id, "a")).unwrap();
        report(&mut session, &id, v1::OutcomeKind::NotPlaced);
    }
    assert_eq!(session.0.settled.len(), SETTLED_KEPT);
    assert_eq!(session.step(), SETTLED_KEPT as u64 + 5);
}

#[test]
fn the_mean_cycle_time_is_that_of_the_packed_items() {
    let mut session = session_of(&["a", "b", "c"]);
    for (id, item, cycle_s, kind) in [
        ("d1", "a", 2.0, v1::OutcomeKind::Placed),
        ("d2", "b", 9.0, v1::OutcomeKind::Lost),
        ("d3", "c", 3.0, v1::OutcomeKind::Placed),
    ] {
        let mut decision = decision(id, item);
        decision.cycle = Some(Box::new(v1::ArmCycle {
            cycle_s,
            ..v1::ArmCycle::default()
        }));
        session.decide(decision).unwrap();
        report(&mut session, id, kind);
    }
    let message = session.to_message(5);
    assert_eq!(message.mean_cycle_s, 2.5);
    let times_s: Vec<f64> = message.items.iter().map(|item| item.cycle_s).collect();
    assert_eq!(times_s, [2.0, 0.0, 3.0]);
    assert_eq!(Session::from_message(message), Ok(session));
}

#[test]
fn where_an_item_is_was_found_or_is_assumed_over_restarts_too() {
    let there = Isometry3::translation(0.1, 0.2, 0.03);
    let told = |pose: Option<&Isometry3<f64>>, is_found| {
        let mut session = session_of(&["a"]);
        session.decide(decision("d", "a")).unwrap();
        let outcome = v1::Outcome {
            container_from_item: pose.map(convert::pose::write),
            is_found,
            ..outcome(v1::OutcomeKind::Placed)
        };
        session.report("d", &outcome).unwrap();
        let again = Session::from_message(session.to_message(5)).unwrap();
        assert_eq!(again, session);
        let packed = Packed::read(&again.items()[0]).unwrap();
        packed.unwrap().container_from_item
    };
    assert_eq!(told(Some(&there), true), KnownPose::Found(there));
    // As bridges and controllers do that do not look, and older ones that do not say.
    assert_eq!(told(Some(&there), false), KnownPose::Assumed(there));
    let planned = KnownPose::Assumed(Isometry3::identity());
    assert_eq!(told(None, true), planned);
}

#[test]
fn an_inspection_corrects_where_a_packed_item_is_or_that_it_is_gone() {
    let mut session = session_of(&["a", "b", "c"]);
    for (id, item) in [("d1", "a"), ("d2", "b")] {
        session.decide(decision(id, item)).unwrap();
        report(&mut session, id, v1::OutcomeKind::Placed);
    }
    let found = Isometry3::translation(0.1, 0.2, 0.03);
    let moved = v1::Inspection {
        kind: v1::InspectionKind::Moved.into(),
        container_from_item: Some(convert::pose::write(&found)),
        ..v1::Inspection::default()
    };
    let missing = v1::Inspection {
        kind: v1::InspectionKind::Missing.into(),
        reason: "nothing is new".to_owned(),
        ..v1::Inspection::default()
    };
    assert_eq!(session.inspected("a", moved.clone()), Ok(true));
    assert_eq!(session.inspected("b", missing.clone()), Ok(true));
    // What was not packed cannot have been found.
    assert_eq!(session.inspected("c", missing.clone()), Ok(false));
    assert!(session.inspected("d", missing.clone()).is_err());
    let [a, b, c] = session.items() else {
        panic!("three items");
    };
    let at = Packed::read(a).unwrap().unwrap().container_from_item;
    assert_eq!(at, KnownPose::Found(found));
    assert_eq!(a.inspection, Some(moved));
    assert_eq!(
        (b.state(), &b.inspection),
        (ItemState::Gone, &Some(missing))
    );
    assert_eq!((c.state(), &c.inspection), (ItemState::Waiting, &None));
    let message = session.to_message(5);
    assert_eq!(Session::from_message(message), Ok(session));
}

#[test]
fn a_failure_stays_whatever_is_announced_or_withdrawn_until_the_automatic_mode_is_switched_on() {
    let mut session = session_of(&["a", "b"]);
    session.end(End::Failed("item c was placed, but is missing".into()));
    type Step = fn(&mut Session) -> Result<(), SessionError>;
    let steps: [Step; 5] = [
        |session| session.announce(vec![announced("a")]),
        |session| session.announce(vec![announced("d")]),
        |session| session.withdraw("b"),
        |session| session.decide(decision("d1", "a")),
        |session| session.set_automatic(false, ""),
    ];
    for step in steps {
        step(&mut session).unwrap();
        assert!(session.has_ended());
    }
    acknowledge(&mut session);
    assert!(!session.has_ended());
}

#[test]
fn a_failure_is_acknowledged_by_its_name_alone() {
    let fail = |session: &mut Session| {
        session.end(End::Failed("the bridge refuses the placement".into()));
        session.failure_id().unwrap()
    };
    let mut session = session_of(&["a"]);
    let first = fail(&mut session);
    let failed = session.clone();
    for other in ["", "s-9"] {
        let refused = session.set_automatic(true, other).unwrap_err();
        assert!(
            refused.to_string().contains("the bridge refuses"),
            "{refused}"
        );
        assert_eq!(session, failed);
    }
    session.set_automatic(true, &first).unwrap();
    // Once more, nothing changes.
    session.set_automatic(true, &first).unwrap();
    assert_eq!((session.has_ended(), session.failure_id()), (false, None));
    // It fails in the same words, and the request comes once more.
    let second = fail(&mut session);
    assert!(session.set_automatic(true, &first).is_err());
    session.set_automatic(true, &second).unwrap();
    // So it is in the next session, and in one that was restored.
    let next = Session::begin("t".to_owned(), only(), true, 0);
    let mut next = session.followed_by(next, false).unwrap();
    let third = fail(&mut next);
    next.restored(FROM_BACKUP);
    let message = next.to_message(0);
    assert_eq!(message.failure_id, next.failure_id().unwrap());
    assert_eq!(Session::from_message(message).unwrap(), next);
    for past in [first, second, third] {
        assert!(next.set_automatic(true, &past).is_err(), "{past}");
    }
}
