use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::scene::Scene;
use ppnpack_service::Process;
use ppnpack_service::alive::{self, Alive};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, Client, Done, Incoming};
use ppnpack_wire::keys::{Cell, Service};

use super::*;

/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(20);

/// The number of places for the block of [`Step`] at one yaw.
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
fn evaluator(hub: &Hub) -> ServiceEvaluator {
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
    let own = Search::new(&Grid::reference(), &method.search_settings()).unwrap();
    ServiceEvaluator::new(peers, &method, own.bounded())
}

/// The whole ranking, and one placement more where it does not end.
fn ranked(evaluator: &mut ServiceEvaluator, input: &StepInput<'_>) -> Vec<Evaluated> {
    let mut proposals = Proposals::default();
    proposals.push_all();
    evaluator.rank(input, &[0], &proposals).unwrap();
    let next = || evaluator.next_best(input).unwrap();
    std::iter::from_fn(next).take(4 * PLACES + 1).collect()
}

#[test]
fn the_planner_searches_where_no_service_is_and_goes_on_where_one_stopped() {
    let hub = embedded::hub().unwrap();
    let (mut evaluator, step) = (evaluator(&hub), Step::new());
    let input = step.input();
    let whole = ranked(&mut evaluator, &input);
    assert_eq!(whole.len(), 4 * PLACES);
    let degraded = &evaluator.shortfall.degraded;
    assert!(degraded[0].contains("no heuristic service"), "{degraded:?}");

    let best = whole[..3].to_vec();
    let _served = served(&hub, &evaluator, move || best.clone());

    assert_eq!(ranked(&mut evaluator, &input), whole);
    assert_eq!(evaluator.shortfall.degraded, Vec::<String>::new());
}

/// Has a service answer every step with these placements, and say that there are no others.
fn served(
    hub: &Hub,
    evaluator: &ServiceEvaluator,
    answer: impl Fn() -> Vec<Evaluated> + Send + Sync + 'static,
) -> (alive::Token, rpc::Listener, Process) {
    let process = embedded::process(hub, Service::Heuristic, "heuristic-1").unwrap();
    let answer = move |incoming: Incoming<v1::EvaluateRequest>| {
        let placements = answer();
        let reply = v1::EvaluateReply {
            placements: placements
                .iter()
                .map(convert::placement::write_ranked)
                .collect(),
            is_complete: true,
            ..v1::EvaluateReply::default()
        };
        incoming.reply(reply, Done::default());
    };
    let listener = rpc::listen(&process, None, answer).unwrap();
    let announced = alive::announce(&process, None).unwrap();
    let deadline = Instant::now() + PATIENCE;
    let alive = &evaluator.peers.alive;
    assert!(alive.wait(deadline, |instances| !instances.is_empty()));
    (announced, listener, process)
}

#[test]
fn a_placement_that_a_service_makes_up_is_not_ranked_and_the_planner_says_so() {
    let hub = embedded::hub().unwrap();
    let (mut evaluator, step) = (evaluator(&hub), Step::new());
    let input = step.input();
    let whole = ranked(&mut evaluator, &input);
    let forged: Arc<Mutex<Vec<Evaluated>>> = Arc::default();
    let told = Arc::clone(&forged);
    let _served = served(&hub, &evaluator, move || told.lock().unwrap().clone());

    let lie = |change: fn(&mut Evaluated)| {
        let mut lie = whole[0];
        change(&mut lie);
        lie
    };
    for lie in [
        // 20 cm above the floor, resting on nothing.
        lie(|it| it.resting.resting_height += 100),
        lie(|it| it.resting.placement.x += 1_000),
        lie(|it| it.resting.placement.yaw = 9),
        lie(|it| it.candidate = 5),
    ] {
        *forged.lock().unwrap() = vec![whole[0], lie];
        assert_eq!(ranked(&mut evaluator, &input), whole, "{lie:?}");
        let degraded = &evaluator.shortfall.degraded;
        assert!(degraded[0].contains("heuristic-1 failed"), "{degraded:?}");
    }
    // The worst alone, for a value that nothing has, keeps nothing else out: values are the
    // planner's own.
    let worst = whole.last().copied().unwrap();
    let value = f64::MIN;
    *forged.lock().unwrap() = vec![Evaluated { value, ..worst }];
    let named = ranked(&mut evaluator, &input);
    assert_eq!(named[0], worst);
    assert_eq!(named[1..], whole[..whole.len() - 1]);
    assert_eq!(evaluator.shortfall.degraded, Vec::<String>::new());
}
