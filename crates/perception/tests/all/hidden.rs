//! How high what a camera does not see may be.
use crate::simulated::Case;
use nalgebra::Isometry3;
use ppnpack_camera::NoiseModel;
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::raster::raise_surface;
use ppnpack_packing::kernel::grid::{Grid, Resolution, Yaws};
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_perception::settings::MapperSettings;

fn grid(case: &Case, cell_m: f64) -> Grid {
    let yaws = Yaws::half_turn(4).unwrap();
    Grid::new(case.size(), Resolution::new(cell_m, 0.002, yaws).unwrap()).unwrap()
}

/// The reference container with some boxes, seen from 0.9 m above the floor.
fn with_boxes(boxes: &[([f64; 3], [f64; 3])]) -> Case {
    let mut case = Case::plain();
    case.look_from(0.6, 0.0, 0.0, 0.0);
    let boxes = boxes.iter();
    case.others = boxes.map(|(low, high)| Mesh::cuboid(*low, *high)).collect();
    case
}

fn seen(grid: &Grid, cases: &[&Case]) -> Mapped {
    let settings = MapperSettings::of_camera(0.001);
    let mut mapper = Mapper::new(grid, settings).unwrap();
    mapper.clear();
    for case in cases {
        mapper.add(case.cloud(), &case.world_from_camera);
    }
    mapper.finish().unwrap()
}

fn truth(grid: &Grid, case: &Case) -> Surface {
    let mut truth = Surface::empty(grid);
    for mesh in &case.others {
        raise_surface(mesh, &Isometry3::identity(), &mut truth);
    }
    truth
}

fn sample(surface: &Surface, x_m: f64, y_m: f64) -> usize {
    let [x, y] = [x_m, y_m].map(|at| (at / surface.pitch_m()) as usize);
    x * surface.ny() + y
}

/// Shares of all samples: too low by more than 3 mm, and bounds more than 3 cm too high.
fn errors(grid: &Grid, case: &Case, mapped: &Mapped) -> (f64, f64) {
    let (surface, truth) = (mapped.scene.surface().unwrap(), truth(grid, case));
    let pairs = || surface.heights_m().iter().zip(truth.heights_m());
    let all = pairs().count() as f64;
    let low = pairs().filter(|(seen, truth)| **seen < **truth - 0.003);
    let high = pairs().filter(|(seen, truth)| **seen > **truth + 0.03);
    (low.count() as f64 / all, high.count() as f64 / all)
}

#[test]
fn an_empty_container_has_no_unknown_cell() {
    let tilted = [(0.0025, 0.2), (0.005, 0.35)];
    let straight = [0.01, 0.005, 0.0025].map(|cell_m| (cell_m, 0.0));
    for (cell_m, tilt_rad) in straight.into_iter().chain(tilted) {
        let mut case = with_boxes(&[]);
        case.look_from(0.7, tilt_rad, 0.4, 0.3);
        let grid = grid(&case, cell_m);
        let mapped = seen(&grid, &[&case]);
        let highest = mapped.scene.heightmap().max();
        assert_eq!(mapped.unknown_cells, 0, "{cell_m} {tilt_rad}");
        // In the shadow of the near wall a camera that leans leaves more open.
        assert!(tilt_rad > 0.0 || highest <= 4, "{cell_m}: {highest}");
        assert_eq!(mapped.doubts, []);
    }
}

#[test]
fn a_shadow_falls_from_the_edge_that_throws_it() {
    // 15 cm beside the axis, 10 cm high: the line over its edge falls by 8 cm in 1.5 cm.
    let case = with_boxes(&[([0.21, 0.1, 0.0], [0.26, 0.22, 0.1])]);
    let grid = grid(&case, 0.0025);
    let mapped = seen(&grid, &[&case]);
    let surface = mapped.scene.surface().unwrap();
    let slope = 0.8 / 0.1;
    for step in 1..10 {
        let beyond_m = 0.0025 * f64::from(step);
        let found_m = f64::from(surface.heights_m()[sample(surface, 0.26 + beyond_m, 0.16)]);
        let line_m = (0.1 - slope * beyond_m).max(0.0);
        // A sample and a cell of rays wider.
        let most_m = (0.1 - slope * (beyond_m - 0.006)).clamp(0.004, 0.105);
        assert!(
            (line_m - 0.003..=most_m).contains(&found_m),
            "{beyond_m}: {found_m} where {line_m} to {most_m} is possible"
        );
    }
    let hidden = |x_m: f64| {
        let sample = sample(surface, x_m, 0.16);
        surface.support_m()[sample] < surface.heights_m()[sample]
    };
    assert!(hidden(0.262), "what is bounded holds nothing up");
    assert!(!hidden(0.25) && !hidden(0.29));
}

#[test]
fn content_is_no_higher_than_it_is_said_to_be() {
    let mut random = 7_u32;
    let mut any = |low: f64, high: f64| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        low + (high - low) * f64::from(random >> 8) / f64::from(1 << 24)
    };
    let (mut low, mut high) = (0.0, 0.0);
    let scenes = 12;
    for seed in 0..scenes {
        let boxes = [(); 8].map(|()| {
            let (x, y) = (any(0.0, 0.26), any(0.0, 0.26));
            let far = [x + any(0.01, 0.06), y + any(0.01, 0.06), any(0.005, 0.25)];
            ([x, y, 0.0], far)
        });
        let mut case = with_boxes(&boxes);
        case.seed = seed;
        case.noise = NoiseModel::default();
        let grid = grid(&case, 0.0025);
        let (too_low, too_high) = errors(&grid, &case, &seen(&grid, &[&case]));
        (low, high) = (low + too_low, high + too_high);
    }
    let (low, high) = (low / scenes as f64, high / scenes as f64);
    assert!(low <= 0.0005, "too low: {low}");
    assert!(high <= 0.08, "too high: {high}");
}

#[test]
fn two_cameras_leave_less_open_than_each() {
    let boxes = [([0.12, 0.1, 0.0], [0.2, 0.2, 0.15])];
    let at = |around_rad: f64| {
        let mut case = with_boxes(&boxes);
        case.look_from(0.7, 0.3, around_rad, 0.0);
        case
    };
    let (one, other) = (at(0.0), at(std::f64::consts::PI));
    let grid = grid(&one, 0.0025);
    let excess_m3 = |cases: &[&Case]| {
        let mapped = seen(&grid, cases);
        let (surface, truth) = (mapped.scene.surface().unwrap().clone(), truth(&grid, &one));
        let pairs = surface.heights_m().iter().zip(truth.heights_m());
        let excess = pairs.map(|(seen, truth)| f64::from(seen - truth));
        excess.sum::<f64>()
    };
    let both = excess_m3(&[&one, &other]);
    let less = excess_m3(&[&one]).min(excess_m3(&[&other]));
    assert!(both < 0.5 * less, "{both}");
}

#[test]
fn where_no_ray_passes_content_may_be_higher_than_the_rim() {
    let mut case = with_boxes(&[]);
    // A board over a part of the opening.
    case.others = vec![Mesh::cuboid([0.0, 0.0, 0.4], [0.1, 0.32, 0.405])];
    let grid = grid(&case, 0.005);
    let mapped = seen(&grid, &[&case]);
    let heightmap = mapped.scene.heightmap();
    assert!(heightmap.get(10, 32).unwrap() > grid.rim());
    assert!(heightmap.get(50, 32).unwrap() < 4);
}
