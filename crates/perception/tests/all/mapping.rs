//! What clouds become.
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use ppnpack_numbers::SettingError;
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, MAX_UNITS, Resolution, Yaws};
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::scene::Scene;
use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_perception::settings::MapperSettings;
use proptest::prelude::*;

fn grid(container: [f64; 3], cell_m: f64, unit_m: f64) -> Grid {
    let [x_m, y_m, z_m] = container;
    let resolution = Resolution::new(cell_m, unit_m, Yaws::half_turn(4).unwrap()).unwrap();
    Grid::new(ContainerSize::cuboid(x_m, y_m, z_m), resolution).unwrap()
}

fn mapper(grid: &Grid) -> Mapper {
    Mapper::new(grid, MapperSettings::default()).unwrap()
}

fn mapped(grid: &Grid, points: &[[f64; 3]]) -> Mapped {
    let points = points.iter().map(|point| Point3::from(*point).cast());
    mapper(grid).map(points, &Isometry3::identity()).unwrap()
}

/// A point in the middle of each sample, as it stands in a cloud.
fn points_of(surface: &Surface) -> Vec<Point3<f32>> {
    let middle = |index: usize| (index as f64 + 0.5) * surface.pitch_m();
    let heights = surface.heights_m().iter().enumerate();
    heights
        .map(|(index, height_m)| {
            let (x, y) = (index / surface.ny(), index % surface.ny());
            Point3::new(middle(x) as f32, middle(y) as f32, *height_m)
        })
        .collect()
}

fn any_grid() -> impl Strategy<Value = Grid> {
    prop_oneof![
        Just(Grid::reference()),
        Just(grid([0.20, 0.13, 0.1], 0.005, 0.001)),
        Just(grid([0.10, 0.08, 0.1], 0.0025, 0.002)),
        Just(grid([0.101, 0.095, 0.1013], 0.003, 0.0013)),
        Just(grid([10.0, 0.5, 1.0], 0.05, 0.005)),
    ]
}

fn any_surface() -> impl Strategy<Value = (Grid, Surface)> {
    any_grid().prop_flat_map(|grid| {
        let empty = Surface::empty(&grid);
        let count = empty.nx() * empty.ny();
        proptest::collection::vec(0.0..0.5_f32, count).prop_map(move |heights_m| {
            let surface =
                Surface::from_metres(empty.nx(), empty.ny(), empty.pitch_m(), heights_m).unwrap();
            (grid.clone(), surface)
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn a_point_in_every_sample_gives_the_surface_back((grid, surface) in any_surface()) {
        let points = points_of(&surface);
        let mapped = mapper(&grid).map(points.iter().copied(), &Isometry3::identity()).unwrap();
        prop_assert_eq!(mapped.tally.inside, points.len() as u64);
        prop_assert_eq!(mapped.unknown_cells, 0);
        prop_assert_eq!(mapped.scene, Scene::from_surface(&grid, surface).unwrap());
    }

    #[test]
    fn the_order_of_points_does_not_matter(points in proptest::collection::vec(
        [-0.02..0.34_f64, -0.02..0.34_f64, -0.02..0.4_f64], 0..400,
    )) {
        let grid = Grid::reference();
        let mut reversed = points.clone();
        reversed.reverse();
        prop_assert_eq!(mapped(&grid, &points), mapped(&grid, &reversed));
    }

    #[test]
    fn what_is_unknown_is_one_unit_above_the_rim(grid in any_grid()) {
        let mapped = mapped(&grid, &[]);
        prop_assert_eq!(mapped.unknown_cells, grid.nx() * grid.ny());
        let heights = mapped.scene.heightmap().heights();
        prop_assert!(heights.iter().all(|height| *height == grid.rim() + 1));
        let surface = mapped.scene.surface().unwrap().heights_m();
        prop_assert!(surface.iter().all(|height_m| f64::from(*height_m) > grid.container().z_m));
    }
}

#[test]
fn a_cell_has_the_height_of_its_highest_point() {
    let grid = Grid::reference();
    let points = [
        [0.051, 0.052, 0.02],
        [0.055, 0.058, 0.0411],
        [0.0549, 0.0579, 0.03],
    ];
    let mapped = mapped(&grid, &points);
    assert_eq!(mapped.scene.heightmap().get(5, 5), Some(21));
    assert_eq!(mapped.tally.inside, 3);
    assert_eq!(mapped.unknown_cells, 32 * 32 - 1);
    let surface = mapped.scene.surface().unwrap();
    let sample = |x: usize, y: usize| surface.heights_m()[x * surface.ny() + y];
    assert_eq!(sample(20, 20), 0.02);
    assert_eq!(sample(22, 23), 0.0411, "two points in one sample");
    assert_eq!(sample(21, 21), 0.0411, "no point: as high as the cell");
}

#[test]
fn points_that_show_no_content_are_left_out() {
    let grid = Grid::reference();
    let points = [
        [f64::NAN, 0.1, 0.1],
        [0.1, f64::INFINITY, 0.1],
        [0.1, 0.1, f64::NAN],
        [0.1, 0.1, f64::INFINITY],
        [0.1, 0.1, -0.011],
        [-0.001, 0.1, 0.1],
        [0.1, 0.321, 0.1],
        [0.0004, 0.1, 0.1],
        [0.3196, 0.1, 0.1],
    ];
    let mapped = mapped(&grid, &points);
    assert_eq!(mapped.tally.inside, 0);
    assert_eq!(mapped.unknown_cells, 32 * 32);
}

#[test]
fn points_just_below_the_floor_lie_on_it_and_those_above_the_rim_stay() {
    let grid = Grid::reference();
    let points = [[0.1, 0.1, -0.009], [0.2, 0.2, 0.5], [0.3, 0.3, 1e9]];
    let heightmap = mapped(&grid, &points).scene.heightmap().clone();
    assert_eq!(heightmap.get(10, 10), Some(0));
    assert_eq!(heightmap.get(20, 20), Some(250));
    assert_eq!(heightmap.get(30, 30), Some(MAX_UNITS));
}

#[test]
fn the_strip_beside_the_grid_is_inside_but_in_no_cell() {
    let grid = grid([0.105, 0.1, 0.1], 0.01, 0.002);
    let mapped = mapped(&grid, &[[0.103, 0.05, 0.05]]);
    assert_eq!(mapped.tally.inside, 1);
    assert_eq!(mapped.unknown_cells, 100);
}

#[test]
fn points_are_taken_to_the_container_frame() {
    let grid = Grid::reference();
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let container_from_sensor = Isometry3::from_parts(Translation3::new(0.16, 0.16, 1.0), down);
    let points = [Point3::new(0.056, 0.044, 0.905)];
    let mapped = mapper(&grid).map(points, &container_from_sensor).unwrap();
    let surface = mapped.scene.surface().unwrap();
    let sample_m = surface.heights_m()[86 * surface.ny() + 46];
    assert!((sample_m - 0.095).abs() < 1e-6, "{sample_m}");
}

#[test]
fn nothing_is_left_of_the_cloud_before() {
    let grid = Grid::reference();
    let mut mapper = mapper(&grid);
    let identity = Isometry3::identity();
    let empty = mapper.map([], &identity).unwrap();
    mapper.map([Point3::new(0.1, 0.1, 0.1)], &identity).unwrap();
    assert_eq!(mapper.map([], &identity).unwrap(), empty);
}

/// Points in a square lattice over an area, at a height.
fn patch(
    x_m: [f64; 2],
    y_m: [f64; 2],
    pitch_m: f64,
    height_m: impl Fn(f64, f64) -> f64,
) -> Vec<Point3<f32>> {
    let along = |[from_m, to_m]: [f64; 2]| {
        let count = ((to_m - from_m) / pitch_m).round() as usize;
        (0..count).map(move |index| from_m + (index as f64 + 0.5) * pitch_m)
    };
    along(x_m)
        .flat_map(|x| along(y_m).map(move |y| (x, y)))
        .map(|(x, y)| Point3::new(x, y, height_m(x, y)).cast())
        .collect()
}

fn noisy(settings: &mut MapperSettings) {
    settings.noise_m = 0.001;
}

/// The usual settings on the reference grid, changed.
fn changed(change: impl FnOnce(&mut MapperSettings)) -> Result<Mapper, SettingError> {
    let mut settings = MapperSettings::default();
    change(&mut settings);
    Mapper::new(&Grid::reference(), settings)
}

fn with(change: impl FnOnce(&mut MapperSettings), points: &[Point3<f32>]) -> Mapped {
    let points = points.iter().copied();
    let mapped = changed(change).unwrap().map(points, &Isometry3::identity());
    mapped.unwrap()
}

/// Deterministic noise: the sum of four waves that have nothing to do with one another, about
/// normal.
fn wave(x_m: f64, y_m: f64) -> f64 {
    let turns = [7919.0, 2207.0, 5413.0, 8863.0].into_iter();
    let turns = turns.zip([3571.0, 9349.0, 6121.0, 1709.0]);
    let sum: f64 = turns
        .map(|(of_x, of_y)| (of_x * x_m + of_y * y_m).sin())
        .sum();
    0.001 * sum / 2.0_f64.sqrt()
}

#[test]
fn noise_does_not_raise_a_level_floor() {
    let points = patch([0.0, 0.32], [0.0, 0.32], 0.0008, wave);
    let highest = points.iter().map(|point| point.z).fold(0.0, f32::max);
    assert!(highest > 0.002, "there is noise: {highest}");
    let raised = |change: fn(&mut MapperSettings)| {
        let mapped = with(change, &points);
        let heights = mapped.scene.heightmap().heights().iter();
        heights.filter(|height| **height > 0).count()
    };
    assert!(raised(noisy) < 1024 / 20, "{} of 1024 cells", raised(noisy));
    assert!(raised(|_| {}) > 1000, "as every point counts without noise");
}

#[test]
fn slopes_reach_as_high_as_they_are() {
    for slope in [0.2, 1.0, 2.0] {
        let points = patch([0.0, 0.32], [0.0, 0.14], 0.0008, |x, y| {
            slope * y + wave(x, y)
        });
        let heightmap = with(noisy, &points).scene.heightmap().clone();
        for (x, y) in (1..31).flat_map(|x| (1..12).map(move |y| (x, y))) {
            let truth_m = slope * 0.01 * (y as f64 + 1.0);
            let excess_m = 0.002 * f64::from(heightmap.get(x, y).unwrap()) - truth_m;
            let is_right = (-0.003..0.006).contains(&excess_m);
            assert!(is_right, "{slope} at {x}, {y}: {excess_m}");
        }
    }
}

#[test]
fn points_that_stand_by_themselves_do_not_count_and_narrow_posts_do() {
    let mut points = patch([0.0, 0.32], [0.0, 0.32], 0.0008, |_, _| 0.01);
    points.push(Point3::new(0.1013, 0.1013, 0.2));
    points.push(Point3::new(0.1014, 0.1013, 0.25));
    points.extend(patch([0.2, 0.202], [0.2, 0.202], 0.0008, |_, _| 0.15));
    let mapped = with(noisy, &points);
    assert_eq!(mapped.tally.alone, 2);
    assert_eq!(mapped.scene.heightmap().get(10, 10), Some(5));
    assert_eq!(mapped.scene.heightmap().get(20, 20), Some(75));
}

#[test]
fn a_point_raises_what_is_near_but_does_not_show_it() {
    let wide = |settings: &mut MapperSettings| settings.point_radius_m = 0.001;
    let mut points = patch([0.1, 0.11], [0.1, 0.12], 0.0025, |_, _| 0.01);
    points.push(Point3::new(0.1195, 0.1005, 0.05));
    let mapped = with(wide, &points);
    let heightmap = mapped.scene.heightmap();
    assert_eq!(heightmap.get(10, 10), Some(5));
    assert_eq!(heightmap.get(11, 10), Some(25));
    assert_eq!(heightmap.get(12, 10), Some(151), "raised, but not seen");
    points.push(Point3::new(0.1205, 0.1005, 0.0));
    let both = with(wide, &points);
    assert_eq!(both.scene.heightmap().get(12, 10), Some(25));
}

#[test]
fn narrow_holes_are_filled_where_all_around_is_level() {
    let is_beside =
        |point: &Point3<f32>, x: f32| (point.x - x).abs() < 0.01 && (0.1..0.11).contains(&point.y);
    let mut points = patch([0.0, 0.32], [0.0, 0.32], 0.0025, |x, _| {
        if x < 0.2 { 0.0 } else { 0.1 }
    });
    points.retain(|point| !is_beside(point, 0.1) && !is_beside(point, 0.2));
    let unknown = |hole_m| with(|settings| settings.largest_hole_m = hole_m, &points).unknown_cells;
    assert_eq!(unknown(0.0), 4);
    assert_eq!(unknown(0.0175), 4);
    assert_eq!(unknown(0.02), 2, "what is beside a step stays");
}

#[test]
fn several_sensors_see_together_what_one_does_not() {
    let grid = Grid::reference();
    let mut mapper = mapper(&grid);
    let raised = Isometry3::translation(0.0, 0.0, 0.1);
    let points = patch([0.0, 0.32], [0.0, 0.16], 0.0025, |_, _| 0.05);
    let others = patch([0.0, 0.32], [0.16, 0.32], 0.0025, |_, _| -0.05);
    mapper.clear();
    mapper.add(points.iter().copied(), &Isometry3::identity());
    mapper.add(others.iter().copied(), &raised);
    let together = mapper.finish().unwrap();
    assert_eq!(together.unknown_cells, 0);
    assert_eq!(together.tally.inside, (points.len() + others.len()) as u64);
    let heights = together.scene.heightmap().heights();
    assert!(heights.iter().all(|height| (25..=26).contains(height)));
}

#[test]
fn impossible_settings_are_refused() {
    for value in [-0.001, 2.0, f64::NAN] {
        assert!(changed(|settings| settings.floor_tolerance_m = value).is_err());
    }
    // A point is kept for every sample that it stands for: a wide one would take memory without
    // bound.
    let pitch_m = Grid::reference().resolution().surface_pitch_m();
    let of_radius = |share: f64| changed(|settings| settings.point_radius_m = share * pitch_m);
    assert!(of_radius(0.5).is_ok());
    assert!(of_radius(0.51).is_err());
}
