//! A search keeps to the time and the memory that it is given, however much it is asked for.

use std::time::{Duration, Instant};

use ppnpack_packing::ranking::search::TooMuchMemory;

use crate::support::*;

/// How much later than its deadline a search may end where other tests run beside.
const LATE: Duration = Duration::from_millis(500);

/// A square container of so many cells of 1 mm a side, with steps: no two places are quite alike.
fn rough(cells: usize, yaws: usize) -> (Grid, Scene) {
    let grid = grid_of([cells; 2], 0.001, 150, yaws);
    let heights = (0..grid.nx() * grid.ny()).map(|cell| (cell * 7919 % 31) as Units);
    let heightmap = Heightmap::from_units(grid.nx(), grid.ny(), heights.collect());
    (grid, Scene::from_heightmap(heightmap.unwrap()))
}

fn search(grid: &Grid, heuristic: Heuristic, is_bounded: bool) -> Search {
    searching(grid, heuristic, Order::Balance, is_bounded)
}

/// Begins to rank everything.
fn rank(search: &mut Search, input: &StepInput<'_>) -> StageResult {
    let group: Vec<usize> = (0..input.candidates.len()).collect();
    search.rank(input, &group, &all(input))
}

#[test]
fn a_search_stops_at_its_deadline_however_much_there_is_to_search() {
    let (grid, scene) = rough(500, 16);
    let candidates = Candidate::sequence(vec![block(&grid, [90, 90], 40); 200]);
    for heuristic in HEURISTICS {
        for is_bounded in [true, false] {
            let mut search = search(&grid, heuristic, is_bounded);
            let deadline = Instant::now() + Duration::from_millis(60);
            let input = StepInput {
                deadline: Some(deadline),
                ..StepInput::new(&grid, &scene, &candidates)
            };
            rank(&mut search, &input).unwrap();
            rest(&mut search, &input).for_each(drop);
            let late = deadline.elapsed();
            let of = format!("{heuristic:?}, bounded {is_bounded}");
            assert!(late < LATE, "{of}: {late:?} late");
            let shortfall = search.shortfall().unwrap();
            assert!(shortfall.is_cut, "{of}");
            assert!(shortfall.degraded[0].contains("time limit"), "{of}");
        }
    }
}

#[test]
fn a_search_that_was_cut_ranks_the_next_time_as_a_new_one_does() {
    let (grid, scene) = rough(48, 4);
    let candidates = Candidate::sequence([9, 13, 21].map(|side| block(&grid, [side; 2], 40)));
    let whole = StepInput::new(&grid, &scene, &candidates);
    let best = |search: &mut Search| -> Vec<Evaluated> {
        rank(search, &whole).unwrap();
        rest(search, &whole).take(500).collect()
    };
    for heuristic in HEURISTICS {
        for is_bounded in [true, false] {
            let mut cut = search(&grid, heuristic, is_bounded);
            for micros in [0, 20, 50, 100, 200, 400, 800] {
                let input = StepInput {
                    deadline: Some(Instant::now() + Duration::from_micros(micros)),
                    ..whole
                };
                ranking(&mut cut, &input, &all(&input));
            }
            let expected = best(&mut search(&grid, heuristic, is_bounded));
            assert_eq!(best(&mut cut), expected, "{heuristic:?}");
            assert!(!cut.shortfall().unwrap().is_cut);
        }
    }
}

#[test]
fn a_search_that_needs_more_memory_than_it_may_take_fails_before_it_takes_it() {
    let (grid, scene) = rough(200, 16);
    let many = Candidate::sequence(vec![block(&grid, [40, 40], 40); 100]);
    let much = StepInput::new(&grid, &scene, &many);
    for heuristic in HEURISTICS {
        let limit_bytes = Search::least_bytes(&grid, heuristic) + 100_000;
        for is_bounded in [true, false] {
            let mut search = search(&grid, heuristic, is_bounded).within_bytes(limit_bytes);
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
