use std::sync::Arc;

use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::ViewSurfaces;
use ppnpack_packing::method::Method;
use ppnpack_packing::step::Candidate;
use ppnpack_service::alive::{self, Alive};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, Client, Done, Incoming};
use ppnpack_wire::keys::{Cell, Service};

use super::*;

/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(20);

/// Where the block of [`Step`] may lie at one yaw.
const PLACES: usize = 7 * 7;

/// A block of 26 x 26 cells and an empty container.
struct Step {
    grid: Grid,
    scene: Scene,
    candidates: Vec<Candidate>,
}

impl Step {
    fn new() -> Self {
        let grid = Grid::reference();
        let view = ViewSurfaces::of_cells(26, 26, vec![10; 26 * 26], vec![0; 26 * 26]);
        let item = Item::new("block", vec![view; 4], 0.0).unwrap();
        Self {
            scene: Scene::from_heightmap(Heightmap::empty(&grid)),
            candidates: Candidate::sequence([Arc::new(item)]),
            grid,
        }
    }

    fn input(&self) -> StepInput<'_> {
        StepInput::new(&self.grid, &self.scene, &self.candidates)
    }
}

/// Asks the heuristic services on a hub.
fn evaluator(hub: &Hub) -> SharedEvaluator {
    let session = embedded::session(hub).unwrap();
    let peers = Peers {
        cell: Cell::new("cell-1").unwrap(),
        client: Client::new(&session),
        alive: Arc::new(Alive::watch(&session, Service::Heuristic).unwrap()),
        limit: PATIENCE,
    };
    let method = Method {
        stability: Stability::None,
        ..Method::published()
    };
    let local = LocalSearches::new(&Grid::reference(), &method, usize::MAX).unwrap();
    SharedEvaluator::new(peers, local, false)
}

/// The whole ranking, and one placement more where it does not end.
fn ranked(evaluator: &mut SharedEvaluator, input: &StepInput<'_>) -> Vec<Evaluated> {
    let mut proposals = Proposals::default();
    proposals.push_all();
    evaluator.rank(input, &[0], &proposals).unwrap();
    let next = || evaluator.next_best(input).unwrap();
    std::iter::from_fn(next).take(4 * PLACES + 1).collect()
}

#[test]
fn searches_beyond_the_usual_number_lose_nothing() {
    let hub = embedded::hub().unwrap();
    let (mut evaluator, step) = (evaluator(&hub), Step::new());
    let input = step.input();
    let part = Part {
        candidate: 0,
        yaws: YawRange { first: 0, end: 1 },
        proposals: None,
    };
    let searches = MAX_SEARCHES + 2;
    for _ in 0..searches {
        let parts = std::slice::from_ref(&part);
        evaluator.search_here(&input, parts, None).unwrap();
    }
    let next = || evaluator.next_best(&input).unwrap();
    assert_eq!(std::iter::from_fn(next).count(), searches * PLACES);
}

#[test]
fn pages_grow_only_where_a_service_is_asked() {
    let hub = embedded::hub().unwrap();
    let (mut evaluator, step) = (evaluator(&hub), Step::new());
    let input = step.input();
    assert_eq!(ranked(&mut evaluator, &input).len(), 4 * PLACES);
    assert_eq!(evaluator.page, input.wanted());
}

#[test]
fn the_part_of_a_service_that_begins_anew_with_each_page_is_searched_here() {
    let hub = embedded::hub().unwrap();
    let (mut evaluator, step) = (evaluator(&hub), Step::new());
    let input = step.input();
    let whole = ranked(&mut evaluator, &input);
    assert_eq!(whole.len(), 4 * PLACES);

    let process = embedded::process(&hub, Service::Heuristic, "heuristic-1").unwrap();
    let best = convert::placement::write_ranked(&whole[0]);
    let answer = move |incoming: Incoming<v1::EvaluateRequest>| {
        let reply = v1::EvaluateReply {
            placements: vec![best],
            ..v1::EvaluateReply::default()
        };
        incoming.reply(reply, Done::default());
    };
    let _listener = rpc::listen(&process, None, answer).unwrap();
    let _alive = alive::announce(&process, None).unwrap();
    let deadline = Instant::now() + PATIENCE;
    let alive = &evaluator.peers.alive;
    assert!(alive.wait(deadline, |instances| !instances.is_empty()));

    assert_eq!(ranked(&mut evaluator, &input), whole);
    let degraded = &evaluator.shortfall.degraded;
    let is_why = |why: &String| why.contains("does not go on where it stopped");
    assert!(degraded.iter().any(is_why), "{degraded:?}");
}
