//! What one request may cost the network.
#![cfg(test)]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::ranking::step::StageError;
use ppnpack_packing::scene::Scene;
use ppnpack_ppn_service::{Network, ScoredItems, ScoredStep, Scorer, Settings};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_service::{OneWorker, Process};
use ppnpack_wire::convert;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::v1::{self, Status};

/// Proposes nothing, after a while; counts what it is asked for.
#[derive(Clone, Default)]
struct Idle {
    takes: Duration,
    opened: Arc<AtomicUsize>,
    scored: Arc<AtomicUsize>,
}

impl Network for Idle {
    fn model(&self) -> &str {
        "idle"
    }

    fn open(&self, _: &Grid) -> Result<Box<dyn Scorer>, StageError> {
        self.opened.fetch_add(1, Ordering::Relaxed);
        Ok(Box::new(self.clone()))
    }
}

impl Scorer for Idle {
    fn best(&mut self, step: &ScoredStep<'_>) -> Result<ScoredItems, StageError> {
        std::thread::sleep(self.takes);
        self.scored.fetch_add(1, Ordering::Relaxed);
        Ok(vec![Vec::new(); step.items.len()])
    }
}

/// A running service, and who asks it.
struct Rig {
    network: Idle,
    client: Client,
    _service: OneWorker,
    _process: Process,
    _hub: Hub,
}

impl Rig {
    fn new(settings: &Settings, network: Idle) -> Self {
        let hub = embedded::hub().unwrap();
        let process = embedded::process(&hub, Service::Ppn, "ppn-1").unwrap();
        let boxed = Box::new(network.clone());
        let service = ppnpack_ppn_service::start(&process, settings, boxed).unwrap();
        // It has run once by now.
        network.opened.store(0, Ordering::Relaxed);
        Self {
            network,
            client: Client::new(&embedded::session(&hub).unwrap()),
            _service: service,
            _process: process,
            _hub: hub,
        }
    }

    fn ask(
        &self,
        request: v1::ProposeRequest,
        within: Duration,
    ) -> Result<v1::ProposeReply, CallError> {
        let cell = Cell::new("cell-1").unwrap();
        self.client.call(&cell, request, Instant::now() + within)
    }

    fn assert_refused(&self, request: v1::ProposeRequest, setting: &str) {
        let refused = self.ask(request, Duration::from_secs(20)).unwrap_err();
        assert_eq!(refused.status(), Some(Status::Invalid), "{refused}");
        assert!(refused.to_string().contains(setting), "{refused}");
        assert_eq!(self.network.opened.load(Ordering::Relaxed), 0);
        assert_eq!(self.network.scored.load(Ordering::Relaxed), 0);
    }
}

/// A request for so many candidates of a shape, on a square container of so many cells a side.
fn request(cells: usize, yaws: usize, candidates: usize) -> v1::ProposeRequest {
    let side_m = cells as f64 * 0.001;
    let resolution = Resolution::new(0.001, 0.002, Yaws::half_turn(yaws).unwrap());
    let container = ContainerSize::cuboid(side_m, side_m, 0.3);
    let grid = Grid::new(container, resolution.unwrap()).unwrap();
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let view = ViewSurfaces::of_cells(2, 2, vec![10; 4], vec![0; 4]);
    let item = Item::new("block", vec![view; yaws], 0.0).unwrap();
    let item = convert::item::write(&item);
    v1::ProposeRequest {
        scene: Some(convert::scene::write(&grid, &scene)),
        item_ids: vec![ItemId::of(&item).to_bytes(); candidates],
        items: vec![item],
        percent: 5.0,
        ..v1::ProposeRequest::default()
    }
}

#[test]
fn the_network_is_not_made_ready_for_a_grid_of_more_cells_than_it_may_be() {
    let rig = Rig::new(&Settings::default(), Idle::default());
    rig.assert_refused(request(2048, 1, 1), "most_cells");
    let patience = Duration::from_secs(20);
    assert!(rig.ask(request(256, 1, 1), patience).is_ok());
}

#[test]
fn more_work_than_may_be_asked_for_at_once_is_refused_before_it_is_begun() {
    let rig = Rig::new(&Settings::default(), Idle::default());
    rig.assert_refused(request(64, 16, 1_000), "most_placements");
    let few = Settings {
        most_placements: 32 * 32 * 4 * 10,
        ..Settings::default()
    };
    let rig = Rig::new(&few, Idle::default());
    rig.assert_refused(request(32, 4, 11), "most_placements");
    let patience = Duration::from_secs(20);
    let reply = rig.ask(request(32, 4, 10), patience).unwrap();
    assert_eq!(reply.proposals.len(), 10);
}

#[test]
fn what_nobody_waits_for_any_more_is_not_scored() {
    let slow = Idle {
        takes: Duration::from_millis(600),
        ..Idle::default()
    };
    let rig = Rig::new(&Settings::default(), slow);
    std::thread::scope(|scope| {
        let first = scope.spawn(|| rig.ask(request(32, 4, 1), Duration::from_secs(20)));
        while rig.network.opened.load(Ordering::Relaxed) == 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        // The last one is late when those before are done.
        let patient = scope.spawn(|| rig.ask(request(33, 4, 1), Duration::from_secs(20)));
        std::thread::sleep(Duration::from_millis(100));
        let late = rig.ask(request(34, 4, 1), Duration::from_millis(700));
        assert!(late.is_err());
        assert!(first.join().unwrap().is_ok());
        assert!(patient.join().unwrap().is_ok());
    });
    let patience = Duration::from_secs(20);
    assert!(rig.ask(request(32, 4, 1), patience).is_ok());
    assert_eq!(rig.network.scored.load(Ordering::Relaxed), 3);
}
