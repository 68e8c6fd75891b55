//! The search against the golden vectors of the published heuristics.

use ndarray::Array2;

use crate::support::*;

#[path = "../golden/cases.rs"]
mod cases;

use cases::{Case, cases};

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

#[test]
fn all_golden_cases_are_met() {
    let grid = Grid::reference();
    let cases = cases();
    assert_eq!(cases.len(), 40);
    let mut compared = 0;
    for case in &cases {
        let candidates = Candidate::sequence([item(case)]);
        let scene = Scene::from_heightmap(heightmap(case));
        let input = StepInput::new(&grid, &scene, &candidates);
        for (heuristic, expected) in [
            (Heuristic::Sdfm, &case.sdf),
            (Heuristic::Dbl, &case.dbl),
            (Heuristic::Hm, &case.hm),
        ] {
            let ranked = |is_bounded| {
                let mut search = searching(&grid, heuristic, Order::Balance, is_bounded);
                ranking(&mut search, &input, &all(&input))
            };
            let exhaustive = ranked(false);
            assert!(exhaustive.is_sorted_by(|one, other| one.rank_cmp(other).is_lt()));
            compared += compare(case, &grid, &exhaustive, expected);
            assert_eq!(ranked(true), exhaustive);
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
        let (value, expected) = (found.value, f64::from(expected[at]));
        // The vectors are stored as f32, whose steps exceed the tolerance for the largest values.
        let error = (f64::from(value as f32) - expected).abs();
        assert!(error <= 1e-3, "{place}: {value} instead of {expected}");
    }
    let fitting = case.drop.iter().filter(|height| **height >= 0).count();
    assert_eq!(compared, fitting, "{}: placements that fit", case.name);
    compared
}

#[test]
fn stability_is_that_of_the_golden_cases() {
    let grid = Grid::reference();
    let mut stability = PublishedStability::default();
    for case in &cases() {
        let (item, heightmap) = (item(case), heightmap(case));
        let view = &item.views()[0];
        for ((x, y), height) in case.drop.indexed_iter() {
            if *height < 0 {
                continue;
            }
            let at = resting([x, y], *height);
            let depth = stability.depth_cells(&grid, &heightmap, view, &at);
            if (depth - 0.5).abs() > 1e-6 {
                let is_stable = stability.is_stable(&grid, &heightmap, view, &at);
                let place = format!("{} at {x}, {y}: depth {depth}", case.name);
                assert_eq!(is_stable, case.stable[[x, y]] == 1, "{place}");
            }
        }
    }
}
