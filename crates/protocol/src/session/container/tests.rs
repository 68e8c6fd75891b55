use super::super::tests::{announced, decision, outcome};
use super::super::{End, Session, SessionError};
use super::*;
use ppnpack_wire::v1::{self, OutcomeKind};

fn start(name: &str, sequence: u64, least_state_number: u64) -> v1::SessionContainer {
    v1::SessionContainer {
        sequence,
        ..open_container(name.to_owned(), Vec::new(), least_state_number)
    }
}

/// A session over two open containers.
fn over_two(items: &[&str]) -> Session {
    let containers = vec![start("left", 0, 10), start("right", 0, 500)];
    let mut session = Session::begin("s".to_owned(), containers, true, 5);
    let items = items.iter().map(|item| announced(item));
    session.announce(items.collect()).unwrap();
    session
}

/// Packs an item into a container; `state_number` is that after it.
fn pack(session: &mut Session, item_id: &str, container: &str, state_number: u64) {
    let decision = v1::Decision {
        container: container.to_owned(),
        ..decision(item_id, item_id)
    };
    session.decide(decision).unwrap();
    let placed = v1::Outcome {
        state_number,
        ..outcome(OutcomeKind::Placed)
    };
    session.report(item_id, &placed).unwrap();
}

fn lying_in(session: &Session, container: &str) -> Vec<String> {
    let items = session.packed_in(container);
    items.map(|item| item.item_id.clone()).collect()
}

fn close(session: &mut Session, name: &str, sequence: u64) -> Result<(), SessionError> {
    session.close(closing(name, sequence), None)
}

/// A closing that says nothing yet of how many items there are.
fn closing(name: &str, sequence: u64) -> v1::ClosedContainer {
    v1::ClosedContainer {
        container: name.to_owned(),
        sequence,
        reason: v1::ClosingReason::NothingFits.into(),
        ..v1::ClosedContainer::default()
    }
}

#[test]
fn each_container_has_its_own_items_and_its_own_states() {
    let mut session = over_two(&["a", "b", "c"]);
    pack(&mut session, "a", "left", 11);
    pack(&mut session, "b", "right", 501);
    assert_eq!(lying_in(&session, "left"), ["a"]);
    assert_eq!(lying_in(&session, "right"), ["b"]);
    assert_eq!(session.least_state_number("left"), 11);
    assert_eq!(session.least_state_number("right"), 501);
    session.needs_state("left", Some(20));
    session.needs_state("right", Some(20));
    assert_eq!(session.least_state_number("left"), 20);
    assert_eq!(session.least_state_number("right"), 501);
    let unknown = SessionError::UnknownContainer("middle".to_owned());
    assert_eq!(session.container("middle").unwrap_err(), unknown);
}

#[test]
fn a_container_is_closed_and_opened_once_however_often_it_is_asked_for() {
    let mut session = over_two(&["a", "b"]);
    pack(&mut session, "a", "left", 11);
    close(&mut session, "left", 0).unwrap();
    assert!(lying_in(&session, "left").is_empty());
    assert!(!session.container("left").unwrap().is_open);
    let before = session.clone();
    close(&mut session, "left", 0).unwrap();
    assert_eq!(session, before);
    // The one before is not there any more, and the one after the next not yet.
    for other in [0, 2] {
        let refused = session.open(start("left", other, 12));
        assert!(matches!(
            refused,
            Err(SessionError::OtherContainer { known: 1, .. })
        ));
    }
    // All that was done in it is seen in no state before.
    let mut early = session.clone();
    early.open(start("left", 1, 3)).unwrap();
    assert_eq!(early.least_state_number("left"), 11);
    session.open(start("left", 1, 12)).unwrap();
    let opened = session.clone();
    session.open(start("left", 1, 12)).unwrap();
    close(&mut session, "left", 0).unwrap();
    assert_eq!(session, opened);
    assert_eq!(session.least_state_number("left"), 12);
    let closed = v1::ClosedContainer {
        items: 1,
        ..closing("left", 0)
    };
    assert_eq!(session.closed(), [closed]);
    pack(&mut session, "b", "left", 13);
    assert_eq!(lying_in(&session, "left"), ["b"]);
}

#[test]
fn a_container_stays_open_while_something_is_on_its_way_into_it() {
    let mut session = over_two(&["a"]);
    let into_left = v1::Decision {
        container: "left".to_owned(),
        ..decision("d", "a")
    };
    session.decide(into_left).unwrap();
    let pending = SessionError::Pending("d".to_owned());
    assert_eq!(close(&mut session, "left", 0), Err(pending));
    assert_eq!(close(&mut session, "right", 0), Ok(()));
    let next = close(&mut session, "right", 1);
    assert!(matches!(
        next,
        Err(SessionError::OtherContainer { is_open: false, .. })
    ));
}

#[test]
fn what_is_set_aside_waits_again_for_the_next_container() {
    let mut session = over_two(&["a", "b"]);
    let reason = v1::ItemReason {
        item_id: "a".to_owned(),
        ..v1::ItemReason::default()
    };
    session.set_aside(reason).unwrap();
    close(&mut session, "left", 0).unwrap();
    session.end(End::OthersSetAside);
    session.open(start("left", 1, 12)).unwrap();
    assert_eq!(session.waiting("a").unwrap().item_id, "a");
    assert!(!session.has_ended());
}

#[test]
fn a_session_outlives_its_containers_and_forgets_what_left_first() {
    let mut session = over_two(&[]);
    let containers = 12;
    let items_each = 100;
    for sequence in 0..containers {
        for number in 0..items_each {
            let item = format!("i{sequence}-{number}");
            session.announce(vec![announced(&item)]).unwrap();
            pack(&mut session, &item, "left", 11 + sequence);
        }
        close(&mut session, "left", sequence).unwrap();
        session.open(start("left", sequence + 1, 0)).unwrap();
    }
    assert_eq!(session.items().len(), LEFT_KEPT);
    // A late repetition of an announcement that is remembered changes nothing.
    session.announce(vec![announced("i11-99")]).unwrap();
    assert_eq!(session.buffer(10).count(), 0);
    session.announce(vec![announced("new")]).unwrap();
    let arrival = containers * items_each;
    assert_eq!(session.waiting("new").unwrap().arrival, arrival);
}

#[test]
fn as_many_items_as_a_session_holds_can_wait_where_others_left() {
    let mut session = over_two(&[]);
    for number in 0..200 {
        let item = format!("i{number}");
        session.announce(vec![announced(&item)]).unwrap();
        pack(&mut session, &item, "left", 11);
    }
    close(&mut session, "left", 0).unwrap();
    let more = (0..1000).map(|number| announced(&format!("m{number}")));
    session.announce(more.collect()).unwrap();
    assert_eq!(session.items().len(), 1000);
    let one_more = session.announce(vec![announced("one more")]);
    assert_eq!(one_more, Err(SessionError::Full));
}

#[test]
fn a_container_that_is_to_be_renewed_says_by_which_request() {
    let mut session = over_two(&["a"]);
    let renewal = Some("renewal".to_owned());
    session.close(closing("left", 0), renewal.clone()).unwrap();
    let renewal_id = |session: &Session| session.container("left").unwrap().renewal_id.clone();
    assert_eq!(Some(renewal_id(&session)), renewal);
    let message = session.to_message(1);
    assert_eq!(Session::from_message(message).unwrap(), session);
    session.open(start("left", 1, 12)).unwrap();
    assert_eq!(renewal_id(&session), "");
}

#[test]
fn what_cannot_have_come_there_in_the_session_is_told() {
    let mut session = over_two(&["a", "b", "c"]);
    pack(&mut session, "a", "left", 11);
    session.withdraw("c").unwrap();
    let body = |item: &&str| v1::Body {
        item_id: (*item).to_owned(),
        ..v1::Body::default()
    };
    let told = |state_number, bodies: &[&str]| v1::CellState {
        state_number,
        bodies: bodies.iter().map(body).collect(),
        ..v1::CellState::default()
    };
    for (state_number, bodies, expected) in [
        (11, &["a"][..], None),
        // Somebody had a hand in it, or it was held meanwhile.
        (13, &["a"], None),
        (13, &["a", "c"], None),
        (11, &["a", "b"], Some("b")),
        // What lay there before the session is no news, unless more was done since.
        (11, &["a", "z"], None),
        (12, &["a", "z"], Some("z")),
    ] {
        let state = told(state_number, bodies);
        let found = session.unexplained("left", &state);
        assert_eq!(found, expected, "{state_number} {bodies:?}");
    }
    let reason = v1::ItemReason {
        item_id: "b".to_owned(),
        ..v1::ItemReason::default()
    };
    session.set_aside(reason).unwrap();
    assert_eq!(session.unexplained("left", &told(11, &["b"])), Some("b"));
    // A session that knows of no state knows of nothing that is new.
    let fresh = Session::begin("s".to_owned(), vec![start("left", 0, 0)], true, 0);
    assert_eq!(fresh.unexplained("left", &told(11, &["z"])), None);
}

#[test]
fn who_acknowledges_goes_on_from_the_state_that_the_bridge_is_in() {
    let mut session = over_two(&[]);
    session.goes_on_at("left", Some(4));
    session.goes_on_at("right", None);
    assert_eq!(session.least_state_number("left"), 4);
    assert_eq!(session.least_state_number("right"), 500);
}
