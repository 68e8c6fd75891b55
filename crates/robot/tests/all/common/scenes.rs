//! Random containers, contents, items and placements.

use std::sync::Arc;

use nalgebra::{Point2, Vector2, Vector3};
use ppnpack_packing::kernel::grid::{ABSENT, ContainerSize, Grid, Resolution, Units, Yaws};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use ppnpack_packing::ranking::step::Candidate;
use ppnpack_packing::scene::Scene;
use ppnpack_robot::arm::Arm;
use ppnpack_robot::parameters::ArmParameters;
use rand::{Rng, RngExt};
use std::f64::consts::FRAC_PI_2;

/// The built-in arms, with their own grippers and with ones so short that the wrist dips into the
/// container.
pub(crate) fn arms() -> Vec<(String, Arm)> {
    let mut arms = Vec::new();
    for name in ppnpack_robot::arms::names() {
        let text = ppnpack_robot::arms::text(name).unwrap();
        let mut parameters = ArmParameters::from_toml(text).unwrap();
        arms.push((name.to_owned(), Arm::new(&parameters).unwrap()));
        parameters.gripper.stem_length_m = 0.06;
        parameters.gripper.body_length_m = 0.02;
        let short = Arm::new(&parameters).unwrap();
        arms.push((format!("{name}, short gripper"), short));
    }
    arms
}

/// One placement of a random item over random content; the item rests on the content and fits below
/// the rim.
pub(crate) struct Case {
    pub(crate) grid: Grid,
    pub(crate) scene: Scene,
    pub(crate) item: Arc<Item>,
    pub(crate) resting: RestingPlacement,
}

impl Case {
    /// The item as one that arrives first.
    pub(crate) fn candidate(&self) -> Candidate {
        Candidate::new(0, Arc::clone(&self.item))
    }
}

/// The paper's simulated and physical containers.
const CONTAINERS: [ContainerSize; 2] = [
    ContainerSize::REFERENCE,
    ContainerSize::cuboid(0.30, 0.30, 0.16),
];

/// A grid of one of the containers at 1 cm or 5 mm, with yaws of 0 and a quarter turn.
pub(crate) fn grid(random: &mut impl Rng) -> Grid {
    let container = CONTAINERS[random.random_range(0..2)];
    let cell_m = [0.01, 0.005][random.random_range(0..2)];
    let yaws = Yaws::from_radians(vec![0.0, FRAC_PI_2]).unwrap();
    Grid::new(container, Resolution::new(cell_m, 0.002, yaws).unwrap()).unwrap()
}

/// Towers of random sizes, from none to a full container.
pub(crate) fn content(grid: &Grid, random: &mut impl Rng) -> Heightmap {
    let mut heightmap = Heightmap::empty(grid);
    let (nx, ny) = (grid.nx(), grid.ny());
    for _ in 0..random.random_range(0..25) {
        let (x, y) = (random.random_range(0..nx), random.random_range(0..ny));
        let width = random.random_range(1..=nx / 2);
        let depth = random.random_range(1..=ny / 2);
        let height = random.random_range(0..=grid.rim());
        for x in x..(x + width).min(nx) {
            for y in y..(y + depth).min(ny) {
                heightmap.raise(x, y, height);
            }
        }
    }
    heightmap
}

/// A block, perhaps with missing corners below and a step in its top, at yaws of 0 and a quarter
/// turn.
pub(crate) fn item(grid: &Grid, random: &mut impl Rng) -> Item {
    let cell_m = grid.resolution().cell_m();
    let cells = |length_m: f64| (length_m / cell_m).round().max(1.0) as usize;
    let nx = cells(random.random_range(0.03..0.20));
    let ny = cells(random.random_range(0.03..0.20));
    let height = random.random_range(2..grid.rim().min(75));
    let mut top = vec![height; nx * ny];
    let mut bottom = vec![0; nx * ny];
    if random.random_bool(0.3) && height > 4 {
        // A higher part along one side.
        let step = random.random_range(1..height / 2);
        for x in 0..nx {
            for y in 0..ny / 2 {
                top[x * ny + y] = height - step;
            }
        }
    }
    if random.random_bool(0.3) && nx > 2 && ny > 2 {
        for corner in [0, ny - 1, (nx - 1) * ny, nx * ny - 1] {
            bottom[corner] = if random.random_bool(0.5) { ABSENT } else { 1 };
        }
    }
    let view = |nx: usize, ny: usize, top: Vec<Units>, bottom: Vec<Units>| ViewSurfaces {
        origin_from_corner_m: Vector3::new(nx as f64, ny as f64, 0.0) * (0.5 * cell_m),
        centre_of_mass_m: Some(Point2::new(nx as f64, ny as f64) * (0.5 * cell_m)),
        ..ViewSurfaces::of_cells(nx, ny, top, bottom)
    };
    // A quarter turn takes (x, y) to (-y, x).
    let turned = |map: &[Units]| {
        let mut turned = vec![0; nx * ny];
        for x in 0..nx {
            for y in 0..ny {
                turned[(ny - 1 - y) * nx + x] = map[x * ny + y];
            }
        }
        turned
    };
    let quarter = view(ny, nx, turned(&top), turned(&bottom));
    Item::new("block", vec![view(nx, ny, top, bottom), quarter], 0.0).unwrap()
}

/// An even surface of so many cells of 1 cm and units, balanced in its middle.
pub(crate) fn even(nx: usize, ny: usize, height: Units) -> ViewSurfaces {
    let middle_m = Vector2::new(nx as f64, ny as f64) * 0.005;
    ViewSurfaces {
        origin_from_corner_m: middle_m.push(0.0),
        centre_of_mass_m: Some(middle_m.into()),
        ..ViewSurfaces::of_cells(nx, ny, vec![height; nx * ny], vec![0; nx * ny])
    }
}

/// A placement on the floor.
pub(crate) fn placed(yaw: usize, x: usize, y: usize) -> RestingPlacement {
    RestingPlacement {
        placement: Placement { yaw, x, y },
        resting_height: 0,
    }
}

/// A random case. Near half of the items lie at a wall, where clearance is tight.
pub(crate) fn case(random: &mut impl Rng) -> Case {
    loop {
        let grid = grid(random);
        let scene = Scene::from_heightmap(content(&grid, random));
        for _ in 0..20 {
            let item = item(&grid, random);
            let yaw = random.random_range(0..2);
            let view = &item.views()[yaw];
            let cell = |free: usize, random: &mut _| {
                let free = free as f64;
                (Rng::next_u32(random) as f64 / f64::from(u32::MAX) * 1.3 * free - 0.15 * free)
                    .clamp(0.0, free) as usize
            };
            let x = cell(grid.nx() - view.nx(), random);
            let y = cell(grid.ny() - view.ny(), random);
            let rests = |index: usize| {
                let (x, y) = (x + index / view.ny(), y + index % view.ny());
                scene.heightmap().get(x, y).unwrap() - view.bottom()[index]
            };
            let occupied = (0..view.bottom().len()).filter(|index| view.bottom()[*index] != ABSENT);
            let resting_height = occupied.map(rests).max().unwrap().max(0);
            if resting_height + view.height() <= grid.rim() {
                return Case {
                    resting: RestingPlacement {
                        resting_height,
                        ..placed(yaw, x, y)
                    },
                    item: Arc::new(item),
                    grid,
                    scene,
                };
            }
        }
    }
}
