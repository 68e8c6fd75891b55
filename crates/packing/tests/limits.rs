//! A search keeps to the time and the memory that it is given, however much it is asked for.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_packing::evaluator::Evaluator;
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::Heuristic;
use ppnpack_packing::proposals::{Proposals, ProposeAll, Proposer};
use ppnpack_packing::search::{Search, SearchSettings, TooMuchMemory};
use ppnpack_packing::step::{Candidate, Evaluated, StepInput};

const HEURISTICS: [Heuristic; 6] = [
    Heuristic::Sdfm,
    Heuristic::Dbl,
    Heuristic::Hm,
    Heuristic::Mta,
    Heuristic::FirstFit,
    Heuristic::Random,
];

/// How much later than its deadline a search may end where other tests run beside.
const LATE: Duration = Duration::from_millis(500);

/// A square container of so many cells of 1 mm a side.
fn grid(cells: usize, yaws: usize) -> Grid {
    let side_m = cells as f64 * 0.001;
    let resolution = Resolution::new(0.001, 0.002, Yaws::half_turn(yaws).unwrap());
    let container = ContainerSize {
        x_m: side_m,
        y_m: side_m,
        z_m: 0.3,
    };
    Grid::new(container, resolution.unwrap()).unwrap()
}

/// Steps, so that no two places are quite alike.
fn rough(grid: &Grid) -> Scene {
    let heights = (0..grid.nx() * grid.ny()).map(|cell| (cell * 7919 % 31) as i16);
    let heightmap = Heightmap::from_units(grid.nx(), grid.ny(), heights.collect());
    Scene::from_heightmap(heightmap.unwrap())
}

fn block(side: usize, yaws: usize) -> Arc<Item> {
    let cells = side * side;
    let view = ViewSurfaces::of_cells(side, side, vec![40; cells], vec![0; cells]);
    Arc::new(Item::new("block", vec![view; yaws], 0.0).unwrap())
}

fn search(grid: &Grid, heuristic: Heuristic, is_bounded: bool) -> Search {
    let settings = SearchSettings {
        heuristic,
        ..SearchSettings::default()
    };
    let search = Search::new(grid, &settings).unwrap();
    if is_bounded { search.bounded() } else { search }
}

/// Begins to rank everything.
fn rank(
    search: &mut Search,
    input: &StepInput<'_>,
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let mut proposals = Proposals::default();
    ProposeAll.propose(input, &mut proposals).unwrap();
    let group: Vec<usize> = (0..input.candidates.len()).collect();
    search.rank(input, &group, &proposals)
}

/// The ranking down to so many placements.
fn ranking(search: &mut Search, input: &StepInput<'_>, most: usize) -> Vec<Evaluated> {
    rank(search, input).unwrap();
    std::iter::from_fn(|| search.next_best(input).unwrap())
        .take(most)
        .collect()
}

#[test]
fn a_search_stops_at_its_deadline_however_much_there_is_to_search() {
    let grid = grid(500, 16);
    let scene = rough(&grid);
    let candidates = Candidate::sequence(vec![block(90, 16); 200]);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
    let pool = Arc::new(pool.unwrap());
    for heuristic in HEURISTICS {
        for (is_bounded, is_parallel) in [(true, false), (false, false), (false, true)] {
            let mut search = search(&grid, heuristic, is_bounded);
            if is_parallel {
                search = search.with_pool(Arc::clone(&pool));
            }
            let deadline = Instant::now() + Duration::from_millis(60);
            let input = StepInput {
                deadline: Some(deadline),
                ..StepInput::new(&grid, &scene, &candidates)
            };
            rank(&mut search, &input).unwrap();
            while search.next_best(&input).unwrap().is_some() {}
            let late = deadline.elapsed();
            let of = format!("{heuristic:?}, bounded {is_bounded}, parallel {is_parallel}");
            assert!(late < LATE, "{of}: {late:?} late");
            let shortfall = search.shortfall().unwrap();
            assert!(shortfall.is_cut, "{of}");
            assert!(shortfall.degraded[0].contains("time limit"), "{of}");
        }
    }
}

#[test]
fn a_search_that_was_cut_ranks_the_next_time_as_a_new_one_does() {
    let grid = grid(48, 4);
    let scene = rough(&grid);
    let candidates = Candidate::sequence([block(9, 4), block(13, 4), block(21, 4)]);
    let whole = StepInput::new(&grid, &scene, &candidates);
    for heuristic in HEURISTICS {
        for is_bounded in [true, false] {
            let mut cut = search(&grid, heuristic, is_bounded);
            for micros in [0, 20, 50, 100, 200, 400, 800] {
                let input = StepInput {
                    deadline: Some(Instant::now() + Duration::from_micros(micros)),
                    ..whole
                };
                ranking(&mut cut, &input, usize::MAX);
            }
            let expected = ranking(&mut search(&grid, heuristic, is_bounded), &whole, 500);
            assert_eq!(ranking(&mut cut, &whole, 500), expected, "{heuristic:?}");
            assert!(!cut.shortfall().unwrap().is_cut);
        }
    }
}

#[test]
fn a_search_that_needs_more_memory_than_it_may_take_fails_before_it_takes_it() {
    let grid = grid(200, 16);
    let scene = rough(&grid);
    for heuristic in HEURISTICS {
        let limit_bytes = Search::least_bytes(&grid, heuristic) + 100_000;
        for is_bounded in [true, false] {
            let mut search = search(&grid, heuristic, is_bounded).within_bytes(limit_bytes);
            let many = Candidate::sequence(vec![block(40, 16); 100]);
            let much = StepInput::new(&grid, &scene, &many);
            let failed = rank(&mut search, &much).and_then(|()| {
                while search.next_best(&much)?.is_some() {}
                Ok(())
            });
            let error = failed.unwrap_err();
            assert!(error.is::<TooMuchMemory>(), "{heuristic:?}: {error}");
            // Lists grow by doubling.
            let held = search.held_bytes();
            assert!(
                held <= 2 * limit_bytes,
                "{heuristic:?}: {held} of {limit_bytes}"
            );
        }
    }
}
