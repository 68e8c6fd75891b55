//! `ppnpack experiment heightmap`: how well heightmaps of a simulated depth camera agree with the truth, over packings of
//! the built-in objects.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a measurement that cannot run should say so at once"
)]

use std::time::Instant;

use clap::Args;
use nalgebra::{Isometry3, Point3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel, View};
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_cli::failure::{OrInput, Outcome};
use ppnpack_cli::length::parse_length;
use ppnpack_cli::options::load;
use ppnpack_packing::episode::{Play, play};
use ppnpack_packing::grid::{ContainerSize, Grid, Resolution, Yaws};
use ppnpack_packing::objective::Order;
use ppnpack_packing::plan::Planner;
use ppnpack_packing::proposals::ProposeAll;
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::PhysicalStability;
use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_perception::settings::MapperSettings;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::packing_cell::{Sampling, SimulatedPackingCell};
use ppnpack_physics::settings::CellSettings;

/// Above the container's floor.
const CAMERA_HEIGHT_M: f64 = 0.9;

/// How finely the truth is seen.
const TRUE_PITCH_M: f64 = 0.0005;

/// The truth is seen from so far above that its rays are all but parallel: within the container they lean by less than
/// 0.1 mm.
const TRUE_HEIGHT_M: f64 = 500.0;

/// Episodes of different lengths show containers from nearly empty to full.
const LENGTHS: [usize; 4] = [4, 10, 20, 40];

/// Packs the built-in objects, looks at the containers, and compares each cell's height with the truth.
#[derive(Debug, Args)]
pub(crate) struct HeightmapArguments {
    /// The edge of a grid cell
    #[arg(long, value_name = "LENGTH", default_value = "1cm", value_parser = parse_length)]
    cell: f64,

    /// How many episodes of each length
    #[arg(long, value_name = "COUNT", default_value_t = 4)]
    episodes: usize,
}

pub(crate) fn run(arguments: &HeightmapArguments) -> Outcome {
    let HeightmapArguments { cell, episodes } = *arguments;
    let yaws = Yaws::half_turn(4).or_input()?;
    let planned = Grid::reference();
    let resolution = Resolution::new(cell, 0.002, yaws).or_input()?;
    let grid = Grid::new(ContainerSize::REFERENCE, resolution).or_input()?;
    let catalogue = load(
        &ppnpack_household::builtin(),
        &Settings::default(),
        planned.resolution(),
    )?;
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
            noise_m: NoiseModel::default().deviation_m,
            wall_margin_m: 0.003,
            largest_hole_m: 0.005,
            largest_unseen_share: share,
            point_radius_m: radius,
            ..MapperSettings::default()
        };
        report(&grid, &settings, &scenes);
    }
    Ok(())
}

/// A container after some items of an episode.
fn packed(
    grid: &Grid,
    catalogue: &Catalogue,
    episode: usize,
    length: usize,
) -> SimulatedPackingCell {
    let objects = (0..length).map(|arrival| (arrival * 37 + 11 + 5 * episode) % catalogue.len());
    let sequence = objects
        .enumerate()
        .map(|(arrival, object)| catalogue.get(object).unwrap().candidate(arrival))
        .collect();
    let search = Search::new(grid, &SearchSettings::default())
        .unwrap()
        .bounded();
    let checks: Vec<Box<_>> = vec![Box::new(PhysicalStability::new(Default::default())) as Box<_>];
    let proposer = Box::new(ProposeAll);
    let mut planner = Planner::new(proposer, Box::new(search), checks, Order::Balance, 0);
    let mut cell =
        SimulatedPackingCell::new(CellSettings::robot(), grid, catalogue, Sampling::Greatest)
            .unwrap();
    play(
        grid,
        &mut planner,
        &mut cell,
        sequence,
        Play::with_buffer(5),
        &mut (),
    )
    .unwrap();
    cell
}

/// A container as the camera sees it and as it is.
struct Seen {
    /// In the camera frame.
    points_m: Vec<Point3<f32>>,
    container_from_camera: Isometry3<f64>,
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
        let size = grid.container();
        let to_rim_m = CAMERA_HEIGHT_M - size.z_m;
        let intrinsics = Intrinsics::framing(640, 480, [size.x_m, size.y_m], to_rim_m).unwrap();
        let at = Point3::new(size.x_m / 2.0, size.y_m / 2.0, CAMERA_HEIGHT_M);
        let camera = DepthCamera::looking_down(intrinsics, at);
        let image = render(cell, &camera);
        let noisy = image.noisy_points(&NoiseModel::default(), seed).unwrap();
        let points = noisy.points_m().iter().filter(|point| !point.z.is_nan());
        Self {
            points_m: points.copied().collect(),
            container_from_camera: camera.world_from_camera,
            cells: truth(cell, grid, &camera),
        }
    }
}

/// What a camera sees of a cell.
fn render(cell: &SimulatedCell, camera: &DepthCamera) -> View {
    fn posed(mesh: &Mesh, world_from_body: Isometry3<f64>) -> Body<'_> {
        Body {
            vertices: &mesh.vertices,
            triangles: &mesh.triangles,
            world_from_body,
        }
    }
    let (container, contents) = (cell.container_mesh(), cell.contents());
    let items = contents
        .iter()
        .map(|item| posed(&item.model.mesh, item.container_from_item));
    let container = std::iter::once(posed(&container, Isometry3::identity()));
    let bodies: Vec<_> = container.chain(items).collect();
    camera.see(&bodies).unwrap()
}

/// The truth, from far above, and what of it a camera sees: what it measures no nearer along the same ray.
fn truth(cell: &SimulatedCell, grid: &Grid, camera: &DepthCamera) -> Vec<TrueCell> {
    let cell_m = grid.resolution().cell_m();
    let across = (cell_m / TRUE_PITCH_M).round() as usize;
    let far = Intrinsics::centred(
        grid.nx() * across,
        grid.ny() * across,
        TRUE_HEIGHT_M / TRUE_PITCH_M,
    )
    .unwrap();
    let [x_m, y_m] = [grid.nx(), grid.ny()].map(|count| count as f64 * cell_m / 2.0);
    let far = DepthCamera {
        far_m: 2.0 * TRUE_HEIGHT_M,
        ..DepthCamera::looking_down(far, Point3::new(x_m, y_m, TRUE_HEIGHT_M))
    };
    let truth = render(cell, &far);
    // Finer than the real one, so that edges are where they are.
    let coarse = camera.intrinsics;
    let fine = Intrinsics {
        width: coarse.width * 4,
        height: coarse.height * 4,
        fx: coarse.fx * 4.0,
        fy: coarse.fy * 4.0,
        cx: coarse.cx * 4.0 + 1.5,
        cy: coarse.cy * 4.0 + 1.5,
    };
    let seen = render(
        cell,
        &DepthCamera {
            intrinsics: fine,
            ..camera.clone()
        },
    );
    let camera_from_container = camera.world_from_camera.inverse();
    let nothing = TrueCell {
        lowest_m: f64::INFINITY,
        highest_m: 0.0,
        seen: 0.0,
    };
    let mut cells = vec![nothing; grid.nx() * grid.ny()];
    for point in truth.points().in_world_m(&far.world_from_camera) {
        let there = camera_from_container * point;
        let pixel = fine.project(&there).map(|side| side.round() as usize);
        let nearest_m = f64::from(seen.depths_m()[pixel.y * fine.width + pixel.x]);
        let is_seen = nearest_m > there.z - 0.002;
        let [x, y] = [point.x, point.y].map(|side| (side / cell_m) as usize);
        let cell = &mut cells[x.min(grid.nx() - 1) * grid.ny() + y.min(grid.ny() - 1)];
        cell.lowest_m = cell.lowest_m.min(point.z);
        cell.highest_m = cell.highest_m.max(point.z);
        cell.seen += f64::from(u8::from(is_seen)) / (across * across) as f64;
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
            let points = scene.points_m.iter().copied();
            mapper.map(points, &scene.container_from_camera).unwrap()
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
