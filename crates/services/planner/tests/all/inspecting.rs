//! Plans while the item placed before is inspected.

use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use crate::common::{self, cell, in_ms, placed_and, soon};
use ppnpack_planner::CellSettings;
use ppnpack_service::rpc::{CallError, Done, Incoming};
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, PlanResult, Status};

/// The state of the cell after the first placement.
const PLACED_IN: u64 = 3;

/// A planner whose perception answers inspections when the test does. What it shows is empty,
/// whatever was placed.
struct Rig {
    own: common::Rig,
    inspections: Receiver<Incoming<v1::InspectRequest>>,
}

impl Rig {
    /// A planner whose settings say this of inspections, and that has one of two blocks placed,
    /// which somebody found or is only assumed to lie there.
    fn new(inspect: Option<bool>, is_found: bool) -> Self {
        let mut own = common::Rig::new(CellSettings {
            inspect,
            ..common::untried()
        });
        let (sender, inspections) = sync_channel(8);
        own.answer(Service::Perception, move |incoming| {
            sender.try_send(incoming).ok();
        });
        own.begin_with(&["a", "b"]);
        let rig = Self { own, inspections };
        rig.place(is_found, PLACED_IN);
        rig
    }

    fn plan(&self, deadline: Instant) -> Result<v1::PlanReply, CallError> {
        let request = v1::PlanRequest::default();
        self.own.client.call(&cell(), request, deadline)
    }

    fn place(&self, is_found: bool, state_number: u64) {
        let decision = self.own.decision();
        self.own.call(placed_and(&decision, state_number, is_found));
    }

    fn inspection(&self) -> Incoming<v1::InspectRequest> {
        let patience = Duration::from_secs(20);
        self.inspections.recv_timeout(patience).unwrap()
    }

    fn inspected(&self) -> usize {
        let session = self.own.session();
        let items = session.items.iter();
        items.filter(|item| item.inspection.is_some()).count()
    }

    fn assert_no_more_inspections(&self) {
        assert!(self.inspections.try_recv().is_err());
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
    let rig = Rig::new(Some(true), true);
    let inspection = rig.inspection();
    // On a busy machine an answer may come too late: one in time is enough.
    let mut refusals = (0..20).map(|_| rig.plan(in_ms(100)).unwrap_err());
    let refusal = refusals.find(|refusal| refusal.status() == Some(Status::TimedOut));
    let refusal = refusal.expect("an answer in time").to_string();
    assert!(refusal.contains("inspected"), "{refusal}");
    // Others are answered meanwhile.
    rig.own.session();
    drop(inspection);
}

#[test]
fn a_plan_waits_until_the_inspection_is_answered() {
    let rig = Rig::new(Some(true), true);
    let inspection = rig.inspection();
    let client = &rig.own.client;
    std::thread::scope(|scope| {
        let plan = scope.spawn(|| client.call(&cell(), v1::PlanRequest::default(), soon()));
        std::thread::sleep(Duration::from_millis(50));
        assert!(!plan.is_finished());
        answer(inspection);
        let reply = plan.join().unwrap().unwrap();
        assert_eq!(reply.result(), PlanResult::Decided);
    });
    assert_eq!(rig.inspected(), 1);
}

#[test]
fn without_a_setting_what_nobody_found_is_inspected() {
    let rig = Rig::new(None, false);
    answer(rig.inspection());
    // It waits for the answer.
    rig.place(true, PLACED_IN + 1);
    assert_eq!(rig.inspected(), 1);
    assert_eq!(rig.own.plan().result(), PlanResult::NothingWaits);
    // The second was found.
    rig.assert_no_more_inspections();
}

#[test]
fn a_perception_without_a_catalogue_is_asked_once() {
    let rig = Rig::new(None, false);
    let no_catalogue = "perception has no catalogue: set service.catalogue";
    rig.inspection().refuse(Status::NotFound, no_catalogue);
    rig.place(false, PLACED_IN + 1);
    assert_eq!(rig.own.plan().result(), PlanResult::NothingWaits);
    rig.assert_no_more_inspections();
    assert_eq!(rig.inspected(), 0);
}

#[test]
fn nothing_is_inspected_where_that_is_switched_off() {
    let rig = Rig::new(Some(false), true);
    assert_eq!(rig.own.plan().result(), PlanResult::Decided);
    rig.assert_no_more_inspections();
}
