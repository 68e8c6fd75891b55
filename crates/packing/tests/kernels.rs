//! Every fast kernel against its slow, plain reference, on random containers, items, grids and yaws.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::objective::{Heuristic, Weights};
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::stability::{
    PhysicalStability, PhysicalStabilitySettings, PublishedStability,
};
use ppnpack_packing::survey::{Surveyed, survey};
use proptest::prelude::*;

mod support;

use support::oracle::Oracle;

fn resting(found: &Surveyed) -> RestingPlacement {
    RestingPlacement {
        placement: Placement {
            yaw: 0,
            x: found.x,
            y: found.y,
        },
        resting_height: found.resting_height,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn resting_heights_and_values_equal_the_oracle(
        (grid, heightmap, items) in support::scenes(1),
        weights in support::weights(),
    ) {
        for view in items[0].views() {
            let oracle = Oracle { grid: &grid, heightmap: &heightmap, view };
            for heuristic in [Heuristic::Sdfm, Heuristic::Dbl, Heuristic::Hm, Heuristic::Mta] {
                let surveyed = survey(&grid, &heightmap, view, heuristic, &weights).unwrap();
                for found in surveyed.iter().step_by(3) {
                    let at = resting(found);
                    let height = oracle.resting_height(at.placement);
                    prop_assert_eq!(height, Some(found.resting_height));
                    let expected = oracle.value(&at, heuristic, &weights, true);
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
    fn published_stability_equals_the_oracle((grid, heightmap, items) in support::scenes(1)) {
        for view in items[0].views() {
            let surveyed =
                survey(&grid, &heightmap, view, Heuristic::Dbl, &Weights::default()).unwrap();
            let oracle = Oracle { grid: &grid, heightmap: &heightmap, view };
            for found in &surveyed {
                let at = resting(found);
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
        (grid, heightmap, items) in support::scenes(1),
        is_fine in any::<bool>(),
        seed in any::<u16>(),
    ) {
        let (scene, item) = if is_fine {
            support::finely_sampled(&grid, &heightmap, &items[0], seed)
        } else {
            (Scene::from_heightmap(heightmap.clone()), items[0].clone())
        };
        let settings = PhysicalStabilitySettings::default();
        for view in item.views() {
            let surveyed =
                survey(&grid, &heightmap, view, Heuristic::Dbl, &Weights::default()).unwrap();
            let oracle = Oracle { grid: &grid, heightmap: &heightmap, view };
            for found in surveyed.iter().step_by(7) {
                let at = resting(found);
                let depth = PhysicalStability::new(settings).depth_m(&grid, &scene, view, &at);
                let tolerance_m = settings.contact_tolerance_m;
                let expected = oracle.physical_depth_m(at.placement, scene.surface(), tolerance_m);
                prop_assert!(agree(depth, expected), "depth {} instead of {}", depth, expected);
            }
        }
    }
}

/// Whether two depths in a hull are the same. Outside of it the two measure different distances, but both are negative.
fn agree(depth: f64, expected: f64) -> bool {
    if expected < -1e-9 {
        depth < 0.0
    } else {
        (depth - expected).abs() < 1e-9
    }
}

#[test]
fn the_largest_heights_do_not_overflow() {
    use ppnpack_packing::grid::{ContainerSize, Grid, MAX_UNITS, Resolution, Yaws};
    use ppnpack_packing::heightmap::Heightmap;
    use ppnpack_packing::item::{Item, ViewSurfaces};
    for seed in [0, 1, 50, 99] {
        let container = ContainerSize {
            x_m: 0.3,
            y_m: 0.3,
            z_m: f64::from(MAX_UNITS) * 0.001,
        };
        let resolution = Resolution::new(0.01, 0.001, Yaws::half_turn(1).unwrap()).unwrap();
        let grid = Grid::new(container, resolution).unwrap();
        let top = vec![MAX_UNITS - seed; 60];
        let surfaces = ViewSurfaces::of_cells(3, 20, top, vec![0; 60]);
        let item = Item::new("tower", vec![surfaces], 0.0).unwrap();
        let mut heightmap = Heightmap::empty(&grid);
        heightmap.raise(1, 1, seed);
        let view = &item.views()[0];
        let found = survey(
            &grid,
            &heightmap,
            view,
            Heuristic::Sdfm,
            &Weights::default(),
        )
        .unwrap();
        let oracle = Oracle {
            grid: &grid,
            heightmap: &heightmap,
            view,
        };
        for found in found.iter().step_by(97) {
            let expected = oracle.mean_distance(&resting(found));
            let constant = found.value - f64::from(found.resting_height) * 0.5 - 2.5 * expected;
            let voxels = view.voxel_count() as f64;
            let share = 1.0 - (voxels / grid.voxel_count()).cbrt();
            assert!((constant - 80.0 * share).abs() < 1e-6, "{constant}");
        }
    }
}
