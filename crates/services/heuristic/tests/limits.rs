//! What one request may cost: time, work and memory.
#![allow(clippy::unwrap_used, reason = "a panic in a test is a failing test")]

use std::time::{Duration, Instant};

use ppnpack_heuristic::Settings;
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::kernel::objective::Heuristic;
use ppnpack_packing::ranking::search::SearchSettings;
use ppnpack_packing::scene::Scene;
use ppnpack_service::alive::Alive;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_service::{OneWorker, Process};
use ppnpack_wire::convert;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, Status};

/// Far more than any request here takes that is answered.
const PATIENCE: Duration = Duration::from_secs(60);

/// A running heuristic service, and who asks it.
struct Rig {
    client: Client,
    _service: OneWorker,
    _process: Process,
    hub: Hub,
}

impl Rig {
    fn new(settings: &Settings) -> Self {
        let hub = embedded::hub().unwrap();
        let process = embedded::process(&hub, Service::Heuristic, "heuristic-1").unwrap();
        Self {
            client: Client::new(&embedded::session(&hub).unwrap()),
            _service: ppnpack_heuristic::start(&process, settings).unwrap(),
            _process: process,
            hub,
        }
    }

    fn ask<R: Request>(&self, request: R, within: Duration) -> Result<R::Reply, CallError> {
        let cell = Cell::new("cell-1").unwrap();
        self.client.call(&cell, request, Instant::now() + within)
    }

    /// Asserts that a request is answered with the end of its time. An answer may come too late
    /// where other tests run beside.
    fn assert_timed_out<R: Request + Clone>(&self, request: &R, within: Duration) {
        let ask = || self.ask(request.clone(), within).err();
        let refused = (0..5).find_map(|_| ask().filter(|error| error.status().is_some()));
        let refused = refused.unwrap();
        assert_eq!(refused.status(), Some(Status::TimedOut), "{refused}");
        assert!(refused.to_string().contains("time limit"), "{refused}");
    }

    fn invalid(&self, request: v1::EvaluateRequest) -> String {
        let refused = self.ask(request, PATIENCE).unwrap_err();
        assert_eq!(refused.status(), Some(Status::Invalid), "{refused}");
        refused.to_string()
    }
}

#[test]
fn a_service_of_named_cells_is_there_for_no_other() {
    let rig = Rig::new(&Settings {
        cells: vec!["cell-2".to_owned()],
        ..Settings::default()
    });
    let session = embedded::session(&rig.hub).unwrap();
    let alive = Alive::watch(&session, Service::Heuristic).unwrap();
    assert!(alive.wait(Instant::now() + PATIENCE, |now| now.len() == 1));
    for (name, within) in [("cell-1", None), ("cell-2", Some(PATIENCE))] {
        let cell = Cell::new(name).unwrap();
        let there = alive.instances_for(&cell).len();
        assert_eq!(there, usize::from(within.is_some()), "{name}");
        let request = evaluate(&grid(32, 4), block(5, 4), 1, Heuristic::Sdfm);
        let deadline = Instant::now() + within.unwrap_or(Duration::from_millis(500));
        let answer = rig.client.call(&cell, request, deadline);
        assert_eq!(answer.is_ok(), within.is_some(), "{name}");
    }
}

/// A square container of so many cells of 1 mm a side.
fn grid(cells: usize, yaws: usize) -> Grid {
    let side_m = cells as f64 * 0.001;
    let resolution = Resolution::new(0.001, 0.002, Yaws::half_turn(yaws).unwrap());
    let container = ContainerSize::cuboid(side_m, side_m, 0.3);
    Grid::new(container, resolution.unwrap()).unwrap()
}

fn scene(grid: &Grid) -> v1::Scene {
    let heights = (0..grid.nx() * grid.ny()).map(|cell| (cell * 7919 % 31) as i16);
    let heightmap = Heightmap::from_units(grid.nx(), grid.ny(), heights.collect());
    convert::scene::write(grid, &Scene::from_heightmap(heightmap.unwrap()))
}

fn block(side: usize, yaws: usize) -> v1::Item {
    let cells = side * side;
    let view = ViewSurfaces::of_cells(side, side, vec![40; cells], vec![0; cells]);
    convert::item::write(&Item::new("block", vec![view; yaws], 0.0).unwrap())
}

/// All placements of so many items of a shape.
fn evaluate(
    grid: &Grid,
    item: v1::Item,
    candidates: u32,
    heuristic: Heuristic,
) -> v1::EvaluateRequest {
    let settings = SearchSettings {
        heuristic,
        ..SearchSettings::default()
    };
    let candidate = |arrival: u32| v1::CandidateItem {
        item_id: ItemId::of(&item).to_bytes(),
        arrival: arrival.into(),
        ..v1::CandidateItem::default()
    };
    v1::EvaluateRequest {
        scene: Some(scene(grid)),
        candidates: (0..candidates).map(candidate).collect(),
        parts: (0..candidates)
            .map(|candidate| v1::SearchPart {
                candidate,
                proposals: None,
            })
            .collect(),
        objective: Some(convert::objective::write(&settings)),
        limit: 65_536,
        items: vec![item],
        ..v1::EvaluateRequest::default()
    }
}

#[test]
fn a_search_ends_when_its_time_is_over_and_the_worker_is_free_again() {
    let rig = Rig::new(&Settings::default());
    let large = grid(400, 16);
    for heuristic in [Heuristic::Sdfm, Heuristic::Dbl] {
        let much = evaluate(&large, block(80, 16), 200, heuristic);
        rig.assert_timed_out(&much, Duration::from_secs(2));
        let began = Instant::now();
        let little = v1::EvaluateRequest {
            limit: 1,
            ..evaluate(&grid(64, 4), block(10, 4), 1, heuristic)
        };
        let found = rig.ask(little, PATIENCE).unwrap();
        assert_eq!(found.placements.len(), 1);
        assert!(began.elapsed() < Duration::from_secs(5));
    }
}

#[test]
fn more_work_than_may_be_asked_for_is_refused_before_it_is_begun() {
    let grid = grid(32, 4);
    let placements = 32 * 32 * 4 * 10;
    let request = || evaluate(&grid, block(5, 4), 10, Heuristic::Sdfm);
    let enough = Settings {
        most_placements: placements,
        ..Settings::default()
    };
    assert!(Rig::new(&enough).ask(request(), PATIENCE).is_ok());
    let short = Settings {
        most_placements: placements - 1,
        ..Settings::default()
    };
    let refusal = Rig::new(&short).invalid(request());
    assert!(refusal.contains("most_placements"), "{refusal}");
    assert!(refusal.contains(&placements.to_string()), "{refusal}");
    // Also by default.
    let much = evaluate(&self::grid(256, 360), block(3, 360), 1_000, Heuristic::Sdfm);
    let refusal = Rig::new(&Settings::default()).invalid(much);
    assert!(refusal.contains("most_placements"), "{refusal}");
}

#[test]
fn a_search_that_needs_more_memory_than_there_is_is_refused_before_that_is_taken() {
    let rig = Rig::new(&Settings::default());
    // The maps of the container alone.
    let refusal = rig.invalid(evaluate(&grid(2048, 1), block(3, 1), 1, Heuristic::Sdfm));
    assert!(refusal.contains("searches_mib"), "{refusal}");
    // The resting heights of all placements, which this heuristic needs.
    let refusal = rig.invalid(evaluate(&grid(500, 16), block(30, 16), 40, Heuristic::Mta));
    assert!(refusal.contains("searches_mib"), "{refusal}");
}

#[test]
fn kept_searches_make_room_for_others() {
    let rig = Rig::new(&Settings {
        searches_mib: 32,
        ..Settings::default()
    });
    // Each takes some megabytes.
    for cells in (300..308).chain(300..308) {
        let request = v1::EvaluateRequest {
            limit: 1,
            ..evaluate(&grid(cells, 1), block(20, 1), 1, Heuristic::Sdfm)
        };
        assert_eq!(rig.ask(request, PATIENCE).unwrap().placements.len(), 1);
    }
}
