//! A cell with several containers that are packed at the same time.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use crate::common::{
    self, Rig, announcement, block, cell, close, left_and_right, line, of_mass, of_order, open,
    soon, square,
};
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_planner::{CellSettings, ContainerSettings};
use ppnpack_service::ServiceSettings;
use ppnpack_service::rpc::Incoming;
use ppnpack_service::stream::Latest;
use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::keys::Stream;
use ppnpack_wire::v1::{self, ClosingReason, Status};

/// A cell with two containers, where it is otherwise than by default.
fn with(change: impl FnOnce(&mut CellSettings)) -> Rig {
    let mut settings = left_and_right();
    change(&mut settings);
    Rig::new(settings)
}

/// Which containers were closed, with how many items, and why.
fn closed(session: &v1::Session) -> Vec<(&str, u32, ClosingReason)> {
    let closed = session.closed.iter();
    let closed = closed.map(|closed| (closed.container.as_str(), closed.items, closed.reason()));
    closed.collect()
}

#[test]
fn the_fullest_container_is_packed_first_and_the_decision_names_it() {
    let rig = Rig::new(left_and_right());
    rig.begin_with(&["a", "b", "c", "d"]);
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
    assert_eq!(closed(&session), [("left", 2, ClosingReason::Request)]);
    assert_eq!(session.closed[0].text, "the truck leaves");
    rig.call(open("left", 1));
    // The right one holds more than the new one.
    assert_eq!(rig.step().container, "right");
}

#[test]
fn a_container_that_is_not_seen_is_left_out_and_the_decision_says_so() {
    let rig = Rig::new(left_and_right());
    rig.seen.lock().unwrap().hidden = "left";
    rig.begin_with(&["a"]);
    let decision = rig.step();
    assert_eq!(decision.container, "right");
    let [reason] = decision.degraded.as_slice() else {
        panic!("{:?}", decision.degraded);
    };
    assert!(reason.starts_with("container left is left out"), "{reason}");
}

#[test]
fn without_an_open_container_nothing_is_planned_and_the_refusal_says_so() {
    let rig = Rig::new(left_and_right());
    rig.begin_as(v1::BeginRequest {
        containers: vec![v1::ContainerStart {
            container: "right".to_owned(),
            ..v1::ContainerStart::default()
        }],
        ..v1::BeginRequest::default()
    });
    rig.announce(["a", "b"].map(|item_id| announcement(item_id, block())));
    assert_eq!(rig.step().container, "right");
    rig.call(close("right", 0));
    let plan = v1::PlanRequest::default();
    rig.assert_refused(plan, Status::Conflict, "no container is open");
    rig.call(open("left", 0));
    assert_eq!(rig.step().container, "left");
}

#[test]
fn requests_for_other_containers_are_refused() {
    let rig = Rig::new(left_and_right());
    rig.begin();
    rig.assert_refused(close("middle", 0), Status::NotFound, "");
    rig.assert_refused(open("middle", 0), Status::NotFound, "");
    rig.assert_refused(open("left", 1), Status::Conflict, "number 0 is open there");
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
    rig.assert_refused(begin(&["middle"], 0), Status::NotFound, "");
    rig.assert_refused(begin(&["left", "left"], 0), Status::Invalid, "");
    rig.assert_refused(begin(&[], 7), Status::Invalid, "least_state_number");
    assert_eq!(rig.session().session_id, "s");
}

#[test]
fn a_container_as_full_as_is_set_is_closed() {
    let percent = |volume_m3: f64| 100.0 * volume_m3 / (0.32 * 0.32 * 0.3);
    let rig = with(|settings| settings.closing.rules.fill_percent = Some(percent(0.003)));
    rig.begin();
    rig.announce(["a", "b", "c"].map(|item_id| announcement(item_id, square("box", 8, 0.0016))));
    let containers = [(); 3].map(|()| rig.step().container);
    assert_eq!(containers, ["left", "left", "right"]);
    assert_eq!(closed(&rig.session()), [("left", 2, ClosingReason::Full)]);
}

#[test]
fn what_lies_where_survives_a_restart_and_other_containers_end_the_session() {
    let mut rig = Rig::new(left_and_right());
    rig.begin_with(&["a", "b"]);
    rig.step();
    rig.call(close("left", 0));
    let before = rig.session();
    rig.restart(&[], |_| {});
    assert_eq!(rig.session(), before);
    rig.restart(&[], |cell| drop(cell.containers.remove("left")));
    let session = rig.session();
    assert_eq!(session.end(), v1::SessionEnd::Failed);
    let failure = &session.failure;
    assert!(failure.contains("begin a new session"), "{failure}");
}

#[test]
fn a_container_has_a_name_of_its_own() {
    let mut settings = common::settings(common::coarse());
    let containers = BTreeMap::from([("cell-1".to_owned(), ContainerSettings::default())]);
    settings.cells.get_mut("cell-1").unwrap().containers = containers;
    let refused = settings.validate().unwrap_err();
    assert!(
        refused.contains("cells.cell-1.containers.cell-1"),
        "{refused}"
    );
}

/// Steps until nothing fits or waits; the items with their containers by their names, and why
/// others do not fit.
fn pack(rig: &Rig) -> (Vec<(String, String)>, Vec<v1::ItemReason>) {
    let mut packed = Vec::new();
    loop {
        match rig.try_step() {
            Ok(decision) => packed.push((decision.item_id, decision.container)),
            Err(reasons) => {
                packed.sort_unstable();
                return (packed, reasons);
            }
        }
    }
}

fn assert_packed(packed: &[(String, String)], expected: &[(&str, &str)]) {
    let packed = packed.iter();
    let packed = packed.map(|(item, container)| (item.as_str(), container.as_str()));
    assert_eq!(packed.collect::<Vec<_>>(), expected);
}

#[test]
fn a_container_that_is_full_is_closed_though_a_smaller_one_is_empty() {
    let rig = with(|settings| {
        let left = settings.containers.get_mut("left").unwrap();
        left.container = Some(ContainerSize::cuboid(0.12, 0.12, 0.1));
        settings.rules.most_kg = Some(2.0);
        settings.closing.renews = true;
    });
    let sessions: Latest<v1::Session> = Latest::subscribe(
        rig.any_process(),
        &cell(),
        Stream::Session,
        MAX_MESSAGE_BYTES,
    )
    .unwrap();
    rig.begin();
    rig.announce(["a", "b"].map(|item_id| v1::Announcement {
        order_line: Some(of_mass(1.5)),
        ..announcement(item_id, square("large", 20, 0.001))
    }));
    assert_eq!(rig.step().container, "right");
    rig.switch(true);
    loop {
        let session = sessions.wait(soon()).unwrap().message.unwrap();
        if !session.closed.is_empty() {
            let expected = [("right", 1, ClosingReason::NothingFits)];
            return assert_eq!(closed(&session), expected);
        }
    }
}

#[test]
fn a_renewal_names_the_state_that_it_empties_and_is_asked_anew_where_that_has_passed() {
    let mut rig = Rig::new(left_and_right());
    let state_number = Arc::new(AtomicU64::new(70));
    let told = Arc::clone(&state_number);
    rig.bridge_says(move || v1::CellState {
        state_number: told.load(Ordering::Relaxed),
        ..v1::CellState::default()
    });
    let named = Arc::new(Mutex::new(Vec::new()));
    let noted = Arc::clone(&named);
    rig.bridge_answers(move |incoming: &Incoming<v1::RenewRequest>| {
        let asked = incoming.message().state_number;
        noted.lock().unwrap().push(asked);
        // Somebody has a hand in the container before the first one comes.
        if asked == 70 {
            state_number.store(71, Ordering::Relaxed);
            return None;
        }
        Some(v1::RenewReply {
            state_number: asked + 1,
            ..v1::RenewReply::default()
        })
    });
    rig.begin_with(&["a"]);
    rig.call(v1::CloseRequest {
        is_renewed: true,
        ..close("left", 0)
    });
    let renewed = rig.session_once(|session| session.containers[0].is_open);
    assert_eq!(renewed.containers[0].sequence, 1);
    assert_eq!(renewed.containers[0].least_state_number, 72);
    assert_eq!(*named.lock().unwrap(), [70, 71]);
}

#[test]
fn a_container_takes_no_more_than_its_greatest_mass() {
    let rig = with(|settings| settings.rules.most_kg = Some(2.0));
    rig.begin();
    let masses_kg = [("a", 1.5), ("b", 1.0), ("c", 1.2), ("d", 0.4)];
    rig.announce(masses_kg.map(|(item_id, mass_kg)| line(item_id, of_mass(mass_kg))));
    let (packed, reasons) = pack(&rig);
    assert_packed(&packed, &[("a", "left"), ("b", "right"), ("d", "left")]);
    assert_eq!(common::ids(&reasons), ["c"]);
    assert_eq!(reasons[0].reason(), v1::Reason::Rule);
    let text = &reasons[0].text;
    assert!(text.contains("0.20 kg too heavy"), "{text}");
}

#[test]
fn what_an_item_belongs_to_is_checked_and_stays_what_it_was() {
    let rig = Rig::new(left_and_right());
    rig.begin();
    let announce = |order_line| common::announce([line("a", order_line)]);
    rig.assert_refused(announce(of_mass(-1.0)), Status::Invalid, "mass_kg");
    let bundle = v1::OrderLine {
        bundle: "gift".to_owned(),
        ..v1::OrderLine::default()
    };
    let urgent = v1::OrderLine {
        urgency: 1,
        ..v1::OrderLine::default()
    };
    for refused in [of_order("no name"), bundle, urgent] {
        rig.assert_refused(announce(refused), Status::Invalid, "");
    }
    for _ in 0..2 {
        rig.call(announce(of_order("1")));
    }
    rig.assert_refused(announce(of_order("2")), Status::Conflict, "");
    let item = &rig.session().items[0];
    assert_eq!(item.order_line, Some(Box::new(of_order("1"))));
}
