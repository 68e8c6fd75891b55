//! A planner with a perception that shows what was placed.

use std::sync::{Arc, Mutex};

use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Surface;
use ppnpack_planner::{CellSettings, PlannerService};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, Client, Done, Incoming, Listener};
use ppnpack_service::{Process, Running};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, PlanResult};
use ppnpack_wire::{convert, rpc::Request};

use super::{announcement, block, cell, placed_and, show, soon};

/// What perception shows: the number of the cell's state, and the container's surface.
pub(crate) struct Shown {
    state_number: u64,
    surface: Surface,
}

impl Shown {
    /// Shows so many cells, from this one on, in another state, as high as this.
    pub(crate) fn raise(&mut self, (x, y): (usize, usize), cells: usize, height_m: f32) {
        self.state_number += 1;
        for x in 4 * x..4 * (x + cells) {
            for y in 4 * y..4 * (y + cells) {
                self.surface.raise(x, y, height_m);
            }
        }
    }
}

/// A planner with a perception, and a bridge that says what lies in the container where that is given.
pub(crate) struct Rig {
    planner: Box<PlannerService>,
    pub(crate) client: Client,
    pub(crate) shown: Arc<Mutex<Shown>>,
    _perception: (Process, Listener),
    _bridge: Option<(Process, Listener)>,
    pub(crate) hub: Hub,
}

impl Rig {
    pub(crate) fn new(bodies: Option<Vec<v1::Body>>, settings: CellSettings) -> Self {
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
            show(incoming, &Grid::reference(), surface, shown.state_number);
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
            // A heightmap is shown until the next one is.
            heightmap_age_limit_s: 600.0,
            ..settings
        };
        let settings = super::settings(settings);
        Self {
            planner: super::start(&hub, &settings, &[]),
            client: Client::new(&embedded::session(&hub).unwrap()),
            shown,
            _perception: (perception, listener),
            _bridge: bridge,
            hub,
        }
    }

    pub(crate) fn call<R: Request>(&self, request: R) -> R::Reply {
        self.client.call(&cell(), request, soon()).unwrap()
    }

    /// Begins a session with blocks.
    pub(crate) fn announce(&self, item_ids: &[&str]) {
        super::begin(&self.client);
        let blocks = item_ids
            .iter()
            .map(|item_id| announcement(item_id, block()));
        self.call(v1::AnnounceRequest {
            items: blocks.collect(),
            ..v1::AnnounceRequest::default()
        });
    }

    pub(crate) fn decision(&self) -> v1::Decision {
        let reply = self.call(v1::PlanRequest::default());
        assert_eq!(reply.result(), PlanResult::Decided, "{reply:?}");
        reply.decision.unwrap()
    }

    /// Reports a block as placed and found, and shows it.
    pub(crate) fn place(&self, decision: &v1::Decision) {
        self.place_square(decision, 6, true);
    }

    /// Reports a square box of so many cells a side as placed, and shows it; whether it was found or
    /// is only assumed to lie there.
    pub(crate) fn place_square(&self, decision: &v1::Decision, cells: usize, is_found: bool) {
        let resting = decision.placement.as_ref().unwrap();
        let resting = convert::placement::read_resting(resting).unwrap();
        let at = resting.placement;
        let bottom_m = f32::from(resting.resting_height) * 0.002;
        let state_number = {
            let mut shown = self.shown.lock().unwrap();
            shown.raise((at.x, at.y), cells, bottom_m + 0.04);
            shown.state_number
        };
        self.call(placed_and(decision, state_number, is_found));
    }

    pub(crate) fn finish(self) {
        self.planner.finish(soon()).unwrap();
    }
}
