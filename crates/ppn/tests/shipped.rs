//! The worth of the shipped weights, on steps that the test makes itself: how often the optimum of
//! the exhaustive search is among the network's best-scored placements.

#![cfg(test)]

#[path = "support/recorded.rs"]
mod recorded;

use std::collections::BTreeMap;
use std::sync::Arc;

use ppnpack_model::settings::Device;
use ppnpack_model::weights::{Model, WeightTensor, to_bytes};
use ppnpack_packing::kernel::grid::{ABSENT, Grid, Units};
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_packing::ranking::proposals::{Percent, ProposeAll};
use ppnpack_packing::ranking::step::{Candidate, StepInput};
use ppnpack_packing::scene::Scene;
use ppnpack_ppn::proposer::NetworkProposer;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use recorded::{planner, steps};

/// The share of placements that the network proposes, in percent.
const SHARE: f64 = 5.0;
const BUFFER: usize = 5;

/// The lower and the upper surface of a solid above a point of its item frame, in metres.
type Solid = fn(f64, f64) -> Option<(f64, f64)>;

fn cuboid(x: f64, y: f64, [x_m, y_m, z_m]: [f64; 3]) -> Option<(f64, f64)> {
    (x.abs() <= 0.5 * x_m && y.abs() <= 0.5 * y_m).then_some((0.0, z_m))
}

fn cylinder(x: f64, y: f64, radius_m: f64, z_m: f64) -> Option<(f64, f64)> {
    (x.hypot(y) <= radius_m).then_some((0.0, z_m))
}

fn ball(x: f64, y: f64, radius_m: f64) -> Option<(f64, f64)> {
    let half = (radius_m * radius_m - x * x - y * y).max(0.0).sqrt();
    (x.hypot(y) <= radius_m).then_some((radius_m - half, radius_m + half))
}

const SOLIDS: [(&str, Solid); 10] = [
    ("packet", |x, y| cuboid(x, y, [0.16, 0.11, 0.05])),
    ("box", |x, y| cuboid(x, y, [0.10, 0.08, 0.12])),
    ("bar", |x, y| cuboid(x, y, [0.20, 0.04, 0.03])),
    ("cube", |x, y| cuboid(x, y, [0.06, 0.06, 0.06])),
    ("tin", |x, y| cylinder(x, y, 0.035, 0.10)),
    ("jar", |x, y| cylinder(x, y, 0.05, 0.07)),
    ("orange", |x, y| ball(x, y, 0.04)),
    ("ball", |x, y| ball(x, y, 0.06)),
    ("bottle", |x, y| {
        let half = (0.035_f64 * 0.035 - y * y).max(0.0).sqrt();
        (x.abs() <= 0.11 && y.abs() <= 0.035).then_some((0.035 - half, 0.035 + half))
    }),
    ("step", |x, y| {
        let (_, z_m) = cuboid(x, y, [0.14, 0.09, 0.08])?;
        Some((0.0, if x < 0.0 { z_m } else { 0.03 }))
    }),
];

/// A solid on the grid at one yaw: per cell the lowest and the highest of some points, rounded
/// outwards.
fn view(grid: &Grid, solid: Solid, yaw_rad: f64) -> ViewSurfaces {
    const POINTS: usize = 5;
    let (cell_m, unit_m) = (
        grid.resolution().cell_m(),
        grid.resolution().height_unit_m(),
    );
    let half = 13;
    let units = |height_m: f64, round: fn(f64) -> f64| round(height_m / unit_m) as Units;
    let mut cells = BTreeMap::new();
    for point_x in 0..2 * half * POINTS {
        for point_y in 0..2 * half * POINTS {
            let at_m = |point: usize| ((point as f64 + 0.5) / POINTS as f64 - half as f64) * cell_m;
            let (x, y) = (at_m(point_x), at_m(point_y));
            let (sine, cosine) = yaw_rad.sin_cos();
            let Some((low_m, high_m)) = solid(cosine * x + sine * y, cosine * y - sine * x) else {
                continue;
            };
            let cell = cells.entry((point_x / POINTS, point_y / POINTS));
            let (low, high) = cell.or_insert((Units::MAX, Units::MIN));
            *low = (*low).min(units(low_m, f64::floor));
            *high = (*high).max(units(high_m, f64::ceil));
        }
    }
    let span = |of: fn(&(usize, usize)) -> usize| {
        let (first, last) = (cells.keys().map(of).min(), cells.keys().map(of).max());
        (first.unwrap(), last.unwrap())
    };
    let ((first_x, last_x), (first_y, last_y)) = (span(|cell| cell.0), span(|cell| cell.1));
    let all = (first_x..=last_x).flat_map(|x| (first_y..=last_y).map(move |y| (x, y)));
    let found = all.map(|cell| cells.get(&cell).copied().unwrap_or((ABSENT, ABSENT)));
    let (bottom, top) = found.unzip();
    let (nx, ny) = (last_x + 1 - first_x, last_y + 1 - first_y);
    ViewSurfaces::of_cells(nx, ny, top, bottom)
}

fn items(grid: &Grid) -> Vec<Arc<Item>> {
    let item = |(name, solid): &(&str, Solid)| {
        let yaws = grid.resolution().yaws().radians().iter();
        let views = yaws.map(|yaw_rad| view(grid, *solid, *yaw_rad)).collect();
        Arc::new(Item::new(name, views, 1e-4).unwrap())
    };
    SOLIDS.iter().map(item).collect()
}

/// Every candidate of every step of some packings, each by itself, with the container it was looked
/// at for.
fn cases(grid: &Grid) -> Vec<(Scene, Candidate)> {
    let items = items(grid);
    let mut cases = Vec::new();
    for seed in 0..3 {
        let mut order: Vec<usize> = (0..40).map(|arrival| arrival % items.len()).collect();
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        let arrivals = order.iter().map(|object| items[*object].clone());
        for (scene, candidates) in steps(grid, arrivals, BUFFER) {
            let each = candidates.into_iter();
            cases.extend(each.map(|candidate| (scene.clone(), candidate)));
        }
    }
    cases
}

/// Of the candidates that have a valid placement: how many there are, for how many the optimum is
/// among the network's proposals, and for how many no proposal was valid.
#[derive(Debug, Default)]
struct Accuracy {
    candidates: usize,
    found: usize,
    widened: usize,
}

impl Accuracy {
    fn percent(&self) -> f64 {
        100.0 * self.found as f64 / self.candidates as f64
    }
}

fn accuracy(grid: &Grid, model: &Model, cases: &[(Scene, Candidate)]) -> Accuracy {
    let share = Percent::new(SHARE).unwrap();
    let network = NetworkProposer::new(model, grid, share, Device::Cpu, &[]).unwrap();
    let mut pruned = planner(grid, Box::new(network));
    let mut exhaustive = planner(grid, Box::new(ProposeAll));
    let mut accuracy = Accuracy::default();
    for (scene, candidate) in cases {
        let input = StepInput::new(grid, scene, std::slice::from_ref(candidate));
        let Some(best) = exhaustive.plan(&input).unwrap().choice() else {
            continue;
        };
        accuracy.candidates += 1;
        let plan = pruned.plan(&input).unwrap();
        assert!(plan.degraded().is_empty());
        if plan.is_widened() {
            accuracy.widened += 1;
        } else {
            let found = plan.choice().unwrap();
            accuracy.found += usize::from(found.value <= best.value + 1e-9);
        }
    }
    accuracy
}

/// The shipped architecture with the shipped values in another order.
fn shuffled(model: &Model) -> Model {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let shuffle = |(name, tensor): (&String, &WeightTensor)| {
        let mut values = tensor.values.clone();
        values.shuffle(&mut random);
        let shape = tensor.shape.clone();
        (name.clone(), WeightTensor { shape, values })
    };
    let tensors: BTreeMap<String, WeightTensor> = model.tensors().iter().map(shuffle).collect();
    let bytes = to_bytes(&tensors, None).unwrap();
    let mut card = model.card().clone();
    card.weights_blake3 = blake3::hash(&bytes).to_hex().to_string();
    Model::new("shuffled weights", &bytes, card).unwrap()
}

#[test]
fn the_optimum_is_among_the_best_scored_placements_and_not_by_chance() {
    let grid = Grid::reference();
    let cases = cases(&grid);
    let model = Model::shipped().unwrap();
    let shipped = accuracy(&grid, &model, &cases);
    let chance = accuracy(&grid, &shuffled(&model), &cases);
    println!("shipped: {shipped:?}, {:.1} %", shipped.percent());
    println!("shuffled: {chance:?}, {:.1} %", chance.percent());
    assert!(shipped.candidates >= 300, "{shipped:?}");
    assert_eq!(shipped.widened, 0, "{shipped:?}");
    assert!(shipped.percent() >= 90.0, "{shipped:?}");
    assert!(chance.percent() < 60.0, "{chance:?}");
}
