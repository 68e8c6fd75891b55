//! A cell with several containers that are packed at the same time.

use std::collections::BTreeMap;

use crate::common::containers::{Rig, close, open};
use crate::common::{self, announcement, block, cell, placed, soon, square};
use ppnpack_packing::closing::ClosingRules;
use ppnpack_packing::grid::ContainerSize;
use ppnpack_packing::orders::Sharing;
use ppnpack_planner::{ClosingSettings, ContainerSettings};
use ppnpack_service::stream::Latest;
use ppnpack_service::{ServiceSettings, embedded};
use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::keys::{Service, Stream};
use ppnpack_wire::v1::{self, Status};

#[test]
fn the_fullest_container_is_packed_first_and_the_decision_names_it() {
    let rig = Rig::new(&["left", "right"], |_| {});
    rig.begin(4);
    assert_eq!(rig.step().container, "left");
    assert_eq!(rig.step().container, "left");
    rig.call(close("left", 0));
    assert_eq!(rig.step().container, "right");
    let session = rig.session();
    let packed_in = |container: &str| {
        let items = session.items.iter();
        items.filter(|item| item.container == container).count()
    };
    assert_eq!((packed_in("left"), packed_in("right")), (2, 1));
    let [closed] = session.closed.as_slice() else {
        panic!("{:?}", session.closed);
    };
    assert_eq!((closed.container.as_str(), closed.items), ("left", 2));
    assert_eq!(closed.text, "the truck leaves");
    rig.call(open("left", 1));
    // The right one holds more than the new one.
    assert_eq!(rig.step().container, "right");
    rig.finish();
}

#[test]
fn a_container_that_is_not_seen_is_left_out_and_the_decision_says_so() {
    let rig = Rig::new(&["right"], |_| {});
    rig.begin(1);
    let decision = rig.step();
    assert_eq!(decision.container, "right");
    let [reason] = decision.degraded.as_slice() else {
        panic!("{:?}", decision.degraded);
    };
    assert!(reason.starts_with("container left is left out"), "{reason}");
    rig.finish();
}

#[test]
fn without_an_open_container_nothing_is_planned_and_the_refusal_says_so() {
    let rig = Rig::new(&["left", "right"], |_| {});
    rig.call(v1::BeginRequest {
        session_id: "s".to_owned(),
        containers: vec![v1::ContainerStart {
            container: "right".to_owned(),
            ..v1::ContainerStart::default()
        }],
        ..v1::BeginRequest::default()
    });
    rig.announce(2);
    assert_eq!(rig.step().container, "right");
    rig.call(close("right", 0));
    let (status, text) = rig.refused(v1::PlanRequest::default());
    assert_eq!(status, Some(Status::Conflict));
    assert!(text.contains("no container is open"), "{text}");
    rig.call(open("left", 0));
    assert_eq!(rig.step().container, "left");
    rig.finish();
}

#[test]
fn requests_for_other_containers_are_refused() {
    let rig = Rig::new(&["left", "right"], |_| {});
    rig.begin(1);
    let not_found = Some(Status::NotFound);
    assert_eq!(rig.refused(close("middle", 0)).0, not_found);
    assert_eq!(rig.refused(open("middle", 0)).0, not_found);
    let (status, text) = rig.refused(open("left", 1));
    assert_eq!(status, Some(Status::Conflict));
    assert!(text.contains("number 0 is open there"), "{text}");
    let start = |container: &str| v1::ContainerStart {
        container: container.to_owned(),
        ..v1::ContainerStart::default()
    };
    let begin = |containers: &[&str], least_state_number| v1::BeginRequest {
        session_id: "next".to_owned(),
        containers: containers.iter().copied().map(start).collect(),
        least_state_number,
        ..v1::BeginRequest::default()
    };
    assert_eq!(rig.refused(begin(&["middle"], 0)).0, not_found);
    let invalid = Some(Status::Invalid);
    assert_eq!(rig.refused(begin(&["left", "left"], 0)).0, invalid);
    let (status, text) = rig.refused(begin(&[], 7));
    assert_eq!(status, invalid);
    assert!(text.contains("least_state_number"), "{text}");
    assert_eq!(rig.session().session_id, "s");
    rig.finish();
}

#[test]
fn a_container_as_full_as_is_set_is_closed() {
    let percent = |volume_m3: f64| 100.0 * volume_m3 / (0.32 * 0.32 * 0.3);
    let rig = Rig::new(&["left", "right"], |settings| {
        settings.closing = ClosingSettings {
            rules: ClosingRules {
                fill_percent: Some(percent(0.003)),
                ..ClosingRules::default()
            },
            ..ClosingSettings::default()
        };
    });
    common::begin(&rig.client);
    let items = (0..3).map(|number| announcement(&format!("i{number}"), square("box", 8, 0.0016)));
    rig.call(v1::AnnounceRequest {
        items: items.collect(),
        ..v1::AnnounceRequest::default()
    });
    let containers: Vec<String> = (0..3).map(|_| rig.step().container).collect();
    assert_eq!(containers, ["left", "left", "right"]);
    let session = rig.session();
    let closed: Vec<_> = session
        .closed
        .iter()
        .map(v1::ClosedContainer::reason)
        .collect();
    assert_eq!(closed, [v1::ClosingReason::Full]);
    rig.finish();
}

#[test]
fn what_lies_where_survives_a_restart_and_other_containers_end_the_session() {
    let rig = Rig::new(&["left", "right"], |_| {});
    rig.begin(2);
    rig.step();
    rig.call(close("left", 0));
    let before = rig.session();
    let rig = rig.restarted(|_| {});
    assert_eq!(rig.session(), before);
    let rig = rig.restarted(|settings| {
        let cells = settings.cells.values_mut();
        cells.for_each(|cell| drop(cell.containers.remove("left")));
    });
    let session = rig.session();
    assert_eq!(session.end(), v1::SessionEnd::Failed);
    assert!(
        session.failure.contains("begin a new session"),
        "{}",
        session.failure
    );
    rig.finish();
}

#[test]
fn a_container_has_a_name_of_its_own() {
    let mut settings = common::settings(crate::common::coarse());
    let containers = BTreeMap::from([("cell-1".to_owned(), ContainerSettings::default())]);
    settings.cells.get_mut("cell-1").unwrap().containers = containers;
    let refused = settings.validate().unwrap_err();
    assert!(
        refused.contains("cells.cell-1.containers.cell-1"),
        "{refused}"
    );
}

/// Announces blocks, each with what it belongs to.
fn announce_lines(rig: &Rig, lines: &[(&str, v1::OrderLine)]) {
    let items = lines.iter().map(|(item_id, line)| v1::Announcement {
        order_line: Some(line.clone()),
        ..announcement(item_id, block())
    });
    rig.call(v1::AnnounceRequest {
        items: items.collect(),
        ..v1::AnnounceRequest::default()
    });
}

fn of_group(group: &str) -> v1::OrderLine {
    v1::OrderLine {
        group: group.to_owned(),
        ..v1::OrderLine::default()
    }
}

fn of_order(order: &str) -> v1::OrderLine {
    v1::OrderLine {
        order: order.to_owned(),
        ..v1::OrderLine::default()
    }
}

/// Steps until nothing fits or waits; the items with their containers, and why others do not fit.
fn pack(rig: &Rig) -> (Vec<(String, String)>, Vec<v1::ItemReason>) {
    let mut packed = Vec::new();
    loop {
        let reply = rig.call(v1::PlanRequest::default());
        let Some(decision) = reply.decision else {
            return (packed, reply.reasons);
        };
        rig.call(placed(&decision, decision.state_number + 1));
        packed.push((decision.item_id, decision.container));
    }
}

fn pairs(packed: &[(String, String)]) -> Vec<(&str, &str)> {
    let pairs = packed.iter();
    pairs
        .map(|(item, container)| (item.as_str(), container.as_str()))
        .collect()
}

#[test]
fn groups_that_must_not_travel_together_go_into_two_containers() {
    let rig = Rig::new(&["left", "right"], |settings| {
        settings.rules.apart = vec![("food".to_owned(), "soap".to_owned())];
        settings.set_aside = 5;
    });
    common::begin(&rig.client);
    let (food, soap) = (of_group("food"), of_group("soap"));
    let lines = [
        ("a", food.clone()),
        ("b", soap.clone()),
        ("c", food),
        ("d", soap),
    ];
    announce_lines(&rig, &lines);
    let (packed, _) = pack(&rig);
    let mut lying = pairs(&packed);
    lying.sort_unstable();
    assert_eq!(
        lying,
        [("a", "left"), ("b", "right"), ("c", "left"), ("d", "right")]
    );
    // What no open container may take is not set aside: it waits for another one.
    rig.call(close("right", 0));
    announce_lines(&rig, &[("e", of_group("soap"))]);
    let (packed, reasons) = pack(&rig);
    assert!(packed.is_empty());
    assert_eq!(reasons[0].reason(), v1::Reason::Rule);
    assert_eq!(
        reasons[0].text,
        "container left: soap must not travel with food"
    );
    rig.call(open("right", 1));
    assert_eq!(pairs(&pack(&rig).0), [("e", "right")]);
    rig.finish();
}

#[test]
fn a_container_of_one_order_is_closed_when_that_is_complete() {
    let rig = Rig::new(&["left", "right"], |settings| {
        settings.rules.sharing = Sharing::OneOrder;
        settings.closing.rules.order_complete = true;
    });
    common::begin(&rig.client);
    let lines = ["1", "2", "1", "2", "2"].map(of_order);
    let lines: Vec<_> = ["a", "b", "c", "d", "e"].into_iter().zip(lines).collect();
    announce_lines(&rig, &lines);
    let (packed, _) = pack(&rig);
    let of_left = pairs(&packed);
    let of_left: Vec<&str> = of_left
        .iter()
        .filter(|(_, container)| *container == "left")
        .map(|(item, _)| *item)
        .collect();
    assert_eq!(of_left, ["a", "c"]);
    assert_eq!(packed.len(), 5);
    let session = rig.session();
    let closed = session.closed.iter();
    let closed: Vec<_> = closed
        .map(|closed| (closed.container.as_str(), closed.items))
        .collect();
    assert_eq!(closed, [("left", 2), ("right", 3)]);
    let is_complete =
        |closed: &v1::ClosedContainer| closed.reason() == v1::ClosingReason::OrderComplete;
    assert!(session.closed.iter().all(is_complete));
    rig.finish();
}

#[test]
fn a_container_that_is_full_is_closed_though_a_smaller_one_is_empty() {
    let rig = Rig::new(&["left", "right"], |settings| {
        let left = settings.containers.get_mut("left").unwrap();
        left.container = Some(ContainerSize {
            x_m: 0.12,
            y_m: 0.12,
            z_m: 0.1,
        });
        settings.rules.most_kg = Some(2.0);
        settings.closing.renews = true;
    });
    let bridge = embedded::process(&rig.hub, Service::Bridge, "bridge-1").unwrap();
    let sessions: Latest<v1::Session> =
        Latest::subscribe(&bridge, &cell(), Stream::Session, MAX_MESSAGE_BYTES).unwrap();
    common::begin(&rig.client);
    let heavy = |item_id: &str| v1::Announcement {
        order_line: Some(v1::OrderLine {
            mass_kg: 1.5,
            ..v1::OrderLine::default()
        }),
        ..announcement(item_id, square("large", 20, 0.001))
    };
    rig.call(v1::AnnounceRequest {
        items: vec![heavy("a"), heavy("b")],
        ..v1::AnnounceRequest::default()
    });
    assert_eq!(rig.step().container, "right");
    rig.call(v1::AutomaticRequest {
        is_automatic: true,
        ..v1::AutomaticRequest::default()
    });
    let closed = loop {
        let session = sessions.wait(soon()).unwrap().message.unwrap();
        if let Some(closed) = session.closed.first() {
            break closed.clone();
        }
    };
    assert_eq!((closed.container.as_str(), closed.items), ("right", 1));
    assert_eq!(closed.reason(), v1::ClosingReason::NothingFits);
    rig.finish();
}

#[test]
fn a_container_takes_no_more_than_its_greatest_mass() {
    let rig = Rig::new(&["left", "right"], |settings| {
        settings.rules.most_kg = Some(2.0);
    });
    common::begin(&rig.client);
    let heavy = |mass_kg| v1::OrderLine {
        mass_kg,
        ..v1::OrderLine::default()
    };
    let lines = [
        ("a", heavy(1.5)),
        ("b", heavy(1.0)),
        ("c", heavy(1.2)),
        ("d", heavy(0.4)),
    ];
    announce_lines(&rig, &lines);
    let (packed, reasons) = pack(&rig);
    let mut lying = pairs(&packed);
    lying.sort_unstable();
    assert_eq!(lying, [("a", "left"), ("b", "right"), ("d", "left")]);
    assert_eq!(reasons.len(), 1);
    assert_eq!(reasons[0].item_id, "c");
    assert_eq!(reasons[0].reason(), v1::Reason::Rule);
    assert!(
        reasons[0].text.contains("0.20 kg too heavy"),
        "{}",
        reasons[0].text
    );
    rig.finish();
}

#[test]
fn what_an_item_belongs_to_is_checked_and_stays_what_it_was() {
    let rig = Rig::new(&["left", "right"], |_| {});
    common::begin(&rig.client);
    let announce = |line: v1::OrderLine| v1::AnnounceRequest {
        items: vec![v1::Announcement {
            order_line: Some(line),
            ..announcement("a", block())
        }],
        ..v1::AnnounceRequest::default()
    };
    let wrong = v1::OrderLine {
        mass_kg: -1.0,
        ..of_order("1")
    };
    let (status, text) = rig.refused(announce(wrong));
    assert_eq!(status, Some(Status::Invalid));
    assert!(text.contains("mass_kg"), "{text}");
    assert_eq!(
        rig.refused(announce(of_order("no name"))).0,
        Some(Status::Invalid)
    );
    rig.call(announce(of_order("1")));
    rig.call(announce(of_order("1")));
    assert_eq!(
        rig.refused(announce(of_order("2"))).0,
        Some(Status::Conflict)
    );
    let session = rig.session();
    assert_eq!(session.items[0].order_line, Some(Box::new(of_order("1"))));
    rig.finish();
}
