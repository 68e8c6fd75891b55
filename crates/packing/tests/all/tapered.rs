//! Containers whose walls lean outwards.

use ppnpack_packing::planning::survey::survey;
use ppnpack_packing::streams::closing::Fill;
use ppnpack_packing::streams::metrics::{Metrics, PackedVolume};

use crate::support::*;

/// A tote of 40 x 30 x 20 cm at the rim, 36 x 26 cm at the floor, with cells of this edge.
fn tote(cell_m: f64) -> Grid {
    let size = ContainerSize {
        draft_rad: 0.1_f64.atan(),
        corner_radius_m: 0.03,
        ..ContainerSize::cuboid(0.4, 0.3, 0.2)
    };
    let resolution = Resolution::new(cell_m, 0.002, Yaws::half_turn(4).unwrap());
    Grid::new(size, resolution.unwrap()).unwrap()
}

/// The greatest height of the inside below a rectangle of cells, in metres.
fn highest_m(grid: &Grid, [x, y]: [usize; 2], [nx, ny]: [usize; 2]) -> f64 {
    let cell_m = grid.resolution().cell_m();
    let corners = [(x, y), (x + nx, y), (x, y + ny), (x + nx, y + ny)];
    let heights = corners.map(|(x, y)| {
        let [x_m, y_m] = [x, y].map(|cells| cells as f64 * cell_m);
        grid.container().lowest_m(x_m, y_m)
    });
    heights.into_iter().fold(0.0, f64::max)
}

#[test]
fn an_empty_tote_is_as_high_as_its_walls_where_these_lean_in() {
    let grid = tote(0.01);
    let empty = Heightmap::empty(&grid);
    let row: Vec<Units> = (0..5).map(|x| empty.get(x, 15).unwrap()).collect();
    assert_eq!(row, [100, 50, 0, 0, 0]);
    let far: Vec<Units> = (35..40).map(|x| empty.get(x, 15).unwrap()).collect();
    assert_eq!(far, [0, 0, 0, 50, 100]);
    for (x, y) in (0..40).flat_map(|x| (0..30).map(move |y| (x, y))) {
        let expected = grid
            .resolution()
            .units_above(highest_m(&grid, [x, y], [1, 1]));
        assert_eq!(empty.get(x, y), Some(expected), "{x}, {y}");
    }
    let scene = Scene::from_surface(&grid, Surface::empty(&grid)).unwrap();
    assert_eq!(*scene.heightmap(), empty);
}

#[test]
fn a_block_beside_a_leaning_wall_neither_cuts_it_nor_floats() {
    let grid = tote(0.005);
    let unit_m = grid.resolution().height_unit_m();
    let empty = Heightmap::empty(&grid);
    let cells = [7, 9];
    let block = block(&grid, cells, 20);
    let view = &block.views()[0];
    let found = survey(&grid, &empty, view, Heuristic::Sdfm, &Weights::default()).unwrap();
    for at in found {
        let resting_m = f64::from(at.resting_height) * unit_m;
        let gap_m = resting_m - highest_m(&grid, [at.x, at.y], cells);
        assert!((-1e-6..unit_m).contains(&gap_m), "{at:?}: {gap_m}");
    }
}

#[test]
fn how_full_it_is_counts_by_what_is_between_its_walls() {
    let grid = tote(0.0025);
    let size = grid.container();
    let litres = 1000.0 * size.volume_m3();
    assert!((21.1..21.2).contains(&litres), "{litres}");
    let fill = Fill::of(0.5 * size.volume_m3(), size);
    assert!((fill.percent() - 50.0).abs() < 1e-9);
    let voxel_m3 = 0.0025 * 0.0025 * 0.002;
    let voxels_m3 = grid.voxel_count() * voxel_m3;
    let share = voxels_m3 / size.volume_m3();
    assert!((0.97..1.0).contains(&share), "{share}");

    let mut heightmap = Heightmap::empty(&grid);
    let none = Metrics::new(&grid, &heightmap, PackedVolume::default());
    assert_eq!(none, Metrics::default());
    (60..100).for_each(|x| (60..80).for_each(|y| heightmap.raise(x, y, 50)));
    let packed = PackedVolume {
        items: 1,
        voxels_m3: 0.1 * 0.05 * 0.1,
        meshes_m3: 0.1 * 0.05 * 0.1,
    };
    let metrics = Metrics::new(&grid, &heightmap, packed);
    let near = |found: f64, of_m3: f64| assert!((found * of_m3 / 0.0005 - 1.0).abs() < 1e-9);
    near(metrics.box_compactness, 0.0005);
    near(metrics.floor_compactness, size.volume_below_m3(0.1));
    near(metrics.utilisation, size.volume_m3());
}
