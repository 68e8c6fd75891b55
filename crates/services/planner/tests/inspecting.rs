//! Plans while the item placed before is inspected.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic
)]

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use nalgebra::{Point2, Vector3};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Scene, Surface};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::method::Method;
use ppnpack_packing::trial::TrialSettings;
use ppnpack_planner::{CellSettings, PlannerService, Settings, Where};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, CallError, Client, Done, Incoming, Listener};
use ppnpack_service::{Process, Running};
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::v1::{self, PlanResult, Status};
use ppnpack_wire::{convert, rpc::Request};

/// The state of the cell after the first placement.
const PLACED_IN: u64 = 2;

fn cell() -> Cell {
    Cell::new("cell-1").unwrap()
}

fn in_ms(span: u64) -> Instant {
    Instant::now() + Duration::from_millis(span)
}

fn soon() -> Instant {
    in_ms(20_000)
}

/// A block of 6 x 6 cells, 4 cm high.
fn block() -> v1::Item {
    let view = ViewSurfaces {
        nx: 6,
        ny: 6,
        top: vec![20; 36],
        bottom: vec![0; 36],
        underside: None,
        origin_from_corner_m: Vector3::new(0.03, 0.03, 0.0),
        centre_of_mass_m: Some(Point2::new(0.03, 0.03)),
    };
    convert::item::write(&Item::new("block", vec![view; 4], 0.0).unwrap())
}

/// An empty container, whatever was placed.
fn heightmap(incoming: Incoming<v1::HeightmapRequest>) {
    let grid = Grid::reference();
    let scene = Scene::from_surface(&grid, Surface::empty(&grid)).unwrap();
    let heightmap = v1::Heightmap {
        id: Some(v1::HeightmapId {
            epoch: 1,
            sequence: 1,
        }),
        state_number: PLACED_IN,
        scene: Some(convert::scene::write(&grid, &scene)),
        ..v1::Heightmap::default()
    };
    let reply = v1::HeightmapReply {
        heightmap: Some(heightmap),
        ..v1::HeightmapReply::default()
    };
    incoming.reply(reply, Done::default());
}

/// A planner whose perception answers inspections when the test does.
struct Rig {
    planner: Box<PlannerService>,
    inspections: Receiver<Incoming<v1::InspectRequest>>,
    client: Client,
    _perception: (Process, [Listener; 2]),
    _hub: Hub,
}

impl Rig {
    fn new() -> Self {
        let hub = embedded::hub().unwrap();
        let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
        let (sender, inspections) = sync_channel(8);
        let listeners = [
            rpc::listen(&perception, None, heightmap).unwrap(),
            rpc::listen(&perception, None, move |incoming| {
                sender.try_send(incoming).ok();
            })
            .unwrap(),
        ];
        let process = embedded::process(&hub, Service::Planner, "planner-1").unwrap();
        let cell = CellSettings {
            evaluate: Where::InProcess,
            // The heightmap never shows what was placed: that would be in the way of what is tried.
            method: Method {
                trial: TrialSettings::off(),
                ..Method::default()
            },
            inspect: true,
            ..CellSettings::default()
        };
        let settings = Settings {
            cells: BTreeMap::from([("cell-1".to_owned(), cell)]),
            ..Settings::default()
        };
        Self {
            planner: Box::new(ppnpack_planner::start(&process, &settings, &[]).unwrap()),
            inspections,
            client: Client::new(&embedded::session(&hub).unwrap()),
            _perception: (perception, listeners),
            _hub: hub,
        }
    }

    fn call<R: Request>(&self, request: R) -> R::Reply {
        self.client.call(&cell(), request, soon()).unwrap()
    }

    fn plan(&self, deadline: Instant) -> Result<v1::PlanReply, CallError> {
        let request = v1::PlanRequest::default();
        self.client.call(&cell(), request, deadline)
    }

    /// Has two blocks announced and one placed; gives the request for its inspection.
    fn place_one_of_two(&self) -> Incoming<v1::InspectRequest> {
        self.call(v1::BeginRequest {
            session_id: "s".to_owned(),
            ..v1::BeginRequest::default()
        });
        let announcement = |item_id: &str| v1::Announcement {
            item_id: item_id.to_owned(),
            shape: Some(v1::announcement::Shape::Item(block())),
            ..v1::Announcement::default()
        };
        self.call(v1::AnnounceRequest {
            items: vec![announcement("a"), announcement("b")],
            ..v1::AnnounceRequest::default()
        });
        let decision = self.plan(soon()).unwrap().decision.unwrap();
        self.call(v1::ReportRequest {
            decision_id: decision.decision_id.clone(),
            outcome: Some(v1::Outcome {
                placement_id: decision.decision_id,
                item_id: decision.item_id,
                kind: v1::OutcomeKind::Placed.into(),
                container_from_item: decision.container_from_item,
                is_inside: true,
                state_number: PLACED_IN,
                ..v1::Outcome::default()
            }),
            ..v1::ReportRequest::default()
        });
        let patience = Duration::from_secs(20);
        self.inspections.recv_timeout(patience).unwrap()
    }
}

fn answer(incoming: Incoming<v1::InspectRequest>) {
    let reply = v1::InspectReply {
        inspection: Some(v1::Inspection {
            kind: v1::InspectionKind::Unclear.into(),
            ..v1::Inspection::default()
        }),
        state_number: PLACED_IN,
        ..v1::InspectReply::default()
    };
    incoming.reply(reply, Done::default());
}

#[test]
fn a_plan_is_answered_by_its_deadline_although_an_inspection_is_out() {
    let rig = Rig::new();
    let inspection = rig.place_one_of_two();
    // On a busy machine an answer may come too late: one in time is enough.
    let mut refusals = (0..20).map(|_| rig.plan(in_ms(100)).unwrap_err());
    let refusal = refusals.find(|refusal| refusal.status() == Some(Status::TimedOut));
    let refusal = refusal.expect("an answer in time").to_string();
    assert!(refusal.contains("inspected"), "{refusal}");
    // Others are answered meanwhile.
    rig.call(v1::SessionRequest::default());
    drop(inspection);
    rig.planner.finish(soon()).unwrap();
}

#[test]
fn a_plan_waits_until_the_inspection_is_answered() {
    let rig = Rig::new();
    let inspection = rig.place_one_of_two();
    let client = rig.client.clone();
    let plan = std::thread::spawn(move || {
        let request = v1::PlanRequest::default();
        client.call(&cell(), request, soon())
    });
    std::thread::sleep(Duration::from_millis(50));
    assert!(!plan.is_finished());
    answer(inspection);
    let reply = plan.join().unwrap().unwrap();
    assert_eq!(reply.result(), PlanResult::Decided);
    let session = rig.call(v1::SessionRequest::default()).session.unwrap();
    let is_inspected = |item: &v1::SessionItem| item.inspection.is_some();
    assert!(session.items.iter().any(is_inspected));
    rig.planner.finish(soon()).unwrap();
}
