//! How well heightmaps of a simulated depth camera agree with the truth, over packings of the built-in objects.
//!
//! usage: `heightmap_accuracy [CELL_M [EPISODES]]`, by default 0.01 and 4.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a measurement that cannot run should say so at once"
)]

use std::sync::Arc;
use std::time::Instant;

use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_packing::episode::play;
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::item::Item;
use ppnpack_packing::objective::Order;
use ppnpack_packing::plan::Planner;
use ppnpack_packing::proposals::ProposeAll;
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::PhysicalStability;
use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_perception::settings::MapperSettings;
use ppnpack_physics::camera::{DepthCamera, DepthNoise, Lens, PointCloud};
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::packing_cell::{Scan, SimulatedPackingCell};
use ppnpack_physics::settings::CellSettings;

/// Above the container's floor.
const CAMERA_HEIGHT_M: f64 = 0.9;

/// How finely the truth is seen.
const TRUE_PITCH_M: f64 = 0.0005;

const NOISE: DepthNoise = DepthNoise {
    sigma_m: 0.001,
    dropout: 0.05,
    step_m: 0.0,
};

/// Episodes of different lengths show containers from nearly empty to full.
const LENGTHS: [usize; 4] = [4, 10, 20, 40];

fn main() {
    let mut arguments = std::env::args().skip(1);
    let cell_m: f64 = arguments.next().map_or(0.01, |text| text.parse().unwrap());
    let episodes: usize = arguments.next().map_or(4, |text| text.parse().unwrap());
    let yaws = Yaws::half_turn(4).unwrap();
    let planned = Grid::reference();
    let resolution = Resolution::new(cell_m, 0.002, yaws).unwrap();
    let grid = Grid::new(ContainerSize::REFERENCE, resolution).unwrap();
    let catalogue = Catalogue::load(
        &ppnpack_household::builtin(),
        &Settings::default(),
        planned.resolution(),
        &|_, _| {},
    )
    .unwrap();
    let scenes: Vec<Seen> = (0..episodes)
        .flat_map(|episode| LENGTHS.map(|length| (episode, length)))
        .map(|(episode, length)| {
            let cell = packed(&planned, &catalogue, episode, length);
            Seen::new(&cell, &grid, (episode * 100 + length) as u64)
        })
        .collect();
    println!(
        "| largest unseen share | unknown cells | never seen | flat: within 2 mm | too low by over 3 mm, seen in part | seen whole | mean excess of other cells | time |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (share, radius) in [
        (0.0, 0.001),
        (0.25, 0.001),
        (0.5, 0.001),
        (0.99, 0.001),
        (0.25, 0.0),
    ] {
        let settings = MapperSettings {
            noise_m: NOISE.sigma_m,
            wall_margin_m: 0.003,
            largest_hole_m: 0.005,
            largest_unseen_share: share,
            point_radius_m: radius,
            ..MapperSettings::default()
        };
        report(&grid, &settings, &scenes);
    }
}

/// A container after some items of an episode.
fn packed(
    grid: &Grid,
    catalogue: &Catalogue,
    episode: usize,
    length: usize,
) -> SimulatedPackingCell {
    let objects = (0..length).map(|arrival| (arrival * 37 + 11 + 5 * episode) % catalogue.len());
    let sequence: Vec<Arc<Item>> = objects
        .map(|object| catalogue.get(object).unwrap().item.clone())
        .collect();
    let search = Search::new(grid, &SearchSettings::default())
        .unwrap()
        .bounded();
    let checks: Vec<Box<_>> = vec![Box::new(PhysicalStability::new(Default::default())) as Box<_>];
    let proposer = Box::new(ProposeAll);
    let mut planner = Planner::new(proposer, Box::new(search), checks, Order::Balance, 0);
    let mut cell =
        SimulatedPackingCell::new(CellSettings::robot(), grid, catalogue, Scan::Exact).unwrap();
    play(grid, &mut planner, &mut cell, sequence, 5, &mut ()).unwrap();
    cell
}

/// A container as the camera sees it and as it is.
struct Seen {
    cloud: PointCloud,
    cells: Vec<TrueCell>,
}

/// What is true of a cell.
#[derive(Clone, Copy)]
struct TrueCell {
    lowest_m: f64,
    highest_m: f64,
    /// The share of its area that the camera sees.
    seen: f64,
}

impl TrueCell {
    /// Level within the cell and seen.
    fn is_flat(&self) -> bool {
        self.highest_m - self.lowest_m < 0.0005 && self.seen > 0.5
    }
}

impl Seen {
    fn new(packed: &SimulatedPackingCell, grid: &Grid, seed: u64) -> Self {
        let cell = packed.cell();
        let camera =
            DepthCamera::pinhole_above(grid.container(), CAMERA_HEIGHT_M, 640, 480).unwrap();
        let image = cell.render(&camera).unwrap();
        let cells = truth(cell, grid, &camera);
        let cloud = image.with_noise(&NOISE, seed).unwrap().to_point_cloud();
        Self { cloud, cells }
    }
}

/// The truth, by a parallel camera, and what of it a camera sees: what it measures no nearer along the same ray.
fn truth(cell: &SimulatedCell, grid: &Grid, camera: &DepthCamera) -> Vec<TrueCell> {
    let cell_m = grid.resolution().cell_m();
    let across = (cell_m / TRUE_PITCH_M).round() as usize;
    let parallel = DepthCamera {
        width_px: grid.nx() * across,
        height_px: grid.ny() * across,
        lens: Lens::Parallel {
            pitch_m: TRUE_PITCH_M,
        },
        ..DepthCamera::parallel_above(grid, CAMERA_HEIGHT_M)
    };
    let truth = cell.render(&parallel).unwrap();
    // Finer than the real one, so that edges are where they are.
    let Lens::Pinhole {
        fx_px,
        fy_px,
        cx_px,
        cy_px,
    } = camera.lens
    else {
        unreachable!("a pinhole camera");
    };
    let fine = DepthCamera {
        width_px: camera.width_px * 4,
        height_px: camera.height_px * 4,
        lens: Lens::Pinhole {
            fx_px: fx_px * 4.0,
            fy_px: fy_px * 4.0,
            cx_px: cx_px * 4.0 + 1.5,
            cy_px: cy_px * 4.0 + 1.5,
        },
        ..camera.clone()
    };
    let seen = cell.render(&fine).unwrap();
    let camera_from_container = camera.container_from_camera.inverse();
    let nothing = TrueCell {
        lowest_m: f64::INFINITY,
        highest_m: 0.0,
        seen: 0.0,
    };
    let mut cells = vec![nothing; grid.nx() * grid.ny()];
    for v in 0..parallel.height_px {
        for u in 0..parallel.width_px {
            let depth_m = f64::from(truth.depth_m(u, v).unwrap());
            let point = parallel.unproject(u as f64, v as f64, depth_m);
            let point = parallel.container_from_camera * point;
            let there = camera_from_container * point;
            let pixel = |focal: f64, middle: f64, side: f64| {
                (4.0 * focal * side / there.z + 4.0 * middle + 1.5).round() as usize
            };
            let nearest = seen.depth_m(pixel(fx_px, cx_px, there.x), pixel(fy_px, cy_px, there.y));
            let is_seen = nearest.is_some_and(|nearest| f64::from(nearest) > there.z - 0.002);
            let [x, y] = [point.x, point.y].map(|side| (side / cell_m) as usize);
            let cell = &mut cells[x * grid.ny() + y];
            cell.lowest_m = cell.lowest_m.min(point.z);
            cell.highest_m = cell.highest_m.max(point.z);
            cell.seen += f64::from(u8::from(is_seen)) / (across * across) as f64;
        }
    }
    cells
}

fn report(grid: &Grid, settings: &MapperSettings, scenes: &[Seen]) {
    let mut mapper = Mapper::new(grid, settings.clone()).unwrap();
    let (mut cells, mut unknown, mut hidden, mut hidden_known) = (0, 0, 0, 0);
    let (mut flat, mut flat_good) = (0, 0);
    let (mut low_part, mut low_whole) = (0, 0);
    let mut excess = (0.0, 0);
    let mut times = Vec::new();
    for scene in scenes {
        let mut map = || -> Mapped {
            let points = scene.cloud.points_m.iter().copied();
            mapper
                .map(points, &scene.cloud.container_from_camera)
                .unwrap()
        };
        let began = Instant::now();
        let mapped = map();
        times.push(began.elapsed());
        for (truth, height) in scene.cells.iter().zip(mapped.scene.heightmap().heights()) {
            cells += 1;
            let is_unknown = *height > grid.rim();
            unknown += usize::from(is_unknown);
            hidden += usize::from(truth.seen == 0.0);
            hidden_known += usize::from(truth.seen == 0.0 && !is_unknown);
            if is_unknown {
                continue;
            }
            let excess_m = f64::from(*height) * 0.002 - truth.highest_m;
            if truth.is_flat() {
                flat += 1;
                flat_good += usize::from(excess_m.abs() <= 0.002);
            } else {
                excess = (excess.0 + excess_m, excess.1 + 1);
            }
            if excess_m < -0.003 {
                if truth.seen < 0.98 {
                    low_part += 1;
                } else {
                    low_whole += 1;
                }
            }
        }
    }
    times.sort();
    let percent = |part: usize, whole: usize| 100.0 * part as f64 / whole as f64;
    println!(
        "| {} mm | {} | {:.2} % | {:.2} %, {} of them not marked | {:.2} % of {} | {} ({:.3} %) | {} | {:.2} mm | {:.2} ms |",
        1e3 * settings.point_radius_m,
        settings.largest_unseen_share,
        percent(unknown, cells),
        percent(hidden, cells),
        hidden_known,
        percent(flat_good, flat),
        flat,
        low_part,
        percent(low_part, cells),
        low_whole,
        1e3 * excess.0 / f64::from(excess.1),
        1e3 * times[times.len() / 2].as_secs_f64(),
    );
}
