//! Recorded steps are planned again, without any service, to the same decisions bit for bit.

use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use crate::common::{
    Rig, announcement, block, cell, coarse, left_and_right, line, of_order, soon, square, untried,
};
use ppnpack_packing::planning::method::ProposalSource;
use ppnpack_packing::ranking::coarse::Coarsening;
use ppnpack_packing::streams::orders::Sharing;
use ppnpack_planner::CellSettings;
use ppnpack_planner::replay::{Replayer, Unreadable, Unreplayable, what_follows};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::process::Process;
use ppnpack_service::rpc::Client;
use ppnpack_service::shapes;
use ppnpack_service::stream::{self, Subscription};
use ppnpack_wire::keys::{Service, Stream};
use ppnpack_wire::shape_store::ShapeStore;
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};

struct Tape {
    records: Receiver<v1::PlanningRecord>,
    client: Client,
    _subscription: Subscription,
    _process: Process,
}

impl Tape {
    /// Records from now on: the planner has heard of it when this returns.
    fn new(hub: &Hub) -> Self {
        let process = embedded::process(hub, Service::Router, "tape-1").unwrap();
        let (sender, records) = channel();
        let subscription = stream::subscribe(
            process.session(),
            Some(&cell()),
            Stream::Record,
            MAX_MESSAGE_BYTES,
            move |_, record: v1::PlanningRecord| drop(sender.send(record)),
        );
        let tape = Self {
            records,
            client: Client::new(process.session()),
            _subscription: subscription.unwrap(),
            _process: process,
        };
        // The hub knows the subscription before it passes this request on.
        let request = v1::SessionRequest::default();
        tape.client.call(&cell(), request, soon()).unwrap();
        tape
    }

    fn next(&self) -> v1::PlanningRecord {
        let left = soon().saturating_duration_since(Instant::now());
        self.records.recv_timeout(left).unwrap()
    }

    fn is_empty(&self) -> bool {
        self.records.recv_timeout(Duration::ZERO).is_err()
    }

    fn shapes(&self, record: &v1::PlanningRecord) -> ShapeStore {
        let mut store = ShapeStore::default();
        let ids = shapes::named(record);
        let unknown = shapes::fetch(&self.client, &cell(), ids, soon(), |it| store.add(it));
        assert_eq!(unknown.unwrap(), 0);
        store
    }

    /// Takes the next record; gives it with what is decided again.
    fn replayed(&self, replayer: &mut Replayer) -> (v1::PlanningRecord, Option<v1::Decision>) {
        let record = self.next();
        let decision = replayer.replay(&record, &self.shapes(&record)).unwrap();
        (record, decision)
    }
}

fn replayer() -> Replayer {
    Replayer::new(2).unwrap()
}

#[test]
fn tried_placements_are_decided_again() {
    let rig = Rig::new(coarse());
    let tape = Tape::new(&rig.hub);
    rig.begin();
    let fragile = v1::Announcement {
        rules: Some(v1::ItemRules {
            is_fragile: true,
            carries_kg: Some(0.3),
            ..v1::ItemRules::default()
        }),
        order_line: Some(v1::OrderLine {
            mass_kg: 0.7,
            stop: 2,
            ..v1::OrderLine::default()
        }),
        ..announcement("a", square("slab", 12, 0.0001))
    };
    let later = v1::OrderLine {
        stop: 3,
        ..v1::OrderLine::default()
    };
    let later = line("b", later);
    rig.announce([fragile, later, announcement("c", block())]);
    let mut replayer = replayer();
    for step in 0..3 {
        let plan = v1::PlanRequest {
            alternatives: 4,
            ..v1::PlanRequest::default()
        };
        let decision = rig.call(plan).decision.unwrap();
        let (record, again) = tape.replayed(&mut replayer);
        assert_eq!(record.step, step);
        let recorded = record.decision.unwrap();
        assert_eq!(recorded, decision);
        assert!(decision.settling.is_some() && !decision.alternatives.is_empty());
        assert_eq!(again.unwrap(), what_follows(&recorded), "step {step}");
        let cells = if decision.item_id == "a" { 12 } else { 6 };
        let is_found = decision.item_id != "b";
        rig.place_square(&decision, cells, is_found);
    }
}

#[test]
fn a_step_in_which_nothing_fits_goes_so_again() {
    let rig = Rig::new(CellSettings {
        set_aside: 1,
        ..untried()
    });
    let tape = Tape::new(&rig.hub);
    rig.begin();
    rig.announce(["a", "b"].map(|item_id| announcement(item_id, square("slab", 40, 0.0001))));
    assert_eq!(rig.plan().result(), v1::PlanResult::NothingFits);
    let mut replayer = replayer();
    // One is set aside, and the step is planned once more.
    for buffer in [2, 1] {
        let (record, again) = tape.replayed(&mut replayer);
        assert_eq!((record.items.len(), record.decision), (buffer, None));
        assert_eq!(again, None);
    }
    assert!(tape.is_empty());
}

#[test]
fn the_containers_of_a_cell_are_chosen_from_again() {
    let mut settings = left_and_right();
    settings.rules.sharing = Sharing::OneOrder;
    let rig = Rig::new(settings);
    let tape = Tape::new(&rig.hub);
    rig.begin();
    let items = [("a", "x", 9), ("b", "y", 7), ("c", "x", 8), ("d", "y", 6)];
    rig.announce(items.map(|(item_id, order, cells)| v1::Announcement {
        order_line: Some(of_order(order)),
        ..announcement(item_id, square("slab", cells, 0.0001))
    }));
    let mut replayer = replayer();
    let mut chosen = Vec::new();
    for _ in 0..4 {
        rig.step();
        let (record, again) = tape.replayed(&mut replayer);
        assert_eq!(record.containers.len(), 2);
        let recorded = what_follows(&record.decision.unwrap());
        chosen.push(recorded.container.clone());
        assert_eq!(again.unwrap(), recorded);
    }
    chosen.sort();
    chosen.dedup();
    assert_eq!(chosen, ["left", "right"]);
}

#[test]
fn what_cannot_be_planned_again_is_told_apart() {
    let rig = Rig::new(coarse());
    let tape = Tape::new(&rig.hub);
    rig.begin_with(&["a"]);
    rig.decision();
    let record = tape.next();
    let shapes = tape.shapes(&record);
    let mut replayer = replayer();
    let mut refused = |change: &dyn Fn(&mut v1::PlanningRecord)| {
        let mut other = record.clone();
        change(&mut other);
        replayer.replay(&other, &shapes).unwrap_err()
    };
    let cut = refused(&|record| record.is_cut = true);
    assert!(matches!(cut, Unreplayable::Cut), "{cut}");
    let settings = refused(&|record| record.settings = "{}}".to_owned());
    assert!(matches!(settings, Unreplayable::Settings(_)), "{settings}");
    let network = refused(&|record| {
        let mut cell: serde_json::Value = serde_json::from_str(&record.settings).unwrap();
        let proposals = ProposalSource::Network {
            percent: 5.0,
            coarsening: Coarsening { cells: 1, yaws: 1 },
            model: None,
        };
        cell["proposals"] = serde_json::to_value(proposals).unwrap();
        record.settings = cell.to_string();
    });
    assert!(matches!(network, Unreplayable::Network), "{network}");
    let lost = refused(&|record| record.candidates[0].item = vec![1; 32]);
    assert!(
        matches!(lost, Unreplayable::Record(Unreadable::Lacks { .. })),
        "{lost}"
    );
    let grid = refused(&|record| record.containers[0].scene = None);
    assert!(
        matches!(grid, Unreplayable::Record(Unreadable::Field(_))),
        "{grid}"
    );
}

#[test]
fn nothing_is_recorded_where_nobody_reads_it() {
    let rig = Rig::new(coarse());
    rig.begin_with(&["a", "b"]);
    rig.step();
    let tape = Tape::new(&rig.hub);
    // What was planned before anybody recorded is not there, and shapes are not known of it.
    let request = v1::ShapesRequest {
        ids: vec![vec![7; 32]],
        ..v1::ShapesRequest::default()
    };
    let reply = rig.call(request);
    assert_eq!((reply.shapes.len(), reply.unknown.len()), (0, 1));
    let second = rig.decision();
    assert_eq!(tape.next().decision.unwrap(), second);
    assert!(tape.is_empty());
}
