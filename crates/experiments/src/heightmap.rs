//! `ppnpack experiment heightmap`: how well heightmaps of a simulated depth camera agree with the truth, over packings of
//! the built-in objects.

use std::time::Instant;

use clap::Args;
use nalgebra::{Isometry3, Point3};
use ppnpack_camera::{DepthCamera, Intrinsics, NoiseModel, View};
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_cli::length::parse_length;
use ppnpack_cli::options::Simulated;
use ppnpack_cli::sequence::Sequence;
use ppnpack_cli::simulation::{empty_cell, simulate};
use ppnpack_packing::content::LyingSolid;
use ppnpack_packing::episode::Play;
use ppnpack_packing::grid::{ContainerSize, Grid};
use ppnpack_packing::heightmap::Scene;
use ppnpack_packing::hidden::SceneMemory;
use ppnpack_packing::method::{ProposalSource, Stability};
use ppnpack_perception::mapper::Mapper;
use ppnpack_perception::settings::MapperSettings;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::packing_cell::{PoseError, Sampling, SimulatedPackingCell};
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::view::{CameraCloud, CameraSettings, Cameras};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::method::sdfm;
use crate::scene::{self, body};
use crate::statistics::{percentage, quantiles};

/// How well an inspection finds poses: 1.5 mm and 0.75 degrees.
const FOUND: PoseError = PoseError {
    position_m: 0.0015,
    rotation_rad: 0.0131,
};

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
    let cells = episodes.map(|(episode, length)| packed(&catalogue, episode, length));
    let cells: Vec<SimulatedPackingCell> = cells.collect::<Outcome<_>>()?;
    println!(
        "| cameras | content | cells above the rim | hidden | too low by over 3 mm | of them hidden, seen in part, whole | hidden and over 3 cm too high | flat: within 2 mm | time |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for cameras in [1, 2] {
        let scenes = seen(&cells, &grid, cameras)?;
        for content in [Content::Bounds, Content::Known, Content::Found] {
            report(&grid, cameras, content, &scenes)?;
        }
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
        camera: None,
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

/// What is known of the content beside the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Content {
    /// Nothing.
    Bounds,
    /// The poses of all items.
    Known,
    /// The poses of all items as an inspection finds them.
    Found,
}

/// A container as cameras see it and as it is.
struct Seen {
    clouds: Vec<CameraCloud>,
    solids: Vec<LyingSolid>,
    cells: Vec<TrueCell>,
}

fn seen(cells: &[SimulatedPackingCell], grid: &Grid, cameras: usize) -> Outcome<Vec<Seen>> {
    let scenes = cells.iter().zip(0..).map(|(cell, seed)| {
        let settings = CameraSettings {
            cameras,
            seed: 100 * seed,
            ..CameraSettings::default()
        };
        let cell = cell.cell();
        let mut cameras = Cameras::new(&settings, grid.container()).or_run()?;
        let lying = cell.contents().into_iter();
        let solids = lying.map(|body| LyingSolid::new(body.model, body.container_from_item));
        Ok(Seen {
            clouds: cameras.see(cell).or_run()?,
            solids: solids.collect(),
            cells: truth(cell, grid, cameras.cameras())?,
        })
    });
    scenes.collect()
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

/// What a camera sees of a cell.
fn render(cell: &SimulatedCell, camera: &DepthCamera) -> Outcome<View> {
    let (container, contents) = (cell.container_mesh(), cell.contents());
    let mut bodies = vec![body(&container, Isometry3::identity())];
    let items = contents.iter();
    bodies.extend(items.map(|item| body(&item.model.mesh, item.container_from_item)));
    camera.see(&bodies).or_run()
}

/// The truth, from far above, and what of it cameras see: what one of them measures no nearer along the same ray.
fn truth(cell: &SimulatedCell, grid: &Grid, cameras: &[DepthCamera]) -> Outcome<Vec<TrueCell>> {
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
    let finer: Vec<Finer> = cameras
        .iter()
        .map(|camera| Finer::new(cell, camera))
        .collect::<Outcome<_>>()?;
    let nothing = TrueCell {
        lowest_m: f64::INFINITY,
        highest_m: 0.0,
        seen: 0.0,
    };
    let mut cells = vec![nothing; grid.nx() * grid.ny()];
    for point in truth.points().in_world_m(&far.world_from_camera) {
        let is_seen = finer.iter().any(|finer| finer.sees(&point));
        let [x, y] = [point.x, point.y].map(|side| (side / cell_m) as usize);
        let index = x.min(grid.nx() - 1) * grid.ny() + y.min(grid.ny() - 1);
        if let Some(cell) = cells.get_mut(index) {
            cell.lowest_m = cell.lowest_m.min(point.z);
            cell.highest_m = cell.highest_m.max(point.z);
            cell.seen += f64::from(u8::from(is_seen)) / (across * across) as f64;
        }
    }
    Ok(cells)
}

/// What a camera sees, finer than it does, so that edges are where they are.
struct Finer {
    view: View,
    intrinsics: Intrinsics,
    camera_from_container: Isometry3<f64>,
}

impl Finer {
    fn new(cell: &SimulatedCell, camera: &DepthCamera) -> Outcome<Self> {
        let coarse = camera.intrinsics;
        let intrinsics = Intrinsics {
            width: coarse.width * 4,
            height: coarse.height * 4,
            fx: coarse.fx * 4.0,
            fy: coarse.fy * 4.0,
            cx: coarse.cx * 4.0 + 1.5,
            cy: coarse.cy * 4.0 + 1.5,
        };
        let finer = DepthCamera {
            intrinsics,
            ..camera.clone()
        };
        Ok(Self {
            view: render(cell, &finer)?,
            intrinsics,
            camera_from_container: camera.world_from_camera.inverse(),
        })
    }

    fn sees(&self, point: &Point3<f64>) -> bool {
        let there = self.camera_from_container * point;
        let pixel = pixel(&self.intrinsics, &there);
        let nearest_m = pixel.and_then(|pixel| self.view.depths_m().get(pixel));
        nearest_m.is_some_and(|nearest_m| f64::from(*nearest_m) > there.z - 0.002)
    }
}

/// The pixel that shows a point of the camera frame, row by row; `None` where that is outside of the image.
fn pixel(intrinsics: &Intrinsics, point: &Point3<f64>) -> Option<usize> {
    let at = intrinsics.project(point).map(f64::round);
    let is_inside = (0.0..intrinsics.width as f64).contains(&at.x)
        && (0.0..intrinsics.height as f64).contains(&at.y);
    is_inside.then(|| at.y as usize * intrinsics.width + at.x as usize)
}

/// The scene that is planned on.
fn scene_of(mapper: &mut Mapper, grid: &Grid, scene: &Seen, content: Content) -> Outcome<Scene> {
    mapper.clear();
    for cloud in &scene.clouds {
        mapper.add(cloud.points_m.iter().copied(), &cloud.container_from_camera);
    }
    let mapped = mapper.finish().or_run()?;
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let error = match content {
        Content::Found => FOUND,
        _ => PoseError::default(),
    };
    let solids = scene.solids.iter().map(|solid| LyingSolid {
        container_from_item: error.disturb(&solid.container_from_item, &mut random),
        ..solid.clone()
    });
    let seen = mapped.scene;
    Ok(match content {
        Content::Bounds => seen,
        _ => SceneMemory::default().complete(grid, seen.with_content(solids.collect())),
    })
}

fn report(grid: &Grid, cameras: usize, content: Content, scenes: &[Seen]) -> Outcome {
    let settings = MapperSettings::of_camera(NoiseModel::default().sigma_m);
    let mut mapper = Mapper::new(grid, settings).or_run()?;
    let mut times_ms = Vec::new();
    // The truth of each cell, and by how much it is exceeded.
    let mut cells: Vec<(&TrueCell, f64)> = Vec::new();
    let mut above_rim = 0;
    for scene in scenes {
        let start = Instant::now();
        let known = scene_of(&mut mapper, grid, scene, content)?;
        times_ms.push(start.elapsed().as_secs_f64() * 1e3);
        let heights = known.heightmap().heights();
        above_rim += heights
            .iter()
            .filter(|height| **height > grid.rim())
            .count();
        cells.extend(scene.cells.iter().zip(heights).map(|(truth, height)| {
            let height_m = f64::from(*height) * grid.resolution().height_unit_m();
            (truth, height_m - truth.highest_m)
        }));
    }
    let share = |part: &dyn Fn(&TrueCell, f64) -> bool, of: &dyn Fn(&TrueCell) -> bool| {
        let all = cells.iter().filter(|(truth, _)| of(truth)).count();
        let part = cells
            .iter()
            .filter(|(truth, excess)| of(truth) && part(truth, *excess));
        let part = part.count();
        format!("{:.3} % ({part} of {all})", percentage(part, all))
    };
    let low = |holds: &dyn Fn(f64) -> bool| {
        let cells = cells.iter();
        let low = cells.filter(|(truth, excess_m)| *excess_m < -0.003 && holds(truth.seen));
        low.count()
    };
    let [median_ms] = quantiles(times_ms.into_iter(), [0.5]);
    println!(
        "| {cameras} | {content:?} | {above_rim} | {} | {} | {}, {}, {} | {} | {} | {median_ms:.2} ms |",
        share(&|truth, _| truth.seen == 0.0, &|_| true),
        share(&|_, excess_m| excess_m < -0.003, &|_| true),
        low(&|seen| seen == 0.0),
        low(&|seen| seen > 0.0 && seen < 0.98),
        low(&|seen| seen >= 0.98),
        share(&|_, excess_m| excess_m > 0.03, &|truth| truth.seen == 0.0),
        share(&|_, excess_m| excess_m.abs() <= 0.002, &TrueCell::is_flat),
    );
    Ok(())
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
