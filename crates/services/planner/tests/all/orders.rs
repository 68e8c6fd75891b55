//! Orders: what travels together, what leaves first, what is urgent, and what never comes.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::common::containers::left_and_right;
use crate::common::{self, announcement, block, cell, placed, soon, square};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Surface;
use ppnpack_packing::orders::Sharing;
use ppnpack_planner::{CellSettings, PlannerService};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, CallError, Client, Incoming, Listener};
use ppnpack_service::{Process, Running, ServiceSettings};
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, PlanResult, Status};

/// A planner of a cell with two containers, and a perception that sees what a test says, empty containers at first.
struct Rig {
    planner: Box<PlannerService>,
    client: Client,
    seen: Arc<Mutex<Surface>>,
    _perception: (Process, Vec<Listener>),
    _hub: Hub,
}

impl Rig {
    fn new(change: impl FnOnce(&mut CellSettings)) -> Self {
        let hub = embedded::hub().unwrap();
        let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
        let seen = Arc::new(Mutex::new(Surface::empty(&Grid::reference())));
        let listeners = ["left", "right"].map(|name| {
            let container = Cell::new(name).unwrap();
            let seen = Arc::clone(&seen);
            let show = move |incoming: Incoming<v1::HeightmapRequest>| {
                let surface = seen.lock().unwrap().clone();
                common::show_from(incoming, &Grid::reference(), surface, 2);
            };
            rpc::listen(&perception, Some(&container), show).unwrap()
        });
        let mut settings = left_and_right();
        change(&mut settings);
        let settings = common::settings(settings);
        settings.validate().unwrap();
        let rig = Self {
            planner: common::start(&hub, &settings, &[]),
            client: Client::new(&embedded::session(&hub).unwrap()),
            seen,
            _perception: (perception, listeners.into()),
            _hub: hub,
        };
        common::begin(&rig.client);
        rig
    }

    fn finish(self) {
        self.planner.finish(soon()).unwrap();
    }

    fn ask<R: Request>(&self, request: R) -> Result<R::Reply, CallError> {
        self.client.call(&cell(), request, soon())
    }

    fn call<R: Request>(&self, request: R) -> R::Reply {
        self.ask(request).unwrap()
    }

    fn refused<R: Request>(&self, request: R) -> (Option<Status>, String) {
        let error = self.ask(request).map(|_| ()).unwrap_err();
        (error.status(), error.to_string())
    }

    fn announce(&self, items: Vec<v1::Announcement>) {
        self.call(v1::AnnounceRequest {
            items,
            ..v1::AnnounceRequest::default()
        });
    }

    /// Plans a step, and reports it as placed; why nothing fits, where that is so.
    fn step(&self) -> Result<v1::Decision, Vec<v1::ItemReason>> {
        let reply = self.call(v1::PlanRequest::default());
        match reply.decision {
            Some(decision) => {
                self.call(placed(&decision, decision.state_number + 1));
                Ok(decision)
            }
            None => Err(reply.reasons),
        }
    }

    fn close(&self, container: &str) {
        self.call(v1::CloseRequest {
            container: container.to_owned(),
            ..v1::CloseRequest::default()
        });
    }

    fn session(&self) -> v1::Session {
        self.call(v1::SessionRequest::default()).session.unwrap()
    }
}

/// A block with what it belongs to.
fn line(item_id: &str, order_line: v1::OrderLine) -> v1::Announcement {
    v1::Announcement {
        order_line: Some(order_line),
        ..announcement(item_id, block())
    }
}

fn of_order(order: &str) -> v1::OrderLine {
    v1::OrderLine {
        order: order.to_owned(),
        ..v1::OrderLine::default()
    }
}

fn texts(reasons: &[v1::ItemReason]) -> Vec<&str> {
    assert!(
        reasons
            .iter()
            .all(|reason| reason.reason() == v1::Reason::Rule)
    );
    reasons.iter().map(|reason| reason.text.as_str()).collect()
}

#[test]
fn an_undivided_order_cannot_follow_into_a_closed_container() {
    let rig = Rig::new(|settings| {
        settings.rules.undivided = true;
        settings.set_aside = 5;
    });
    let items = ["a", "b", "c"].map(|item| line(item, of_order("7")));
    rig.announce(items.into());
    assert_eq!(rig.step().unwrap().container, "left");
    assert_eq!(rig.step().unwrap().container, "left");
    rig.close("left");
    // It is not set aside, either.
    assert_eq!(
        texts(&rig.step().unwrap_err()),
        [
            "container right: the items of order 7 must not be divided, and others of them are in a container that was closed"
        ]
    );
    // By another order it may.
    rig.call(v1::WithdrawRequest {
        item_id: "c".to_owned(),
        ..v1::WithdrawRequest::default()
    });
    rig.announce(vec![line("c2", of_order("8"))]);
    assert_eq!(rig.step().unwrap().container, "right");
    rig.finish();
}

#[test]
fn a_bundle_is_begun_only_where_its_mass_fits_and_room_is_kept_for_it() {
    let rig = Rig::new(|settings| settings.rules.most_kg = Some(5.0));
    let heavy = |item: &str, mass_kg: f64, bundle: &str| {
        let order_line = v1::OrderLine {
            mass_kg,
            bundle: bundle.to_owned(),
            ..v1::OrderLine::default()
        };
        line(item, order_line)
    };
    rig.announce(vec![
        heavy("a", 2.0, ""),
        heavy("b", 1.0, "gift"),
        heavy("c", 3.0, "gift"),
    ]);
    let containers: Vec<(String, String)> = (0..3)
        .map(|_| {
            let decision = rig.step().unwrap();
            (decision.item_id, decision.container)
        })
        .collect();
    let expected = [("a", "left"), ("b", "right"), ("c", "right")];
    let mut containers: Vec<(&str, &str)> = containers
        .iter()
        .map(|(item, container)| (item.as_str(), container.as_str()))
        .collect();
    containers.sort_unstable();
    assert_eq!(containers, expected);
    rig.announce(vec![heavy("d", 3.0, "pair"), heavy("e", 3.0, "pair")]);
    let reasons = rig.step().unwrap_err();
    assert!(
        reasons[0].text.contains(
            "the items of bundle pair must travel together, and of all of them together: the container would be"
        ),
        "{reasons:?}"
    );
    rig.finish();
}

#[test]
fn urgent_items_go_first_and_others_where_those_have_no_place() {
    let rig = Rig::new(|_| {});
    let urgent = |item: &str, urgency, edge| v1::Announcement {
        order_line: Some(v1::OrderLine {
            urgency,
            ..v1::OrderLine::default()
        }),
        ..announcement(item, square("box", edge, 0.001))
    };
    rig.announce(vec![
        urgent("usual", 0, 4),
        urgent("soon", 1, 4),
        urgent("now", 2, 4),
        // Wider than the container.
        urgent("never", 3, 40),
    ]);
    let order: Vec<String> = (0..3).map(|_| rig.step().unwrap().item_id).collect();
    assert_eq!(order, ["now", "soon", "usual"]);
    let reasons = rig.step().unwrap_err();
    assert_eq!(reasons[0].reason(), v1::Reason::TooLarge);
    rig.finish();
}

#[test]
fn nothing_is_placed_above_what_leaves_at_an_earlier_stop() {
    let rig = Rig::new(|settings| {
        // As wide as the floor, so that every item lies above those before.
        settings.containers.remove("right");
    });
    let at = |item: &str, stop| v1::Announcement {
        order_line: Some(v1::OrderLine {
            stop,
            ..v1::OrderLine::default()
        }),
        ..announcement(item, square("plate", 32, 0.001))
    };
    let lies = |height_m: f32| {
        let grid = Grid::reference();
        let mut surface = Surface::empty(&grid);
        for x in 0..surface.nx() {
            for y in 0..surface.ny() {
                surface.raise(x, y, height_m);
            }
        }
        *rig.seen.lock().unwrap() = surface;
    };
    rig.announce(vec![at("second", 2)]);
    assert_eq!(rig.step().unwrap().item_id, "second");
    lies(0.02);
    rig.announce(vec![at("third", 3), at("last", 0)]);
    let reasons = rig.step().unwrap_err();
    let texts: Vec<&str> = reasons.iter().map(|reason| reason.text.as_str()).collect();
    assert_eq!(reasons[0].reason(), v1::Reason::Rejected);
    assert!(
        texts[0].contains("above what leaves earlier wherever it fits: stop 3 above stop 2"),
        "{texts:?}"
    );
    assert!(texts[1].contains("no stop above stop 2"), "{texts:?}");
    let counts = rig
        .call(v1::ExplainRequest {
            item_id: "third".to_owned(),
            ..v1::ExplainRequest::default()
        })
        .counts
        .unwrap();
    assert!(
        counts
            .refusals
            .iter()
            .any(|refusals| refusals.check() == v1::Check::Sequence),
        "{counts:?}"
    );
    rig.announce(vec![at("first", 1)]);
    assert_eq!(rig.step().unwrap().item_id, "first");
    rig.finish();
}

#[test]
fn an_order_is_complete_when_all_came_or_no_more_is_expected() {
    let rig = Rig::new(|settings| {
        settings.rules.sharing = Sharing::OneOrder;
        settings.closing.rules.order_complete = true;
    });
    let of_three = |item: &str| {
        let order_line = v1::OrderLine {
            order_items: 3,
            ..of_order("7")
        };
        line(item, order_line)
    };
    rig.announce(vec![of_three("a"), of_three("b")]);
    rig.step().unwrap();
    rig.step().unwrap();
    assert!(rig.session().closed.is_empty());
    let no_more = |order: &str| v1::WithdrawRequest {
        order: order.to_owned(),
        ..v1::WithdrawRequest::default()
    };
    let (status, text) = rig.refused(no_more("8"));
    assert_eq!(status, Some(Status::NotFound));
    assert!(text.contains("no item of order 8 was announced"), "{text}");
    let both = v1::WithdrawRequest {
        item_id: "a".to_owned(),
        ..no_more("7")
    };
    assert_eq!(rig.refused(both).0, Some(Status::Invalid));
    rig.call(no_more("7"));
    let closed = rig.session().closed;
    assert_eq!(closed.len(), 1);
    assert_eq!(closed[0].reason(), v1::ClosingReason::OrderComplete);
    // The same announcement again, as after a restart of the controller, is no other item.
    rig.announce(vec![of_three("a")]);
    let nameless = v1::OrderLine {
        order_items: 3,
        ..v1::OrderLine::default()
    };
    let (status, text) = rig.refused(v1::AnnounceRequest {
        items: vec![line("x", nameless)],
        ..v1::AnnounceRequest::default()
    });
    assert_eq!(status, Some(Status::Invalid));
    assert!(text.contains("give order, too"), "{text}");
    rig.finish();
}

#[test]
fn an_order_is_waited_for_no_longer_than_is_set() {
    let rig = Rig::new(|settings| {
        settings.rules.sharing = Sharing::OneOrder;
        settings.closing.rules.order_complete = true;
        settings.closing.order_wait_s = Some(1.0);
    });
    let order_line = v1::OrderLine {
        order_items: 2,
        ..of_order("7")
    };
    rig.announce(vec![line("a", order_line)]);
    let announced = Instant::now();
    rig.step().unwrap();
    while rig.session().closed.is_empty() {
        assert!(announced.elapsed() < Duration::from_secs(30), "it waits on");
    }
    assert!(announced.elapsed() > Duration::from_millis(900));
    assert_eq!(
        rig.session().closed[0].reason(),
        v1::ClosingReason::OrderComplete
    );
    assert_eq!(
        rig.call(v1::PlanRequest::default()).result(),
        PlanResult::NothingWaits
    );
    rig.finish();
}

#[test]
fn groups_that_must_and_must_not_travel_together_are_refused() {
    let pair = || vec![("food".to_owned(), "soap".to_owned())];
    let mut settings = crate::common::coarse();
    settings.rules.apart = pair();
    settings.rules.together = pair();
    let refused = common::settings(settings).validate().unwrap_err();
    assert!(
        refused.contains("rules.together: food and soap"),
        "{refused}"
    );
}
