//! Which of a cell's containers are open, where not all are: by their sizes, and by what waits.

use crate::common::containers::{Rig, close, open};
use crate::common::{self, announcement, cell, settings, soon, square};
use ppnpack_packing::grid::ContainerSize;
use ppnpack_planner::{CellSettings, ContainerSettings};
use ppnpack_service::rpc::{self, Done, Incoming};
use ppnpack_service::stream::Latest;
use ppnpack_service::{ServiceSettings, embedded};
use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::v1;

/// The left container is small, the right one large, and one may be open.
fn one_of_two(settings: &mut CellSettings) {
    let left = settings.containers.get_mut("left").unwrap();
    left.container = Some(ContainerSize {
        x_m: 0.12,
        y_m: 0.12,
        z_m: 0.1,
    });
    settings.opening.most = Some(1);
}

fn small(item_id: &str) -> v1::Announcement {
    announcement(item_id, square("small", 4, 0.000_05))
}

/// Is larger than the floor of the small container.
fn large(item_id: &str) -> v1::Announcement {
    announcement(item_id, square("large", 20, 0.001))
}

fn announce(rig: &Rig, items: Vec<v1::Announcement>) {
    rig.call(v1::AnnounceRequest {
        items,
        ..v1::AnnounceRequest::default()
    });
}

/// What stands in the places of the containers.
fn standing(session: &v1::Session) -> Vec<&str> {
    let containers = session.containers.iter();
    let standing = containers.map(|container| match container.is_open {
        true => "open",
        false if container.is_ready => "ready",
        false => "nothing",
    });
    standing.collect()
}

#[test]
fn the_smallest_container_is_opened_that_takes_what_waits() {
    let rig = Rig::new(&["left", "right"], one_of_two);
    common::begin(&rig.client);
    assert_eq!(standing(&rig.session()), ["ready", "ready"]);
    announce(&rig, vec![small("a")]);
    assert_eq!(standing(&rig.session()), ["open", "ready"]);
    assert_eq!(rig.step().container, "left");
    announce(&rig, vec![small("b"), large("c")]);
    rig.call(close("left", 0));
    assert_eq!(standing(&rig.session()), ["nothing", "open"]);
    assert_eq!(rig.step().container, "right");
    rig.finish();
}

#[test]
fn a_larger_one_is_opened_where_more_waits_than_a_small_one_is_expected_to_hold() {
    let rig = Rig::new(&["left", "right"], |settings| {
        one_of_two(settings);
        // Of 1.44 litres, less than the two items have.
        settings.opening.expected_percent = 5.5;
    });
    common::begin(&rig.client);
    announce(&rig, vec![small("a"), small("b")]);
    assert_eq!(standing(&rig.session()), ["ready", "open"]);
    rig.finish();
}

#[test]
fn a_request_opens_one_that_stands_ready_and_a_restart_changes_nothing() {
    let rig = Rig::new(&["left", "right"], one_of_two);
    common::begin(&rig.client);
    announce(&rig, vec![small("a")]);
    let session = rig.session();
    let rig = rig.restarted(|_| {});
    assert_eq!(rig.session(), session);
    rig.call(open("right", 0));
    assert_eq!(standing(&rig.session()), ["open", "open"]);
    rig.finish();
}

#[test]
fn all_that_stand_ready_are_opened_where_the_settings_are_without_a_limit_again() {
    let rig = Rig::new(&["left", "right"], one_of_two);
    common::begin(&rig.client);
    announce(&rig, vec![small("a")]);
    let rig = rig.restarted(|settings| {
        let cells = settings.cells.values_mut();
        cells.for_each(|cell| cell.opening.most = None);
    });
    announce(&rig, vec![small("b")]);
    assert_eq!(standing(&rig.session()), ["open", "open"]);
    rig.finish();
}

#[test]
fn an_empty_container_that_is_too_small_is_exchanged_in_automatic_mode() {
    let rig = Rig::new(&["left", "right"], |settings| {
        one_of_two(settings);
        settings.closing.renews = true;
    });
    let process = embedded::process(&rig.hub, Service::Bridge, "bridge-1").unwrap();
    let decisions: Latest<v1::Decision> =
        Latest::subscribe(&process, &cell(), Stream::Plan, MAX_MESSAGE_BYTES).unwrap();
    common::begin(&rig.client);
    announce(&rig, vec![small("a")]);
    assert_eq!(standing(&rig.session()), ["open", "ready"]);
    rig.call(v1::WithdrawRequest {
        item_id: "a".to_owned(),
        ..v1::WithdrawRequest::default()
    });
    announce(&rig, vec![large("b")]);
    rig.call(v1::AutomaticRequest {
        is_automatic: true,
        ..v1::AutomaticRequest::default()
    });
    let decision = decisions.wait(soon()).unwrap().message.unwrap();
    assert_eq!(decision.container, "right");
    let session = rig.session();
    assert_eq!(standing(&session), ["ready", "open"]);
    assert!(session.closed.is_empty());
    rig.finish();
}

#[test]
fn an_empty_container_that_comes_stands_ready_until_it_is_its_turn() {
    let rig = Rig::new(&["left", "right"], one_of_two);
    let bridge = embedded::process(&rig.hub, Service::Bridge, "bridge-1").unwrap();
    let renew = |incoming: Incoming<v1::RenewRequest>| {
        let reply = v1::RenewReply {
            state_number: 40,
            ..v1::RenewReply::default()
        };
        incoming.reply(reply, Done::default());
    };
    let left = Cell::new("left").unwrap();
    let _listener = rpc::listen(&bridge, Some(&left), renew).unwrap();
    let sessions: Latest<v1::Session> =
        Latest::subscribe(&bridge, &cell(), Stream::Session, MAX_MESSAGE_BYTES).unwrap();
    common::begin(&rig.client);
    announce(&rig, vec![small("a")]);
    rig.step();
    announce(&rig, vec![large("b")]);
    rig.call(v1::CloseRequest {
        is_renewed: true,
        ..close("left", 0)
    });
    let renewed = loop {
        let session = sessions.wait(soon()).unwrap().message.unwrap();
        if standing(&session) == ["ready", "open"] && session.containers[0].sequence == 1 {
            break session;
        }
    };
    assert_eq!(renewed.containers[0].least_state_number, 40);
    assert_eq!(rig.step().container, "right");
    announce(&rig, vec![small("c")]);
    rig.call(close("right", 0));
    assert_eq!(standing(&rig.session()), ["open", "nothing"]);
    assert_eq!(rig.step().container, "left");
    rig.finish();
}

#[test]
fn fewer_than_all_containers_may_be_open_and_at_least_one() {
    for (most, containers, is_possible) in
        [(0, 2, false), (1, 2, true), (2, 2, false), (1, 0, false)]
    {
        let mut cell = crate::common::coarse();
        let names = ["left", "right"].into_iter().take(containers);
        cell.containers = names
            .map(|name| (name.to_owned(), ContainerSettings::default()))
            .collect();
        cell.opening.most = Some(most);
        let refused = settings(cell).validate().err();
        assert_eq!(refused.is_none(), is_possible, "{most} of {containers}");
        assert!(refused.is_none_or(|refused| refused.contains("opening.most")));
    }
}
