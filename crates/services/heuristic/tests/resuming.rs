//! Rankings that go on where they stopped: pages equal the whole, and nothing of another ranking slips in.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

use std::time::{Duration, Instant};

use nalgebra::{Point2, Vector3};
use ppnpack_heuristic::Settings;
use ppnpack_packing::grid::{Grid, Units};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::Heuristic;
use ppnpack_packing::search::SearchSettings;
use ppnpack_service::Process;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_wire::convert;
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::v1::{self, RankedPlacement, Status};

/// More than any of these rankings has.
const ALL: u32 = 65_536;

/// A running heuristic service, and who asks it.
struct Rig {
    client: Client,
    _service: ppnpack_heuristic::Heuristic,
    _process: Process,
    _hub: Hub,
}

impl Rig {
    fn new() -> Self {
        Self::with(&Settings::default())
    }

    fn with(settings: &Settings) -> Self {
        let hub = embedded::hub().unwrap();
        let process = embedded::process(&hub, Service::Heuristic, "heuristic-1").unwrap();
        Self {
            client: Client::new(&embedded::session(&hub).unwrap()),
            _service: ppnpack_heuristic::start(&process, settings).unwrap(),
            _process: process,
            _hub: hub,
        }
    }

    fn evaluate(&self, request: v1::EvaluateRequest) -> Result<v1::EvaluateReply, CallError> {
        let deadline = Instant::now() + Duration::from_secs(60);
        let cell = Cell::new("cell-1").unwrap();
        self.client.call(&cell, request, deadline)
    }

    fn placements(&self, request: v1::EvaluateRequest) -> Vec<RankedPlacement> {
        self.evaluate(request).unwrap().placements
    }

    /// The whole ranking, by pages of this size.
    fn by_pages(&self, request: &v1::EvaluateRequest, limit: u32) -> Vec<RankedPlacement> {
        let mut all: Vec<RankedPlacement> = Vec::new();
        loop {
            let page = self.evaluate(v1::EvaluateRequest {
                limit,
                after: all.last().copied(),
                ..request.clone()
            });
            let page = page.unwrap();
            assert!(page.placements.len() <= limit as usize);
            assert!(page.is_complete || page.placements.len() == limit as usize);
            all.extend(page.placements);
            if page.is_complete {
                return all;
            }
        }
    }
}

/// A block of this many cells each way, 2 cm high.
fn block(nx: usize, ny: usize) -> v1::Item {
    let view = |nx: usize, ny: usize| ViewSurfaces {
        nx,
        ny,
        top: vec![10; nx * ny],
        bottom: vec![0; nx * ny],
        underside: None,
        origin_from_corner_m: Vector3::new(nx as f64 * 0.005, ny as f64 * 0.005, 0.0),
        centre_of_mass_m: Some(Point2::new(nx as f64 * 0.005, ny as f64 * 0.005)),
    };
    let views = (0..4).map(|yaw| {
        if yaw % 2 == 0 {
            view(nx, ny)
        } else {
            view(ny, nx)
        }
    });
    convert::item::write(&Item::new("block", views.collect(), 0.0).unwrap())
}

/// Two blocks in a container whose floor is raised by this many units.
fn request(raised: Units) -> v1::EvaluateRequest {
    request_for(vec![block(26, 20), block(30, 28)], raised)
}

/// Two items in such a container.
fn request_for(items: Vec<v1::Item>, raised: Units) -> v1::EvaluateRequest {
    let grid = Grid::reference();
    let (nx, ny) = (grid.nx(), grid.ny());
    let heightmap = Heightmap::from_units(nx, ny, vec![raised; nx * ny]).unwrap();
    let scene = Scene::from_heightmap(heightmap);
    let ids = items.iter().map(ItemId::of);
    let candidates = (0..).zip(ids).map(|(arrival, id)| v1::CandidateItem {
        item_id: id.to_bytes(),
        arrival,
        ..v1::CandidateItem::default()
    });
    v1::EvaluateRequest {
        scene: Some(convert::scene::write(&grid, &scene)),
        candidates: candidates.collect(),
        parts: (0..2)
            .map(|candidate| v1::SearchPart {
                candidate,
                first_yaw: 0,
                yaw_count: 4,
                proposals: None,
            })
            .collect(),
        objective: Some(convert::objective::write(&SearchSettings::default())),
        limit: ALL,
        items,
        ..v1::EvaluateRequest::default()
    }
}

fn named(ranking_id: &str, request: v1::EvaluateRequest) -> v1::EvaluateRequest {
    v1::EvaluateRequest {
        ranking_id: ranking_id.to_owned(),
        ..request
    }
}

#[test]
fn pages_are_the_whole_ranking() {
    let rig = Rig::new();
    let whole = rig.placements(request(0));
    assert!(whole.len() > 100, "{}", whole.len());
    assert!(whole.is_sorted_by(|a, b| a.value <= b.value));
    for limit in [1, 7, ALL] {
        assert_eq!(rig.by_pages(&named("r", request(0)), limit), whole);
    }
    // Without an id nothing is kept: each page ranks anew, and leaves out what came before.
    assert_eq!(rig.by_pages(&request(0), 64), whole);
}

#[test]
fn a_ranking_goes_on_although_its_items_were_let_go() {
    // No item is kept from one request to the next.
    let rig = Rig::with(&Settings {
        items_kept_mib: 0,
        ..Settings::default()
    });
    // This heuristic's search keeps resting heights by item; it looks at the small block's once the large one's
    // placements were given.
    let settings = SearchSettings {
        heuristic: Heuristic::Mta,
        ..SearchSettings::default()
    };
    let request = v1::EvaluateRequest {
        objective: Some(convert::objective::write(&settings)),
        ..request_for(vec![block(26, 20), block(1, 1)], 0)
    };
    let whole = rig.placements(request.clone());
    assert_eq!(whole.len(), 4 * (7 * 13 + 32 * 32));
    assert_eq!(rig.by_pages(&named("r", request), 300), whole);
}

#[test]
fn an_id_with_other_content_is_another_ranking() {
    let rig = Rig::new();
    let first = |raised| v1::EvaluateRequest {
        limit: 1,
        ..named("r", request(raised))
    };
    let lower = rig.placements(first(0));
    let after = |raised| v1::EvaluateRequest {
        after: lower.last().copied(),
        ..first(raised)
    };
    // What was given rests at another height in the other container.
    let refused = rig.evaluate(after(5)).unwrap_err();
    assert_eq!(refused.status(), Some(Status::Invalid), "{refused}");
    assert!(refused.to_string().contains("after:"), "{refused}");
    assert_eq!(
        rig.placements(first(5)),
        rig.placements(v1::EvaluateRequest {
            limit: 1,
            ..request(5)
        })
    );
    // The first ranking goes on as if nothing had been between.
    assert_eq!(rig.placements(after(0)), rig.placements(request(0))[1..2]);
}

#[test]
fn a_placement_of_another_ranking_is_refused() {
    let rig = Rig::new();
    let mut after = rig.placements(request(0)).remove(0);
    after.value += 1.0;
    let refused = rig.evaluate(v1::EvaluateRequest {
        after: Some(after),
        ..named("r", request(0))
    });
    let refused = refused.unwrap_err();
    assert_eq!(refused.status(), Some(Status::Invalid), "{refused}");
}
