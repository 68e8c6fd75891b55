//! `ppnpack experiment heightmap`: how well heightmaps of a simulated depth camera agree with the truth, over packings of
//! the built-in objects.

use clap::Args;
use nalgebra::{Isometry3, Point3};
use ppnpack_camera::{DepthCamera, Intrinsics, NoiseModel, View};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::length::parse_length;
use ppnpack_cli::options::Simulated;
use ppnpack_cli::sequence::Sequence;
use ppnpack_cli::simulation::{empty_cell, simulate};
use ppnpack_packing::episode::Play;
use ppnpack_packing::grid::{ContainerSize, Grid};
use ppnpack_packing::method::{ProposalSource, Stability};
use ppnpack_perception::mapper::Mapper;
use ppnpack_perception::settings::MapperSettings;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::packing_cell::{Sampling, SimulatedPackingCell};
use ppnpack_physics::settings::CellSettings;

use super::timed;
use crate::method::sdfm;
use crate::scene::{self, body};
use crate::statistics::{percentage, quantiles};

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
    let grid = scene::grid(ContainerSize::REFERENCE, arguments.cell, 4)?;
    let catalogue = scene::objects(&ppnpack_household::builtin())?;
    let episodes =
        (0..arguments.episodes).flat_map(|episode| LENGTHS.map(|length| (episode, length)));
    let scenes = episodes.map(|(episode, length)| {
        let cell = packed(&catalogue, episode, length)?;
        Seen::new(cell.cell(), &grid, (episode * 100 + length) as u64)
    });
    let scenes: Vec<Seen> = scenes.collect::<Outcome<_>>()?;
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
fn packed(catalogue: &Catalogue, episode: usize, length: usize) -> Outcome<SimulatedPackingCell> {
    let objects = (0..length).map(|arrival| (arrival * 37 + 11 + 5 * episode) % catalogue.len());
    let sequence = Sequence {
        from: format!("episode {episode}"),
        objects: objects.collect(),
    };
    let grid = Grid::reference();
    let method = sdfm(ProposalSource::Bounded, Stability::Physical, 5, 0);
    let simulated = Simulated {
        scan: Sampling::Greatest,
        cell: CellSettings::robot(),
    };
    let mut planner = method.build(&grid, None)?;
    let how = Play::with_buffer(method.buffer);
    let (_, cell) = simulate(
        catalogue,
        &grid,
        &sequence,
        empty_cell(catalogue, &grid, &simulated)?,
        &mut planner,
        how,
        &mut (),
    )?;
    Ok(cell)
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
    fn new(cell: &SimulatedCell, grid: &Grid, seed: u64) -> Outcome<Self> {
        let size = grid.container();
        let to_rim_m = CAMERA_HEIGHT_M - size.z_m;
        let intrinsics = Intrinsics::framing(640, 480, [size.x_m, size.y_m], to_rim_m).or_run()?;
        let at = Point3::new(size.x_m / 2.0, size.y_m / 2.0, CAMERA_HEIGHT_M);
        let camera = DepthCamera::looking_down(intrinsics, at);
        let image = render(cell, &camera)?;
        let noisy = image.noisy_points(&NoiseModel::default(), seed).or_run()?;
        let mut points_m = noisy.points_m().to_vec();
        points_m.retain(|point| !point.z.is_nan());
        Ok(Self {
            points_m,
            container_from_camera: camera.world_from_camera,
            cells: truth(cell, grid, &camera)?,
        })
    }
}

/// What a camera sees of a cell.
fn render(cell: &SimulatedCell, camera: &DepthCamera) -> Outcome<View> {
    let (container, contents) = (cell.container_mesh(), cell.contents());
    let mut bodies = vec![body(&container, Isometry3::identity())];
    let items = contents.iter();
    bodies.extend(items.map(|item| body(&item.model.mesh, item.container_from_item)));
    camera.see(&bodies).or_run()
}

/// The truth, from far above, and what of it a camera sees: what it measures no nearer along the same ray.
fn truth(cell: &SimulatedCell, grid: &Grid, camera: &DepthCamera) -> Outcome<Vec<TrueCell>> {
    let cell_m = grid.resolution().cell_m();
    let across = (cell_m / TRUE_PITCH_M).round() as usize;
    let (width, height) = (grid.nx() * across, grid.ny() * across);
    let far = Intrinsics::centred(width, height, TRUE_HEIGHT_M / TRUE_PITCH_M).or_run()?;
    let [x_m, y_m] = [grid.nx(), grid.ny()].map(|count| count as f64 * cell_m / 2.0);
    let far = DepthCamera {
        far_m: 2.0 * TRUE_HEIGHT_M,
        ..DepthCamera::looking_down(far, Point3::new(x_m, y_m, TRUE_HEIGHT_M))
    };
    let truth = render(cell, &far)?;
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
    let finer = DepthCamera {
        intrinsics: fine,
        ..camera.clone()
    };
    let seen = render(cell, &finer)?;
    let camera_from_container = camera.world_from_camera.inverse();
    let nothing = TrueCell {
        lowest_m: f64::INFINITY,
        highest_m: 0.0,
        seen: 0.0,
    };
    let mut cells = vec![nothing; grid.nx() * grid.ny()];
    for point in truth.points().in_world_m(&far.world_from_camera) {
        let there = camera_from_container * point;
        let pixel = pixel(&fine, &there);
        let nearest_m = pixel.and_then(|pixel| seen.depths_m().get(pixel));
        let is_seen = nearest_m.is_some_and(|nearest_m| f64::from(*nearest_m) > there.z - 0.002);
        let [x, y] = [point.x, point.y].map(|side| (side / cell_m) as usize);
        let cell = &mut cells[x.min(grid.nx() - 1) * grid.ny() + y.min(grid.ny() - 1)];
        cell.lowest_m = cell.lowest_m.min(point.z);
        cell.highest_m = cell.highest_m.max(point.z);
        cell.seen += f64::from(u8::from(is_seen)) / (across * across) as f64;
    }
    Ok(cells)
}

/// The pixel that shows a point of the camera frame, row by row; `None` where that is outside of the image.
fn pixel(intrinsics: &Intrinsics, point: &Point3<f64>) -> Option<usize> {
    let at = intrinsics.project(point).map(f64::round);
    let is_inside = (0.0..intrinsics.width as f64).contains(&at.x)
        && (0.0..intrinsics.height as f64).contains(&at.y);
    is_inside.then(|| at.y as usize * intrinsics.width + at.x as usize)
}

fn report(grid: &Grid, settings: &MapperSettings, scenes: &[Seen]) {
    let mut mapper = Mapper::new(grid, settings.clone()).unwrap();
    let mut times_ms = Vec::new();
    // The truth of each cell, and by how much it is exceeded where the cell is not marked as unknown.
    let mut cells: Vec<(&TrueCell, Option<f64>)> = Vec::new();
    for scene in scenes {
        let points = scene.points_m.iter().copied();
        let (mapped, time_ms) = timed(|| mapper.map(points, &scene.container_from_camera).unwrap());
        times_ms.push(time_ms);
        let heights = mapped.scene.heightmap().heights().iter();
        cells.extend(scene.cells.iter().zip(heights).map(|(truth, height)| {
            let excess_m = f64::from(*height) * 0.002 - truth.highest_m;
            (truth, (*height <= grid.rim()).then_some(excess_m))
        }));
    }
    let count = |holds: &dyn Fn(&TrueCell, Option<f64>) -> bool| {
        cells.iter().filter(|cell| holds(cell.0, cell.1)).count()
    };
    let is_low = |excess_m: Option<f64>| excess_m.is_some_and(|excess_m| excess_m < -0.003);
    let flat = count(&|truth, excess_m| truth.is_flat() && excess_m.is_some());
    let flat_good = count(&|truth, excess_m| {
        truth.is_flat() && excess_m.is_some_and(|excess_m| excess_m.abs() <= 0.002)
    });
    let low_part = count(&|truth, excess_m| is_low(excess_m) && truth.seen < 0.98);
    let others = cells.iter().filter(|(truth, _)| !truth.is_flat());
    let excesses_m: Vec<f64> = others.filter_map(|(_, excess_m)| *excess_m).collect();
    let [median_ms] = quantiles(times_ms.into_iter(), [0.5]);
    println!(
        "| {} mm | {} | {:.2} % | {:.2} %, {} of them not marked | {:.2} % of {flat} | {low_part} ({:.3} %) | {} | {:.2} mm | {median_ms:.2} ms |",
        1e3 * settings.point_radius_m,
        settings.largest_unseen_share,
        percentage(count(&|_, excess_m| excess_m.is_none()), cells.len()),
        percentage(count(&|truth, _| truth.seen == 0.0), cells.len()),
        count(&|truth, excess_m| truth.seen == 0.0 && excess_m.is_some()),
        percentage(flat_good, flat),
        percentage(low_part, cells.len()),
        count(&|truth, excess_m| is_low(excess_m) && truth.seen >= 0.98),
        1e3 * excesses_m.iter().sum::<f64>() / excesses_m.len() as f64,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_outside_of_the_image_have_no_pixel() {
        let intrinsics = Intrinsics::centred(4, 3, 1.0).unwrap();
        let of = |u: f64, v: f64| pixel(&intrinsics, &Point3::new(u - 1.5, v - 1.0, 1.0));
        assert_eq!(of(0.0, 0.0), Some(0));
        assert_eq!(of(-0.4, 1.0), Some(4));
        assert_eq!(of(3.0, 2.0), Some(11));
        for (u, v) in [
            (-1.0, 1.0),
            (4.0, 1.0),
            (1.0, -1.0),
            (1.0, 3.0),
            (1e30, 1e30),
            (f64::NAN, 0.0),
        ] {
            assert_eq!(of(u, v), None, "{u} {v}");
        }
    }
}
