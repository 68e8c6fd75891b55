use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::evaluator::Evaluator;
use crate::grid::{ContainerSize, Grid, Resolution, Units, Yaws};
use crate::heightmap::{Heightmap, Scene};
use crate::item::{Item, ViewSurfaces};
use crate::proposals::{Proposals, ProposeAll, Proposer};
use crate::search::{Search, SearchSettings};
use crate::step::{Candidate, Evaluated, StepInput};

/// 20 x 16 cm, 30 cm high.
fn grid(cell_m: f64, yaws: usize) -> Grid {
    let size = ContainerSize {
        x_m: 0.2,
        y_m: 0.16,
        z_m: 0.3,
    };
    let yaws = Yaws::half_turn(yaws).unwrap();
    Grid::new(size, Resolution::new(cell_m, 0.002, yaws).unwrap()).unwrap()
}

/// A block of so many cells and units, at every yaw the same.
fn block(name: &str, grid: &Grid, sides: (usize, usize), height: Units) -> Arc<Item> {
    let cells = sides.0 * sides.1;
    let view = ViewSurfaces::of_cells(sides.0, sides.1, vec![height; cells], vec![0; cells]);
    let views = vec![view; grid.resolution().yaws().count()];
    Arc::new(Item::new(name, views, 1e-4 * cells as f64).unwrap())
}

fn ranked(evaluator: &mut dyn Evaluator, input: &StepInput<'_>) -> Vec<Evaluated> {
    let mut proposals = Proposals::default();
    ProposeAll.propose(input, &mut proposals).unwrap();
    let group: Vec<usize> = (0..input.candidates.len()).collect();
    evaluator.rank(input, &group, &proposals).unwrap();
    std::iter::from_fn(|| evaluator.next_best(input).unwrap()).collect()
}

fn search(grid: &Grid) -> Box<Search> {
    Box::new(Search::new(grid, &SearchSettings::default()).unwrap())
}

#[test]
fn what_is_built_in_has_a_coefficient_for_each_figure() {
    let value = SceneValue::default();
    value.validate().unwrap();
    assert!(value.is_on() && !SceneValue::off().is_on());
    assert_eq!(value.in_use().len(), FIGURES);
    let own = SceneValue {
        coefficients: value.in_use(),
        ..value
    };
    own.validate().unwrap();
    assert_eq!(own.in_use(), SceneValue::default().in_use());
}

#[test]
fn impossible_values_are_named() {
    let refused = |value: SceneValue| value.validate().unwrap_err().to_string();
    let negative = SceneValue {
        weight: -1.0,
        ..SceneValue::default()
    };
    assert!(refused(negative).contains("weight"));
    for coefficients in [vec![1.0], vec![f64::NAN; FIGURES]] {
        let wrong = SceneValue {
            coefficients,
            ..SceneValue::default()
        };
        assert!(refused(wrong).contains("coefficient"));
    }
}

#[test]
fn without_value_the_ranking_is_the_objectives_but_for_nothing() {
    let grid = grid(0.02, 2);
    let candidates = Candidate::sequence([
        block("flat", &grid, (3, 2), 5),
        block("high", &grid, (1, 2), 40),
    ]);
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let input = StepInput::new(&grid, &scene, &candidates);
    let all = ranked(&mut *search(&grid), &input);
    let none = SceneValue {
        coefficients: vec![0.0; FIGURES],
        weight: 1e-9,
    };
    let mut farsighted = Farsighted::new(search(&grid), &none);
    let anew = ranked(&mut farsighted, &input);
    // Each once, whatever the order; the best of each item first.
    assert_eq!(anew.len(), all.len());
    let mut sorted = anew.clone();
    sorted.sort_by(Evaluated::rank_cmp);
    assert_eq!(sorted, all);
    assert_eq!(anew[0], all[0]);
}

#[test]
fn a_placement_that_leaves_more_goes_first_as_far_as_its_weight_goes() {
    let grid = grid(0.02, 1);
    // A wall of half the rim along one side: what lies beside it leaves the largest rectangle of floor.
    let candidates = Candidate::sequence([block("cube", &grid, (2, 2), 20)]);
    let mut heightmap = Heightmap::empty(&grid);
    (0..grid.ny()).for_each(|y| heightmap.raise(9, y, 75));
    let scene = Scene::from_heightmap(heightmap);
    let input = StepInput::new(&grid, &scene, &candidates);
    let rectangle = |placement: &Evaluated| {
        let view = &candidates[0].item.views()[0];
        let after = Squares::of(&grid, scene.heightmap()).with(view, &placement.resting);
        let low = figures(&input, &after, 0);
        // Of the largest rectangle below 10 % of the rim.
        low[18]
    };
    let mut coefficients = vec![0.0; FIGURES];
    coefficients[18] = 1.0;
    let first = |weight: f64| {
        let coefficients = coefficients.clone();
        let value = SceneValue {
            weight,
            coefficients,
        };
        let mut farsighted = Farsighted::new(search(&grid), &value);
        let ranked = ranked(&mut farsighted, &input);
        let most = ranked[..VALUED_AT_LEAST].iter().map(rectangle);
        (rectangle(&ranked[0]), most.fold(0.0, f64::max))
    };
    let (left, most) = first(1e4);
    assert!(left >= most && left > 0.0, "{left} {most}");
}

/// Of one item on this grid so many placements are valued.
const VALUED_AT_LEAST: usize = 10;

#[test]
fn a_candidate_that_is_left_out_is_not_given_any_more() {
    let grid = grid(0.02, 2);
    let candidates =
        Candidate::sequence([block("a", &grid, (2, 2), 5), block("b", &grid, (2, 3), 5)]);
    let scene = Scene::from_heightmap(Heightmap::empty(&grid));
    let input = StepInput::new(&grid, &scene, &candidates);
    let mut proposals = Proposals::default();
    ProposeAll.propose(&input, &mut proposals).unwrap();
    let mut farsighted = Farsighted::new(search(&grid), &SceneValue::default());
    farsighted.rank(&input, &[0, 1], &proposals).unwrap();
    let first = farsighted.next_best(&input).unwrap().unwrap();
    farsighted.leave_out(first.candidate);
    let rest = std::iter::from_fn(|| farsighted.next_best(&input).unwrap());
    let of_left_out = rest.filter(|next| next.candidate == first.candidate);
    assert_eq!(of_left_out.count(), 0);
}

/// Figures as their definitions read, of squares that are cells.
fn plain(heights: &[Vec<f32>]) -> Vec<f64> {
    let (nx, ny) = (heights.len(), heights[0].len());
    let all: Vec<f32> = heights.concat();
    let mean = |values: &[f32]| {
        values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
    };
    let squares = |values: &[f32]| mean(&values.iter().map(|v| v * v).collect::<Vec<_>>());
    let mut sorted = all.clone();
    sorted.sort_by(f32::total_cmp);
    let mut plain = vec![
        mean(&all),
        (squares(&all) - mean(&all).powi(2)).max(0.0).sqrt(),
        f64::from(sorted[sorted.len() - 1]),
    ];
    for share in [0.1, 0.25, 0.5, 0.75, 0.9] {
        plain.push(f64::from(sorted[(share * sorted.len() as f64) as usize]));
    }
    let mut steps = 0.0;
    for x in 0..nx {
        for y in 0..ny {
            if x + 1 < nx {
                steps += (heights[x][y] - heights[x + 1][y]).abs();
            }
            if y + 1 < ny {
                steps += (heights[x][y] - heights[x][y + 1]).abs();
            }
        }
    }
    plain.push(f64::from(steps) / all.len() as f64);
    let room = |values: &[f32]| squares(&values.iter().map(|v| 1.0 - v).collect::<Vec<_>>());
    plain.push(room(&all));
    for level in [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9] {
        let below = all.iter().filter(|height| **height <= level).count();
        plain.push(below as f64 / all.len() as f64);
    }
    for level in 1..10 {
        let level = level as f32 / 10.0;
        let is_free = |x: std::ops::Range<usize>, y: std::ops::Range<usize>| {
            x.clone()
                .all(|x| heights[x][y.clone()].iter().all(|height| *height <= level))
        };
        let mut largest = 0;
        for (x, y) in (0..nx).flat_map(|x| (0..ny).map(move |y| (x, y))) {
            for (to_x, to_y) in (x..=nx).flat_map(|x| (y..=ny).map(move |y| (x, y))) {
                let area = (to_x - x) * (to_y - y);
                if area > largest && is_free(x..to_x, y..to_y) {
                    largest = area;
                }
            }
        }
        plain.push(largest as f64 / all.len() as f64);
    }
    for side in [2, 4, 6, 8, 12, 16] {
        let side = side.min(nx).min(ny);
        let mut greatest = Vec::new();
        for (x, y) in (0..=nx - side).flat_map(|x| (0..=ny - side).map(move |y| (x, y))) {
            let rows = heights[x..x + side].iter();
            let within = rows.flat_map(|row| row[y..y + side].iter().copied());
            greatest.push(within.fold(0.0, f32::max));
        }
        let least = greatest.iter().copied().fold(1.0, f32::min);
        let most = greatest.iter().copied().fold(0.0, f32::max);
        let free: Vec<f32> = greatest.iter().map(|g| (0.7 - g).max(0.0)).collect();
        plain.extend([
            mean(&greatest),
            f64::from(least),
            f64::from(most - least),
            mean(&free),
            room(&greatest),
        ]);
    }
    let mut walls = Vec::new();
    walls.extend(heights[0].iter().chain(&heights[nx - 1]).copied());
    walls.extend(heights.iter().flat_map(|row| [row[0], row[ny - 1]]));
    plain.push(mean(&walls));
    plain
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_figures_are_as_their_definitions_read(
        heights in proptest::collection::vec(0_i16..170, 20 * 16),
    ) {
        let grid = grid(0.01, 1);
        let heightmap = Heightmap::from_units(20, 16, heights.clone()).unwrap();
        let scene = Scene::from_heightmap(heightmap);
        let candidates = Candidate::sequence([
            block("a", &grid, (2, 3), 15),
            block("b", &grid, (4, 2), 30),
            block("c", &grid, (1, 1), 10),
        ]);
        let input = StepInput::new(&grid, &scene, &candidates);
        let found = figures(&input, &Squares::of(&grid, scene.heightmap()), 1);
        prop_assert_eq!(found.len(), FIGURES);
        let rows: Vec<Vec<f32>> = heights
            .chunks(16)
            .map(|row| row.iter().map(|height| (f32::from(*height) / 150.0).min(1.0)).collect())
            .collect();
        let container_m3 = 0.2 * 0.16 * 0.3;
        let mut expected = plain(&rows);
        expected.extend([
            (6e-4 + 1e-4) / container_m3,
            (6.0 * 15.0 + 10.0) * 1e-4 * 0.002 / container_m3,
            (15.0 + 10.0) / 150.0,
            15.0 / 150.0,
            6e-4 / container_m3,
            0.2,
        ]);
        for (index, (found, expected)) in found.iter().zip(&expected).enumerate() {
            prop_assert!((found - expected).abs() < 1e-5, "{}: {} {}", index, found, expected);
        }
    }

    #[test]
    fn a_surface_with_an_item_is_that_of_the_heightmap_with_it(
        heights in proptest::collection::vec(0_i16..100, 80 * 64),
        x in 0_usize..70,
        y in 0_usize..54,
    ) {
        let grid = grid(0.0025, 1);
        let mut heightmap = Heightmap::from_units(80, 64, heights).unwrap();
        let item = block("a", &grid, (10, 10), 20);
        let view = &item.views()[0];
        let at = crate::placement::RestingPlacement {
            placement: crate::placement::Placement { yaw: 0, x, y },
            resting_height: 45,
        };
        let with = Squares::of(&grid, &heightmap).with(view, &at);
        heightmap.place(view, &at);
        prop_assert_eq!(with, Squares::of(&grid, &heightmap));
    }
}
