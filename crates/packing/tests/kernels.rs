//! Every fast kernel against its slow, plain reference, on random containers, items, grids and yaws.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use ppnpack_packing::objective::{Heuristic, Weights};
use ppnpack_packing::oracle;
use ppnpack_packing::placement::{Placement, RestingPlacement};
use ppnpack_packing::stability::PublishedStability;
use ppnpack_packing::survey::survey;
use proptest::prelude::*;

mod support;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn resting_heights_and_values_equal_the_oracle((grid, heightmap, items) in support::scenes(1)) {
        let weights = Weights::default();
        for view in items[0].views() {
            for heuristic in [Heuristic::Sdfm, Heuristic::Dbl, Heuristic::Hm, Heuristic::Mta] {
                let surveyed = survey(&grid, &heightmap, view, heuristic, &weights).unwrap();
                for found in surveyed.iter().step_by(3) {
                    let at = Placement { yaw: 0, x: found.x, y: found.y };
                    let height = found.resting_height;
                    prop_assert_eq!(oracle::resting_height(&heightmap, view, at), Some(height));
                    let expected = oracle::value(
                        &grid, &heightmap, view, (at, height), (heuristic, &weights, true),
                    );
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
            for found in surveyed {
                let placement = Placement { yaw: 0, x: found.x, y: found.y };
                let resting = RestingPlacement { placement, resting_height: found.resting_height };
                let depth = PublishedStability::default()
                    .depth_cells(&grid, &heightmap, view, &resting);
                let expected = oracle::published_depth_cells(
                    &grid, &heightmap, view, placement, found.resting_height,
                );
                // Outside the hull the two measure different distances, but both are negative.
                let agree = if expected < -1e-9 { depth < 0.0 } else { (depth - expected).abs() < 1e-9 };
                prop_assert!(agree, "depth {} instead of {}", depth, expected);
            }
        }
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
        let surfaces = ViewSurfaces {
            nx: 3,
            ny: 20,
            top: vec![MAX_UNITS - seed; 60],
            bottom: vec![0; 60],
            underside: None,
            origin_from_corner_m: nalgebra::Vector3::zeros(),
            centre_of_mass_m: None,
        };
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
        for found in found.iter().step_by(97) {
            let at = Placement {
                yaw: 0,
                x: found.x,
                y: found.y,
            };
            let height = found.resting_height;
            let expected = oracle::mean_distance_by_column(&grid, &heightmap, view, at, height);
            let constant = found.value - f64::from(height) * 0.5 - 2.5 * expected;
            let voxels = view.voxel_count() as f64;
            let share = 1.0 - (voxels / grid.voxel_count()).cbrt();
            assert!((constant - 80.0 * share).abs() < 1e-6, "{constant}");
        }
    }
}
