//! Items that have no valid placement are set aside for the next container.

use std::time::{Duration, Instant};

use crate::common::{self, announcement, block, cell, ids, placed, soon, square};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Surface;
use ppnpack_packing::method::Method;
use ppnpack_planner::{CellSettings, PlannerService, Settings};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, Client, Incoming, Listener};
use ppnpack_service::stream::Latest;
use ppnpack_service::{Process, Running};
use ppnpack_wire::keys::{Service, Stream};
use ppnpack_wire::v1::{self, ItemState, PlanResult, Reason, SessionEnd, Status};
use ppnpack_wire::{MAX_MESSAGE_BYTES, rpc::Request};

/// The state that the container stays in.
const STATE: u64 = 2;

/// Is larger than the container's floor.
fn slab(mesh_volume_m3: f64) -> v1::Item {
    square("slab", 40, mesh_volume_m3)
}

/// An empty container, whatever was placed.
fn heightmap(incoming: Incoming<v1::HeightmapRequest>) {
    let grid = Grid::reference();
    let surface = Surface::empty(&grid);
    common::show_from(incoming, &grid, surface, STATE);
}

/// A planner that keeps its sessions in a file, and can be started again.
struct Rig {
    planner: Box<PlannerService>,
    settings: Settings,
    client: Client,
    decisions: Latest<v1::Decision>,
    _perception: (Process, Listener),
    hub: Hub,
    folder: tempfile::TempDir,
}

impl Rig {
    /// A cell with a buffer of so many items that may set so many aside.
    fn new(buffer: usize, set_aside: usize) -> Self {
        let hub = embedded::hub().unwrap();
        let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
        let listener = rpc::listen(&perception, None, heightmap).unwrap();
        let decisions =
            Latest::subscribe(&perception, &cell(), Stream::Plan, MAX_MESSAGE_BYTES).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let settings = CellSettings {
            method: Method {
                buffer,
                ..crate::common::method()
            },
            // The heightmap is never another one.
            heightmap_age_limit_s: 600.0,
            set_aside,
            ..crate::common::coarse()
        };
        let settings = Settings {
            store: Some(folder.path().join("sessions.redb")),
            ..common::settings(settings)
        };
        Self {
            planner: common::start(&hub, &settings, &[]),
            settings,
            client: Client::new(&embedded::session(&hub).unwrap()),
            decisions,
            _perception: (perception, listener),
            hub,
            folder,
        }
    }

    fn restarted(self) -> Self {
        self.planner.finish(soon()).unwrap();
        Self {
            planner: common::start(&self.hub, &self.settings, &[]),
            ..self
        }
    }

    fn finish(self) {
        self.planner.finish(soon()).unwrap();
        drop(self.folder);
    }

    fn call<R: Request>(&self, request: R) -> R::Reply {
        self.client.call(&cell(), request, soon()).unwrap()
    }

    fn begin(&self, request: v1::BeginRequest) -> v1::Session {
        let request = v1::BeginRequest {
            session_id: "s".to_owned(),
            ..request
        };
        self.call(request).session.unwrap()
    }

    fn announce(&self, items: Vec<v1::Announcement>) {
        self.call(v1::AnnounceRequest {
            items,
            ..v1::AnnounceRequest::default()
        });
    }

    fn plan(&self) -> v1::PlanReply {
        self.call(v1::PlanRequest::default())
    }

    fn session(&self) -> v1::Session {
        self.call(v1::SessionRequest::default()).session.unwrap()
    }

    fn report_placed(&self, decision: &v1::Decision) {
        self.call(placed(decision, decision.state_number + 1));
    }

    /// The session when its automatic mode has ended.
    fn ended(&self) -> v1::Session {
        let until = soon();
        loop {
            let session = self.session();
            if session.end() != SessionEnd::Unspecified {
                return session;
            }
            assert!(Instant::now() < until, "it does not end: {session:?}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

fn states(session: &v1::Session) -> Vec<(&str, ItemState)> {
    let items = session.items.iter();
    let states = items.map(|item| (item.item_id.as_str(), item.state()));
    states.collect()
}

#[test]
fn an_item_that_fits_nowhere_is_set_aside_and_stays_so_over_a_restart() {
    let rig = Rig::new(1, 1);
    let begun = rig.begin(v1::BeginRequest::default());
    assert_eq!(begun.set_aside_limit, 1);
    rig.announce(vec![
        announcement("large", slab(0.006)),
        announcement("small", block()),
    ]);
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::Decided);
    assert_eq!(ids(&reply.set_aside), ["large"]);
    assert_eq!(reply.set_aside[0].reason(), Reason::TooLarge);
    let decision = reply.decision.unwrap();
    assert_eq!(decision.item_id, "small");
    assert_eq!(decision.set_aside, reply.set_aside);
    assert_eq!(decision.stages[0].stage, "set_aside");
    // Who watches learns of it too.
    let published = rig.decisions.wait(soon()).unwrap().message.unwrap();
    assert_eq!(published.set_aside, reply.set_aside);

    let before = rig.session();
    assert_eq!(
        states(&before),
        [
            ("large", ItemState::SetAside),
            ("small", ItemState::Decided)
        ]
    );
    assert_eq!(before.set_aside, reply.set_aside);
    let rig = rig.restarted();
    assert_eq!(rig.session(), before);

    rig.report_placed(&decision);
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::NothingWaits);
    // That was at the step before.
    assert!(reply.set_aside.is_empty());
    assert_eq!(ids(&rig.session().set_aside), ["large"]);
    rig.finish();
}

#[test]
fn no_more_is_set_aside_than_may_be_until_something_is_taken_away() {
    let rig = Rig::new(1, 1);
    rig.begin(v1::BeginRequest::default());
    rig.announce(vec![
        announcement("first", slab(0.006)),
        announcement("second", slab(0.006)),
        announcement("small", block()),
    ]);
    // Asked again, it says the same.
    for _ in 0..2 {
        let reply = rig.plan();
        assert_eq!(reply.result(), PlanResult::NothingFits);
        assert_eq!(ids(&reply.set_aside), ["first"]);
        assert_eq!(ids(&reply.reasons), ["second"]);
    }
    let withdraw = v1::WithdrawRequest {
        item_id: "first".to_owned(),
        ..v1::WithdrawRequest::default()
    };
    let session = rig.call(withdraw).session.unwrap();
    assert_eq!(session.items[0].state(), ItemState::Withdrawn);
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::Decided);
    assert_eq!(ids(&reply.set_aside), ["second"]);
    rig.report_placed(&reply.decision.unwrap());

    // One that is set aside is tried again when it is announced again.
    rig.announce(vec![announcement("second", slab(0.006))]);
    let session = rig.session();
    assert_eq!(session.items[1].state(), ItemState::Waiting);
    assert!(session.set_aside.is_empty());
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::NothingWaits);
    assert_eq!(ids(&reply.set_aside), ["second"]);
    rig.finish();
}

#[test]
fn the_largest_item_of_the_buffer_is_set_aside_first() {
    let rig = Rig::new(3, 0);
    let begun = rig.begin(v1::BeginRequest {
        set_aside: Some(1),
        ..v1::BeginRequest::default()
    });
    assert_eq!(begun.set_aside_limit, 1);
    rig.announce(vec![
        announcement("small", slab(0.006)),
        announcement("large", slab(0.007)),
        announcement("as-large", slab(0.007)),
        announcement("block", block()),
    ]);
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::Decided);
    assert_eq!(ids(&reply.set_aside), ["large"]);
    assert_eq!(reply.decision.unwrap().item_id, "block");
    rig.finish();
}

#[test]
fn a_session_that_may_set_nothing_aside_says_that_nothing_fits() {
    let rig = Rig::new(1, 5);
    let begun = rig.begin(v1::BeginRequest {
        set_aside: Some(0),
        ..v1::BeginRequest::default()
    });
    assert_eq!(begun.set_aside_limit, 0);
    rig.announce(vec![
        announcement("large", slab(0.006)),
        announcement("small", block()),
    ]);
    let reply = rig.plan();
    assert_eq!(reply.result(), PlanResult::NothingFits);
    assert_eq!(ids(&reply.reasons), ["large"]);
    assert!(reply.set_aside.is_empty());
    let many = v1::BeginRequest {
        session_id: "many".to_owned(),
        set_aside: Some(10_001),
        ..v1::BeginRequest::default()
    };
    let refusal = rig.client.call(&cell(), many, soon()).unwrap_err();
    assert_eq!(refusal.status(), Some(Status::Invalid), "{refusal}");
    assert_eq!(rig.session().session_id, "s");
    rig.finish();
}

#[test]
fn the_automatic_mode_ends_with_the_others_set_aside_or_nothing_that_fits() {
    let rig = Rig::new(2, 2);
    rig.begin(v1::BeginRequest {
        is_automatic: true,
        ..v1::BeginRequest::default()
    });
    rig.announce(vec![
        announcement("first", slab(0.006)),
        announcement("second", slab(0.006)),
    ]);
    let session = rig.ended();
    assert_eq!(session.end(), SessionEnd::OthersSetAside);
    assert_eq!(ids(&session.set_aside), ["first", "second"]);
    let rig = rig.restarted();
    assert_eq!(rig.session(), session);

    // A third one is more than may be set aside.
    rig.announce(vec![announcement("third", slab(0.006))]);
    let session = rig.ended();
    assert_eq!(session.end(), SessionEnd::NothingFits);
    assert_eq!(ids(&session.reasons), ["third"]);
    assert_eq!(ids(&session.set_aside), ["first", "second"]);
    rig.finish();
}
