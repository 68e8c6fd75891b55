//! The search against the golden vectors of the published heuristics.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::sync::Arc;

use ndarray::Array2;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::objective::Heuristic;
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::plan::{Candidate, Evaluated, Evaluator, StepInput};
use ppnpack_packing::proposals::Proposals;
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::PublishedStability;

#[path = "golden/cases.rs"]
mod cases;

use cases::{Case, DISTANCE_STEP, cases};

mod support;

use support::oracle::Oracle;

fn item(case: &Case) -> Arc<Item> {
    let (nx, ny) = case.top.dim();
    let [top, bottom] = [&case.top, &case.bottom].map(|map| map.iter().copied().collect());
    let surfaces = ViewSurfaces::of_cells(nx, ny, top, bottom);
    let item = Item::new("golden", vec![surfaces], 0.0).unwrap();
    assert_eq!(item.views()[0].height(), case.height);
    Arc::new(item)
}

fn heightmap(case: &Case) -> Heightmap {
    let (nx, ny) = case.container.dim();
    Heightmap::from_units(nx, ny, case.container.iter().copied().collect()).unwrap()
}

/// The item's placements in the order of a search, which has to be that of their values, then of x and y.
fn ranking(mut search: Search, input: &StepInput<'_>) -> Vec<Evaluated> {
    let mut proposals = Proposals::default();
    proposals.push_all();
    search.rank(input, &[0], &proposals).unwrap();
    let ranked: Vec<Evaluated> = std::iter::from_fn(|| search.next_best(input).unwrap()).collect();
    for pair in ranked.windows(2) {
        let [first, second] = [&pair[0], &pair[1]];
        let by_value = first.value.total_cmp(&second.value);
        let by_place = || first.resting.placement.cmp(&second.resting.placement);
        assert!(by_value.then_with(by_place).is_lt(), "{pair:?}");
    }
    ranked
}

#[test]
fn all_golden_cases_are_met() {
    let grid = Grid::reference();
    let cases = cases();
    assert_eq!(cases.len(), 40);
    let mut compared = 0;
    for case in &cases {
        let item = item(case);
        let candidates = [Candidate::new(0, item)];
        let scene = Scene::from_heightmap(heightmap(case));
        let input = StepInput::new(&grid, &scene, &candidates);
        for (heuristic, expected) in [
            (Heuristic::Sdfm, &case.sdf),
            (Heuristic::Dbl, &case.dbl),
            (Heuristic::Hm, &case.hm),
        ] {
            let settings = SearchSettings {
                heuristic,
                ..SearchSettings::default()
            };
            let search = || Search::new(&grid, &settings).unwrap();
            let exhaustive = ranking(search(), &input);
            compared += compare(case, &grid, &exhaustive, expected);
            assert_eq!(ranking(search().bounded(), &input), exhaustive);
        }
    }
    assert!(compared > 10_000, "only {compared} placements compared");
}

/// Compares the values of a ranking; returns of how many placements.
fn compare(case: &Case, grid: &Grid, ranked: &[Evaluated], expected: &Array2<f32>) -> usize {
    let mut compared = 0;
    for found in ranked {
        let at = (found.resting.placement.x, found.resting.placement.y);
        let place = format!("{} at {at:?}", case.name);
        let height = found.resting.resting_height;
        if case.drop[at] < 0 {
            // The vectors refuse a top that exactly reaches the rim; the engine accepts it.
            assert_eq!(height + case.height, grid.rim(), "{place}");
            continue;
        }
        compared += 1;
        assert_eq!(height, case.drop[at], "{place}: resting height");
        let expected = f64::from(expected[at]);
        // The vectors are stored as f32, whose steps exceed the tolerance for the largest values.
        let error = (f64::from(found.value as f32) - expected).abs();
        assert!(
            error <= 1e-3,
            "{place}: {} instead of {expected}",
            found.value
        );
    }
    let fitting = case.drop.iter().filter(|height| **height >= 0).count();
    assert_eq!(compared, fitting, "{}: placements that fit", case.name);
    compared
}

#[test]
fn stability_and_distances_are_those_of_the_golden_cases() {
    let grid = Grid::reference();
    for case in &cases() {
        let (item, heightmap) = (item(case), heightmap(case));
        let view = &item.views()[0];
        let oracle = Oracle {
            grid: &grid,
            heightmap: &heightmap,
            view,
        };
        let mut stability = PublishedStability::default();
        let fitting = || case.drop.indexed_iter().filter(|(_, height)| **height >= 0);
        for ((x, y), height) in fitting() {
            let resting = RestingPlacement {
                placement: Placement { yaw: 0, x, y },
                resting_height: *height,
            };
            let depth = stability.depth_cells(&grid, &heightmap, view, &resting);
            if (depth - 0.5).abs() > 1e-6 {
                assert_eq!(
                    stability.is_stable(&grid, &heightmap, view, &resting),
                    case.stable[[x, y]] == 1,
                    "{} at {x}, {y}: depth {depth}",
                    case.name
                );
            }
        }
        // The oracle is far slower, so it is compared on a thinned set of placements.
        let thinned = case.drop.indexed_iter().step_by(DISTANCE_STEP);
        for (((x, y), height), expected) in thinned.zip(&case.distance) {
            if *height < 0 {
                continue;
            }
            let placement = Placement { yaw: 0, x, y };
            let resting = RestingPlacement {
                placement,
                resting_height: *height,
            };
            let found = 2.5 * oracle.mean_distance(&resting);
            let error = (found - f64::from(*expected)).abs();
            assert!(
                error <= 1e-3,
                "{} at {x}, {y}: {found} instead of {expected}",
                case.name
            );
            assert_eq!(oracle.resting_height(placement), Some(*height));
        }
    }
}
