//! Whole planning steps at three grids.
//!
//! The container is half full, packed by SDFM itself. Objects are the built-in household set, or
//! those of the folder in `PPNPACK_BENCH_OBJECTS`. Every iteration sees another container than the
//! one before, all cells changed, so that nothing kept from the last step helps, except in
//! `episode`, which replays consecutive steps.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a panic here is a failing run"
)]

use std::hint::black_box;
use std::sync::Arc;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_packing::checks::check::BoxedCheck;
use ppnpack_packing::checks::stability::{PhysicalStability, PublishedStability};
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::kernel::heightmap::{Heightmap, Surface};
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::kernel::objective::{Heuristic, Order, Weights};
use ppnpack_packing::planning::containers::plan_over;
use ppnpack_packing::planning::plan::Planner;
use ppnpack_packing::planning::survey::survey;
use ppnpack_packing::ranking::evaluator::Evaluator;
use ppnpack_packing::ranking::proposals::{Percent, ProposeAll, ProposeRandom};
use ppnpack_packing::ranking::search::{Search, SearchSettings};
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_packing::scene::Scene;
use ppnpack_packing::streams::episode::{IdealCell, Observer, Play, Step, play};
use ppnpack_packing::streams::orders::{ContainerRules, OrderItem, Orders};

/// A grid of the reference container: cell in metres, yaws and a name.
type NamedGrid = (f64, usize, &'static str);

/// The paper's grid and two finer ones.
const GRIDS: [NamedGrid; 3] = [
    (0.01, 4, "1 cm, 4 yaws"),
    (0.005, 8, "5 mm, 8 yaws"),
    (0.0025, 16, "2.5 mm, 16 yaws"),
];

fn grid((cell_m, yaws, _): NamedGrid) -> Grid {
    let resolution = Resolution::new(cell_m, 0.002, Yaws::half_turn(yaws).unwrap()).unwrap();
    Grid::new(ContainerSize::REFERENCE, resolution).unwrap()
}

/// The objects, as they are packed on a grid: the built-in ones, or those of the folder in
/// `PPNPACK_BENCH_OBJECTS`.
fn catalogue(grid: &Grid) -> Catalogue {
    let named = std::env::var("PPNPACK_BENCH_OBJECTS");
    let name = named.as_deref().unwrap_or(ppnpack_household::BUILTIN);
    let settings = Settings::default();
    let source = ppnpack_household::source(name);
    Catalogue::load(&source, &settings, grid.resolution(), &|_, _| {}).unwrap()
}

const BUFFER: usize = 5;

struct Setting {
    name: &'static str,
    grid: Grid,
    /// Consecutive scenes of an episode, with the buffer each was planned for.
    steps: Vec<(Scene, Vec<Candidate>)>,
}

impl Setting {
    fn new(named: NamedGrid) -> Self {
        let (_, _, name) = named;
        let grid = grid(named);
        let catalogue = catalogue(&grid);
        // 37 is coprime to the usual catalogue sizes, so this visits all objects in a mixed order.
        let objects = (0..80).map(|arrival| (arrival * 37 + 11) % catalogue.len());
        let sequence =
            Candidate::sequence(objects.map(|object| catalogue.get(object).unwrap().item.clone()));
        let mut recorder = Recorder { steps: vec![] };
        let mut planner = planner(search(&grid, Heuristic::Sdfm), published());
        let mut cell = IdealCell::new(&grid);
        let how = Play::with_buffer(BUFFER);
        play(&grid, &mut planner, &mut cell, sequence, how, &mut recorder).unwrap();
        Self {
            name,
            grid,
            steps: recorder.steps,
        }
    }

    /// The step at which the container is half full, and the same with every cell one unit higher.
    fn half_full(&self) -> ([&Scene; 1], Scene, &[Candidate]) {
        let (scene, candidates) = &self.steps[self.steps.len() / 2];
        let heights = scene.heightmap().heights().iter();
        let raised = heights.map(|height| height + 1).collect();
        let raised = Heightmap::from_units(self.grid.nx(), self.grid.ny(), raised).unwrap();
        ([scene], with_surface(&self.grid, &raised), candidates)
    }
}

/// Records the scenes and buffers of an episode.
struct Recorder {
    steps: Vec<(Scene, Vec<Candidate>)>,
}

impl Observer for Recorder {
    fn on_step(&mut self, _step: &Step, input: &StepInput<'_>) {
        let scene = with_surface(input.grid, input.scene.heightmap());
        self.steps.push((scene, input.candidates.to_vec()));
    }
}

/// The scene with a fine surface that has the cells' heights.
fn with_surface(grid: &Grid, heightmap: &Heightmap) -> Scene {
    let samples = grid.resolution().samples_per_cell();
    let unit_m = grid.resolution().height_unit_m() as f32;
    let mut surface = Surface::empty(grid);
    for x in 0..surface.nx() {
        for y in 0..surface.ny() {
            let height = heightmap.get(x / samples, y / samples).unwrap();
            surface.raise(x, y, f32::from(height) * unit_m);
        }
    }
    Scene::from_surface(grid, surface).unwrap()
}

fn search(grid: &Grid, heuristic: Heuristic) -> Search {
    let settings = SearchSettings {
        heuristic,
        order: Order::Balance,
        ..SearchSettings::default()
    };
    Search::new(grid, &settings).unwrap()
}

/// A planner that looks at all placements.
fn planner(search: impl Evaluator + 'static, check: BoxedCheck) -> Planner {
    let (proposer, search) = (Box::new(ProposeAll), Box::new(search));
    Planner::new(proposer, search, vec![check], Order::Balance, 0)
}

/// The same choices, looking only where a bound does not rule out the best.
fn bounded_planner(grid: &Grid) -> Planner {
    planner(search(grid, Heuristic::Sdfm).bounded(), physical())
}

fn physical() -> BoxedCheck {
    Box::new(PhysicalStability::new(Default::default()))
}

fn published() -> BoxedCheck {
    Box::new(PublishedStability::default())
}

fn steps(criterion: &mut Criterion) {
    for setting in GRIDS.map(Setting::new) {
        let Setting { name, grid, .. } = &setting;
        let ([scene], raised, candidates) = setting.half_full();
        let mut group = criterion.benchmark_group("step");
        group.sample_size(30);
        let mut alternate = |label: &str, mut planner: Planner| {
            let mut step = 0_u64;
            group.bench_function(BenchmarkId::new(label, name), |bencher| {
                bencher.iter(|| {
                    step += 1;
                    let scene = [scene, &raised][step as usize % 2];
                    let input = StepInput {
                        step,
                        ..StepInput::new(grid, scene, candidates)
                    };
                    black_box(planner.plan(&input).unwrap().choice())
                });
            });
        };
        let sdfm = || search(grid, Heuristic::Sdfm);
        alternate("SDFM, published stability", planner(sdfm(), published()));
        alternate("SDFM, physical stability", planner(sdfm(), physical()));
        alternate("SDFM, bounded", bounded_planner(grid));
        let five = Box::new(ProposeRandom::new(Percent::new(5.0).unwrap(), 0));
        let checks = vec![physical()];
        let random = Planner::new(five, Box::new(sdfm()), checks, Order::Balance, 0);
        alternate("SDFM on a random 5 %", random);
        // The touching area has no useful bound, so MTA computes every value: seconds a step on the
        // finest grid.
        let heuristics = [Heuristic::Dbl, Heuristic::Hm, Heuristic::Mta];
        let bounded = if grid.nx() > 64 { 2 } else { 3 };
        for heuristic in heuristics.into_iter().take(bounded) {
            let planner = planner(search(grid, heuristic), physical());
            alternate(&format!("{heuristic:?}"), planner);
        }
        // Consecutive steps of an episode: the search keeps what did not change, unless it is
        // bounded.
        let every = planner(sdfm(), physical());
        let planners = [
            ("SDFM, mean over an episode", every),
            ("SDFM, bounded, mean over an episode", bounded_planner(grid)),
        ];
        for (label, mut planner) in planners {
            group.bench_function(BenchmarkId::new(label, name), |bencher| {
                bencher.iter_custom(|iterations| {
                    let started = std::time::Instant::now();
                    for _ in 0..iterations {
                        for (step, (scene, candidates)) in setting.steps.iter().enumerate() {
                            let step = step as u64;
                            let input = StepInput {
                                step,
                                ..StepInput::new(grid, scene, candidates)
                            };
                            black_box(planner.plan(&input).unwrap().choice());
                        }
                    }
                    started.elapsed() / setting.steps.len() as u32
                });
            });
        }
        // The work that the search saves: every value of every placement.
        group.sample_size(10);
        let id = BenchmarkId::new("SDFM, every value computed", name);
        group.bench_function(id, |bencher| {
            bencher.iter(|| {
                let (weights, heightmap) = (Weights::default(), scene.heightmap());
                for view in candidates.iter().flat_map(|held| held.item.views()) {
                    let values = survey(grid, heightmap, view, Heuristic::Sdfm, &weights);
                    black_box(values).unwrap();
                }
            });
        });
        group.finish();
    }
}

/// Four containers, filled by an eighth to a half, and one buffer.
fn containers(criterion: &mut Criterion) {
    for setting in GRIDS.into_iter().take(2).map(Setting::new) {
        let Setting { name, grid, .. } = &setting;
        let (_, _, candidates) = setting.half_full();
        let eighth = setting.steps.len() / 8;
        let scenes = [1, 2, 3, 4].map(|part| &setting.steps[part * eighth].0);
        let mut group = criterion.benchmark_group("containers");
        group.sample_size(30);
        let mut planners = scenes.map(|_| bounded_planner(grid));
        group.bench_function(BenchmarkId::new("four, each by itself", name), |bencher| {
            bencher.iter(|| {
                for (planner, scene) in planners.iter_mut().zip(scenes) {
                    let input = StepInput::new(grid, scene, candidates);
                    black_box(planner.plan(&input).unwrap().choice());
                }
            });
        });
        let all: Vec<usize> = (0..candidates.len()).collect();
        let attempts = [vec![all; 4]];
        let id = BenchmarkId::new("a step over four, the fullest", name);
        group.bench_function(id, |bencher| {
            bencher.iter(|| {
                let planned = plan_over(&attempts, candidates, |at, admitted| {
                    let at = 3 - at;
                    let input = StepInput::new(grid, scenes[at], admitted);
                    planners[at].plan(&input).cloned()
                });
                black_box(planned.unwrap())
            });
        });
        group.finish();
    }
}

/// The rules of a step over four containers and a buffer of 5, with orders that wait: made anew, as
/// the planner service does.
fn waiting_orders(criterion: &mut Criterion) {
    let view = ViewSurfaces::of_cells(1, 1, vec![1], vec![0]);
    let item = Arc::new(Item::new("cell", vec![view], 0.0).unwrap());
    let held = (40..45).map(|arrival| Candidate::new(arrival, Arc::clone(&item)));
    let buffer: Vec<Candidate> = held.collect();
    let rules = ContainerRules {
        undivided: true,
        apart: vec![("0".to_owned(), "1".to_owned())],
        together: vec![("2".to_owned(), "3".to_owned())],
        most_kg: Some(15.0),
        ..ContainerRules::default()
    };
    let mut group = criterion.benchmark_group("containers");
    for orders in [10, 300] {
        let lines = (0..orders * 3).map(|arrival| {
            let line = OrderItem {
                group: Some((arrival % 5).to_string().into()),
                mass_kg: Some(0.3),
                ..OrderItem::new((arrival / 3).to_string().into())
            };
            (arrival, line)
        });
        let lines: Vec<(usize, OrderItem)> = lines.collect();
        group.bench_function(BenchmarkId::new("rules of a step", orders), |bencher| {
            bencher.iter(|| {
                let mut orders = Orders::new(rules.clone(), lines.iter().cloned());
                (0..4).for_each(|_| orders.opened());
                (0..30).for_each(|arrival| orders.packed(arrival / 3 % 4, arrival));
                orders.begin(&buffer);
                orders.attempts(&[0, 1, 2, 3], &buffer)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, steps, containers, waiting_orders);
criterion_main!(benches);
