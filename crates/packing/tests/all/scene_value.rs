//! The value of a scene: its figures by their definitions, and the ranking that follows.

use ppnpack_packing::ranking::scene_value::{FIGURES, Farsighted, SceneValue, Squares, figures};

use crate::support::*;

/// 20 x 16 cm, 30 cm high.
fn grid(cell_m: f64, yaws: usize) -> Grid {
    let cells = [0.2, 0.16].map(|side_m: f64| (side_m / cell_m).round() as usize);
    grid_of(cells, cell_m, 150, yaws)
}

fn search(grid: &Grid) -> Box<Search> {
    Box::new(searching(grid, Heuristic::Sdfm, Order::Balance, false))
}

#[test]
fn impossible_values_are_named() {
    let value = |weight, coefficients| SceneValue {
        weight,
        coefficients,
    };
    SceneValue::default().validate().unwrap();
    value(1.0, vec![0.5; FIGURES]).validate().unwrap();
    assert!(SceneValue::default().is_on() && !SceneValue::off().is_on());
    for (weight, coefficients, named) in [
        (-1.0, vec![], "weight"),
        (1.0, vec![1.0], "coefficient"),
        (1.0, vec![f64::NAN; FIGURES], "coefficient"),
    ] {
        let refused = value(weight, coefficients).validate().unwrap_err();
        assert!(refused.to_string().contains(named));
    }
}

#[test]
fn without_value_the_ranking_is_the_objectives_but_for_nothing() {
    let grid = grid(0.02, 2);
    let candidates = Candidate::sequence([block(&grid, [3, 2], 5), block(&grid, [1, 2], 40)]);
    let scene = empty(&grid);
    let input = StepInput::new(&grid, &scene, &candidates);
    let expected = ranking(&mut *search(&grid), &input, &all(&input));
    let none = SceneValue {
        coefficients: vec![0.0; FIGURES],
        weight: 1e-9,
    };
    let mut farsighted = Farsighted::new(search(&grid), &none);
    let mut anew = ranking(&mut farsighted, &input, &all(&input));
    // Each once, whatever the order; the best of each item first.
    assert_eq!(anew[0], expected[0]);
    anew.sort_by(Evaluated::rank_cmp);
    assert_eq!(anew, expected);
    // A candidate that is left out is not given any more.
    farsighted.rank(&input, &[0, 1], &all(&input)).unwrap();
    let first = farsighted.next_best(&input).unwrap().unwrap();
    farsighted.leave_out(first.candidate);
    assert!(rest(&mut farsighted, &input).all(|next| next.candidate != first.candidate));
}

#[test]
fn a_placement_that_leaves_more_goes_first_as_far_as_its_weight_goes() {
    let grid = grid(0.02, 1);
    // A wall of half the rim along one side: beside it the largest rectangle is left.
    let candidates = Candidate::sequence([block(&grid, [2, 2], 20)]);
    let mut heightmap = Heightmap::empty(&grid);
    (0..grid.ny()).for_each(|y| heightmap.raise(9, y, 75));
    let scene = Scene::from_heightmap(heightmap);
    let input = StepInput::new(&grid, &scene, &candidates);
    let rectangle = |placement: &Evaluated| {
        let view = &candidates[0].item.views()[0];
        let after = Squares::of(&grid, scene.heightmap()).with(view, &placement.resting);
        // Of the largest rectangle below 10 % of the rim.
        figures(&input, &after, 0)[18]
    };
    let mut coefficients = vec![0.0; FIGURES];
    coefficients[18] = 1.0;
    let value = SceneValue {
        weight: 1e4,
        coefficients,
    };
    let ranked = ranking(
        &mut Farsighted::new(search(&grid), &value),
        &input,
        &all(&input),
    );
    // Of one item on this grid at least ten placements are valued.
    let most = ranked[..10].iter().map(rectangle).fold(0.0, f64::max);
    let left = rectangle(&ranked[0]);
    assert!(left >= most && left > 0.0, "{left} {most}");
}

/// Figures as their definitions read, of squares that are cells.
fn plain(heights: &[Vec<f32>]) -> Vec<f64> {
    let (nx, ny) = (heights.len(), heights[0].len());
    let all: Vec<f32> = heights.concat();
    let mean = |values: &[f32]| {
        values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
    };
    let squares = |values: &[f32]| mean(&values.iter().map(|v| v * v).collect::<Vec<_>>());
    let room = |values: &[f32]| squares(&values.iter().map(|v| 1.0 - v).collect::<Vec<_>>());
    let mut sorted = all.clone();
    sorted.sort_by(f32::total_cmp);
    let deviation = (squares(&all) - mean(&all).powi(2)).max(0.0).sqrt();
    let mut plain = vec![mean(&all), deviation, f64::from(sorted[sorted.len() - 1])];
    for share in [0.1, 0.25, 0.5, 0.75, 0.9] {
        plain.push(f64::from(sorted[(share * sorted.len() as f64) as usize]));
    }
    let places = || (0..nx).flat_map(|x| (0..ny).map(move |y| (x, y)));
    let steps = places().map(|(x, y)| {
        let beside = [(x + 1, y), (x, y + 1)].into_iter();
        let beside = beside.filter_map(|(x, y)| heights.get(x)?.get(y));
        beside
            .map(|other| (heights[x][y] - other).abs())
            .sum::<f32>()
    });
    plain.push(f64::from(steps.sum::<f32>()) / all.len() as f64);
    plain.push(room(&all));
    for level in [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9] {
        let below = all.iter().filter(|height| **height <= level).count();
        plain.push(below as f64 / all.len() as f64);
    }
    for level in 1..10 {
        let level = level as f32 / 10.0;
        let is_free = |x: std::ops::Range<usize>, y: std::ops::Range<usize>| {
            let mut rows = heights[x].iter();
            rows.all(|row| row[y.clone()].iter().all(|height| *height <= level))
        };
        let mut largest = 0;
        for (x, y) in places() {
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
        let corners = places().filter(|(x, y)| x + side <= nx && y + side <= ny);
        let greatest = corners.map(|(x, y)| {
            let rows = heights[x..x + side].iter();
            let within = rows.flat_map(|row| row[y..y + side].iter().copied());
            within.fold(0.0, f32::max)
        });
        let greatest: Vec<f32> = greatest.collect();
        let least = greatest.iter().copied().fold(1.0, f32::min);
        let most = greatest.iter().copied().fold(0.0, f32::max);
        let free: Vec<f32> = greatest.iter().map(|g| (0.7 - g).max(0.0)).collect();
        plain.extend([mean(&greatest), f64::from(least), f64::from(most - least)]);
        plain.extend([mean(&free), room(&greatest)]);
    }
    let ends = heights.iter().flat_map(|row| [row[0], row[ny - 1]]);
    let walls = heights[0]
        .iter()
        .chain(&heights[nx - 1])
        .copied()
        .chain(ends);
    plain.push(mean(&walls.collect::<Vec<_>>()));
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
        let blocks = [([2, 3], 15), ([4, 2], 30), ([1, 1], 10)];
        let candidates = Candidate::sequence(blocks.map(|(cells, height)| block(&grid, cells, height)));
        let input = StepInput::new(&grid, &scene, &candidates);
        let found = figures(&input, &Squares::of(&grid, scene.heightmap()), 1);
        prop_assert_eq!(found.len(), FIGURES);
        let rows: Vec<Vec<f32>> = heights
            .chunks(16)
            .map(|row| row.iter().map(|height| (f32::from(*height) / 150.0).min(1.0)).collect())
            .collect();
        // The first and the last block wait.
        let container = 20.0 * 16.0 * 150.0;
        let (first, last) = (6.0 * 15.0, 10.0);
        let mut expected = plain(&rows);
        expected.extend([(first + last) / container; 2]);
        expected.extend([(15.0 + 10.0) / 150.0, 15.0 / 150.0, first / container, 0.2]);
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
        let item = block(&grid, [10, 10], 20);
        let at = resting([x, y], 45);
        let with = Squares::of(&grid, &heightmap).with(&item.views()[0], &at);
        for (x, y) in (x..x + 10).flat_map(|x| (y..y + 10).map(move |y| (x, y))) {
            heightmap.raise(x, y, 45 + 20);
        }
        prop_assert_eq!(with, Squares::of(&grid, &heightmap));
    }
}
