//! Every fast kernel against its slow, plain reference, on random containers, items and grids.

use ppnpack_packing::checks::stability::{PhysicalStability, PhysicalStabilitySettings};
use ppnpack_packing::kernel::grid::MAX_UNITS;
use ppnpack_packing::planning::survey::{Surveyed, survey};

use crate::support::oracle::Oracle;
use crate::support::*;

fn surveyed(found: &Surveyed) -> RestingPlacement {
    resting([found.x, found.y], found.resting_height)
}

/// Every placement of a view, as DBL surveys it.
fn everywhere(oracle: &Oracle<'_>) -> Vec<RestingPlacement> {
    let weights = Weights::default();
    let Oracle {
        grid,
        heightmap,
        view,
    } = *oracle;
    let found = survey(grid, heightmap, view, Heuristic::Dbl, &weights);
    found.unwrap().iter().map(surveyed).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn resting_heights_and_values_equal_the_oracle(
        (grid, heightmap, items) in scenes(1),
        weights in weights(),
    ) {
        for view in items[0].views() {
            let oracle = Oracle { grid: &grid, heightmap: &heightmap, view };
            for heuristic in &HEURISTICS[..4] {
                let all = survey(&grid, &heightmap, view, *heuristic, &weights).unwrap();
                for found in all.iter().step_by(3) {
                    let at = surveyed(found);
                    let height = oracle.resting_height(at.placement);
                    prop_assert_eq!(height, Some(found.resting_height));
                    let expected = oracle.value(&at, *heuristic, &weights, true);
                    let error = (found.value - expected).abs() / expected.abs().max(1.0);
                    prop_assert!(
                        error < 1e-9,
                        "{:?} at {:?}: {} instead of {}", heuristic, at, found.value, expected
                    );
                }
            }
        }
    }

    #[test]
    fn published_stability_equals_the_oracle((grid, heightmap, items) in scenes(1)) {
        for view in items[0].views() {
            let oracle = Oracle { grid: &grid, heightmap: &heightmap, view };
            for at in everywhere(&oracle) {
                let depth = PublishedStability::default().depth_cells(&grid, &heightmap, view, &at);
                let expected = oracle.published_depth_cells(&at);
                prop_assert!(agree(depth, expected), "depth {} instead of {}", depth, expected);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn physical_stability_equals_the_oracle(
        (grid, heightmap, items) in scenes(1),
        is_fine in any::<bool>(),
        seed in any::<u16>(),
    ) {
        let (scene, item) = if is_fine {
            finely_sampled(&grid, &heightmap, &items[0], seed)
        } else {
            (Scene::from_heightmap(heightmap.clone()), items[0].clone())
        };
        let settings = PhysicalStabilitySettings::default();
        for view in item.views() {
            let oracle = Oracle { grid: &grid, heightmap: &heightmap, view };
            for at in everywhere(&oracle).iter().step_by(7) {
                let depth = PhysicalStability::new(settings).depth_m(&grid, &scene, view, at);
                let tolerance_m = settings.contact_tolerance_m;
                let expected = oracle.physical_depth_m(at.placement, scene.surface(), tolerance_m);
                prop_assert!(agree(depth, expected), "depth {} instead of {}", depth, expected);
            }
        }
    }
}

/// Whether two depths in a hull are the same, or both negative: outside they measure differently.
fn agree(depth: f64, expected: f64) -> bool {
    if expected < -1e-9 {
        depth < 0.0
    } else {
        (depth - expected).abs() < 1e-9
    }
}

#[test]
fn the_largest_heights_do_not_overflow() {
    let grid = grid_of([30, 30], 0.01, MAX_UNITS, 1);
    for seed in [0, 1, 50, 99] {
        let item = block(&grid, [3, 20], MAX_UNITS - seed);
        let mut heightmap = Heightmap::empty(&grid);
        heightmap.raise(1, 1, seed);
        let view = &item.views()[0];
        let weights = Weights::default();
        let found = survey(&grid, &heightmap, view, Heuristic::Sdfm, &weights).unwrap();
        let oracle = Oracle {
            grid: &grid,
            heightmap: &heightmap,
            view,
        };
        for found in found.iter().step_by(97) {
            let expected = oracle.mean_distance(&surveyed(found));
            let constant = found.value - f64::from(found.resting_height) - 2.5 * expected;
            let share = 1.0 - (view.voxel_count() as f64 / grid.voxel_count()).cbrt();
            assert!((constant - 80.0 * share).abs() < 1e-6, "{constant}");
        }
    }
}
