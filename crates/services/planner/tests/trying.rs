//! Placements are tried before they are decided on, also where no more is known of items than what was seen.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic
)]

mod common;

use std::sync::{Arc, Mutex};

use common::{announcement, block, cell, placed, soon};
use nalgebra::Isometry3;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Surface;
use ppnpack_planner::{CellSettings, PlannerService, Where};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, Client, Done, Incoming, Listener};
use ppnpack_service::{Process, Running};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, PlanResult};
use ppnpack_wire::{convert, rpc::Request};

/// What perception shows: the number of the cell's state, and the container's surface.
struct Shown {
    state_number: u64,
    surface: Surface,
}

impl Shown {
    /// Shows so many cells, from this one on, in another state, as high as this.
    fn raise(&mut self, (x, y): (usize, usize), cells: usize, height_m: f32) {
        self.state_number += 1;
        for x in 4 * x..4 * (x + cells) {
            for y in 4 * y..4 * (y + cells) {
                self.surface.raise(x, y, height_m);
            }
        }
    }
}

/// A planner with a perception, and a bridge that says what lies in the container where that is given.
struct Rig {
    planner: Box<PlannerService>,
    client: Client,
    shown: Arc<Mutex<Shown>>,
    _perception: (Process, Listener),
    _bridge: Option<(Process, Listener)>,
    _hub: Hub,
}

impl Rig {
    fn new(bodies: Option<Vec<v1::Body>>) -> Self {
        let hub = embedded::hub().unwrap();
        let shown = Arc::new(Mutex::new(Shown {
            state_number: 1,
            surface: Surface::empty(&Grid::reference()),
        }));
        let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
        let seen = Arc::clone(&shown);
        let heightmap = move |incoming: Incoming<v1::HeightmapRequest>| {
            let shown = seen.lock().unwrap();
            let surface = shown.surface.clone();
            common::show(incoming, &Grid::reference(), surface, shown.state_number);
        };
        let listener = rpc::listen(&perception, None, heightmap).unwrap();
        let bridge = bodies.map(|bodies| {
            let bridge = embedded::process(&hub, Service::Bridge, "bridge-1").unwrap();
            let state = move |incoming: Incoming<v1::CellStateRequest>| {
                let state = v1::CellState {
                    // Later than any that is reported.
                    state_number: 1_000,
                    bodies: bodies.clone(),
                    ..v1::CellState::default()
                };
                let reply = v1::CellStateReply {
                    state: Some(state),
                    ..v1::CellStateReply::default()
                };
                incoming.reply(reply, Done::default());
            };
            let listener = rpc::listen(&bridge, None, state).unwrap();
            (bridge, listener)
        });
        let settings = CellSettings {
            evaluate: Where::InProcess,
            // A heightmap is shown until the next one is.
            heightmap_age_limit_s: 600.0,
            ..CellSettings::default()
        };
        let settings = common::settings(settings);
        Self {
            planner: common::start(&hub, &settings, &[]),
            client: Client::new(&embedded::session(&hub).unwrap()),
            shown,
            _perception: (perception, listener),
            _bridge: bridge,
            _hub: hub,
        }
    }

    fn call<R: Request>(&self, request: R) -> R::Reply {
        self.client.call(&cell(), request, soon()).unwrap()
    }

    /// Begins a session with blocks.
    fn announce(&self, item_ids: &[&str]) {
        self.call(v1::BeginRequest {
            session_id: "s".to_owned(),
            ..v1::BeginRequest::default()
        });
        let blocks = item_ids
            .iter()
            .map(|item_id| announcement(item_id, block()));
        self.call(v1::AnnounceRequest {
            items: blocks.collect(),
            ..v1::AnnounceRequest::default()
        });
    }

    fn decision(&self) -> v1::Decision {
        let reply = self.call(v1::PlanRequest::default());
        assert_eq!(reply.result(), PlanResult::Decided, "{reply:?}");
        reply.decision.unwrap()
    }

    /// Reports a block as placed, and shows it.
    fn place(&self, decision: &v1::Decision) {
        let resting = decision.placement.as_ref().unwrap();
        let resting = convert::placement::read_resting(resting).unwrap();
        let at = resting.placement;
        let bottom_m = f32::from(resting.resting_height) * 0.002;
        let state_number = {
            let mut shown = self.shown.lock().unwrap();
            shown.raise((at.x, at.y), 6, bottom_m + 0.04);
            shown.state_number
        };
        self.call(placed(decision, state_number));
    }

    fn finish(self) {
        self.planner.finish(soon()).unwrap();
    }
}

fn says(decision: &v1::Decision, what: &str) -> bool {
    decision.degraded.iter().any(|reason| reason.contains(what))
}

fn comes_to_rest(decision: &v1::Decision) -> bool {
    let settling = decision.settling.as_ref();
    settling.is_some_and(|settling| settling.is_still)
}

#[test]
fn unknown_items_are_tried_with_the_shapes_that_were_seen() {
    let rig = Rig::new(None);
    rig.announce(&["a", "b"]);
    let first = rig.decision();
    assert!(comes_to_rest(&first), "{first:?}");
    assert!(says(&first, "tried with the shape"), "{first:?}");
    assert!(!says(&first, "in the container"), "{first:?}");
    rig.place(&first);
    let second = rig.decision();
    assert!(comes_to_rest(&second), "{second:?}");
    assert!(says(&second, "tried with the shape"), "{second:?}");
    assert!(
        says(&second, "items in the container took part"),
        "{second:?}"
    );
    rig.finish();
}

#[test]
fn a_body_of_no_known_shape_is_as_the_heightmap_shows_it() {
    let stranger = v1::Body {
        item_id: "stranger".to_owned(),
        object: "of no catalogue".to_owned(),
        container_from_item: Some(convert::pose::write(&Isometry3::identity())),
        is_inside: true,
    };
    let rig = Rig::new(Some(vec![stranger]));
    rig.shown.lock().unwrap().raise((0, 0), 32, 0.05);
    rig.announce(&["a"]);
    let decision = rig.decision();
    // It comes to rest where it was planned, on what nobody knows.
    assert!(comes_to_rest(&decision), "{decision:?}");
    assert!(
        says(&decision, "on the heightmap of the others"),
        "{decision:?}"
    );
    rig.finish();
}

#[test]
fn a_body_that_the_bridge_calls_otherwise_is_where_the_session_has_its_item() {
    let body = v1::Body {
        item_id: "a".to_owned(),
        object: "of no catalogue".to_owned(),
        // In the frame of that object.
        container_from_item: Some(convert::pose::write(&Isometry3::translation(5.0, 5.0, 5.0))),
        is_inside: true,
    };
    let rig = Rig::new(Some(vec![body]));
    rig.announce(&["a", "b"]);
    // The bridge says that it lies there before the session knows where.
    let first = rig.decision();
    assert_eq!(first.item_id, "a");
    assert!(says(&first, "on the heightmap of the others"), "{first:?}");
    rig.place(&first);
    let second = rig.decision();
    assert!(
        says(&second, "items in the container took part"),
        "{second:?}"
    );
    assert!(
        !says(&second, "on the heightmap of the others"),
        "{second:?}"
    );
    rig.finish();
}
