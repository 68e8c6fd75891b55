//! Plans while the item placed before is inspected.

use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use crate::common::{self, announcement, block, cell, placed_and, soon};
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Surface;
use ppnpack_packing::method::Method;
use ppnpack_packing::trial::TrialSettings;
use ppnpack_planner::{CellSettings, PlannerService};
use ppnpack_service::Process;
use ppnpack_service::Running;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, CallError, Client, Done, Incoming, Listener};
use ppnpack_wire::keys::Service;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, PlanResult, Status};

/// The state of the cell after the first placement.
const PLACED_IN: u64 = 2;

fn in_ms(span: u64) -> Instant {
    Instant::now() + Duration::from_millis(span)
}

/// An empty container, whatever was placed.
fn heightmap(incoming: Incoming<v1::HeightmapRequest>) {
    let grid = Grid::reference();
    let surface = Surface::empty(&grid);
    common::show_from(incoming, &grid, surface, PLACED_IN - 1);
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
    /// A planner whose settings say this of inspections.
    fn new(inspect: Option<bool>) -> Self {
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
        let cell = CellSettings {
            // The heightmap never shows what was placed: that would be in the way of what is tried.
            method: Method {
                trial: TrialSettings::off(),
                ..crate::common::method()
            },
            inspect,
            ..crate::common::coarse()
        };
        let settings = common::settings(cell);
        Self {
            planner: common::start(&hub, &settings, &[]),
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

    /// Has two blocks announced and one placed, which somebody found or is only assumed to lie there.
    fn place_one_of_two(&self, is_found: bool) {
        self.call(v1::BeginRequest {
            session_id: "s".to_owned(),
            ..v1::BeginRequest::default()
        });
        self.call(v1::AnnounceRequest {
            items: vec![announcement("a", block()), announcement("b", block())],
            ..v1::AnnounceRequest::default()
        });
        self.place(is_found, PLACED_IN);
    }

    fn place(&self, is_found: bool, state_number: u64) {
        let decision = self.plan(soon()).unwrap().decision.unwrap();
        self.call(placed_and(&decision, state_number, is_found));
    }

    /// The request for the inspection of what was placed.
    fn inspection(&self) -> Incoming<v1::InspectRequest> {
        let patience = Duration::from_secs(20);
        self.inspections.recv_timeout(patience).unwrap()
    }

    /// How many items of the session were inspected.
    fn inspected(&self) -> usize {
        let session = self.call(v1::SessionRequest::default()).session.unwrap();
        let items = session.items.iter();
        items.filter(|item| item.inspection.is_some()).count()
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
    let rig = Rig::new(Some(true));
    rig.place_one_of_two(true);
    let inspection = rig.inspection();
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
    let rig = Rig::new(Some(true));
    rig.place_one_of_two(true);
    let inspection = rig.inspection();
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
    assert_eq!(rig.inspected(), 1);
    rig.planner.finish(soon()).unwrap();
}

#[test]
fn without_a_setting_what_nobody_found_is_inspected() {
    let rig = Rig::new(None);
    rig.place_one_of_two(false);
    answer(rig.inspection());
    // It waits for the answer.
    rig.place(true, PLACED_IN + 1);
    assert_eq!(rig.inspected(), 1);
    assert_eq!(rig.plan(soon()).unwrap().result(), PlanResult::NothingWaits);
    // The second was found.
    assert!(rig.inspections.try_recv().is_err());
    rig.planner.finish(soon()).unwrap();
}

#[test]
fn a_perception_without_a_catalogue_is_asked_once() {
    let rig = Rig::new(None);
    rig.place_one_of_two(false);
    let no_catalogue = "perception has no catalogue: set service.catalogue";
    rig.inspection().refuse(Status::NotFound, no_catalogue);
    rig.place(false, PLACED_IN + 1);
    assert_eq!(rig.plan(soon()).unwrap().result(), PlanResult::NothingWaits);
    assert!(rig.inspections.try_recv().is_err());
    assert_eq!(rig.inspected(), 0);
    rig.planner.finish(soon()).unwrap();
}

#[test]
fn nothing_is_inspected_where_that_is_switched_off() {
    let rig = Rig::new(Some(false));
    rig.place_one_of_two(false);
    assert_eq!(rig.plan(soon()).unwrap().result(), PlanResult::Decided);
    assert!(rig.inspections.try_recv().is_err());
    rig.planner.finish(soon()).unwrap();
}
