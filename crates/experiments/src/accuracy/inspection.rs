//! `ppnpack experiment inspection`: how often an inspection tells what became of a placed item, in simulated views.
//!
//! The objects of a folder lie in a container, dropped without physics: each straight down to where it touches. One more
//! is planned, and then lies as planned, elsewhere, on another side, or not at all; or another object lies there. A depth
//! camera some 0.9 m above the floor sees the container before and after.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use nalgebra::{Isometry3, Point2, Point3, Translation3, Unit, UnitQuaternion, Vector2, Vector3};
use ppnpack_camera::{DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::catalogue::Source;
use ppnpack_catalogue::mesh::Mesh;
use ppnpack_catalogue::object::Model;
use ppnpack_catalogue::raster::{Raster, rasterise};
use ppnpack_cli::failure::{OrInput, OrRun, Outcome};
use ppnpack_cli::options::at_least_one;
use ppnpack_packing::grid::ContainerSize;
use ppnpack_packing::heightmap::Surface;
use ppnpack_recognition::evaluation::PoseError;
use ppnpack_recognition::inspection::{ContainerCloud, Inspection, InspectionSettings, inspect};
use ppnpack_recognition::library::{Library, LibraryObject, LibrarySettings};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{columns_of, simulated, timed, write_csv};
use crate::scene::{any_turn, between, body, models, turn};
use crate::statistics::{percentage, quantiles};

const CONTAINER: ContainerSize = ContainerSize::REFERENCE;

/// The distance of the surface's samples, in metres, and how many lie along a side.
const PITCH_M: f64 = 0.0025;
const SIDE: usize = 128;

const CASES: [&str; 5] = [
    "as planned",
    "moved",
    "toppled",
    "missing",
    "another object",
];
const TOLD: [&str; 5] = ["as planned", "moved", "toppled", "missing", "unclear"];

/// Lays objects down in a container, one of them in another way than planned, and inspects it.
#[derive(Debug, Args)]
pub(crate) struct InspectionArguments {
    /// The folder of the objects
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// Views of each object in each case
    #[arg(long, value_name = "COUNT", default_value_t = 1)]
    views: usize,

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    seed: u64,

    /// Inspect only objects with this in their name
    #[arg(long, value_name = "NAME")]
    only: Option<String>,

    /// Inspect only one in so many objects
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = at_least_one)]
    every: usize,

    /// Where each inspection is written as a line of a table
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    #[command(flatten)]
    sensor: Sensor,
}

#[derive(Debug, Clone, Copy, Args)]
struct Sensor {
    /// Columns of the camera's image
    #[arg(long, value_name = "PIXELS", default_value_t = 640)]
    width: usize,

    /// The standard deviation of its noise, in metres
    #[arg(long = "noise", value_name = "METRES", default_value_t = 0.001)]
    noise_m: f64,
}

/// An item and its pose in the container.
type Placed = (Arc<Model>, Isometry3<f64>);

/// What lies in the container, and how high it reaches per sample.
struct Content {
    items: Vec<Placed>,
    heights_m: Vec<f64>,
}

impl Content {
    /// The pose of a turned object lowered to where it touches, its box's middle over a place; `None` where it does
    /// not fit between the walls or below the rim.
    fn lowered(
        &self,
        model: &Model,
        rotation: &UnitQuaternion<f64>,
        middle: Point2<f64>,
    ) -> Option<Isometry3<f64>> {
        let turned = model.mesh.transformed(&nalgebra::convert(*rotation));
        let bounds = turned.bounds().unwrap();
        let half = bounds.extents_m() / 2.0;
        let gap_m = 0.001;
        let fits = middle.x - half.x > gap_m
            && middle.y - half.y > gap_m
            && middle.x + half.x < CONTAINER.x_m - gap_m
            && middle.y + half.y < CONTAINER.y_m - gap_m;
        if !fits {
            return None;
        }
        let centre = bounds.lowest + half;
        let over = Translation3::new(middle.x - centre.x, middle.y - centre.y, 0.0) * *rotation;
        let mut rest_m = -bounds.lowest.z;
        each_square(&model.mesh.transformed(&over), |square, lowest_m, _| {
            rest_m = f64::max(rest_m, self.heights_m[square] - lowest_m);
        });
        (rest_m + bounds.highest.z < CONTAINER.z_m - 0.005)
            .then(|| Translation3::new(0.0, 0.0, rest_m) * over)
    }

    fn add(&mut self, model: &Arc<Model>, pose: Isometry3<f64>) {
        let heights_m = &mut self.heights_m;
        each_square(&model.mesh.transformed(&pose), |square, _, highest_m| {
            heights_m[square] = heights_m[square].max(highest_m);
        });
        self.items.push((model.clone(), pose));
    }
}

/// The lowest and highest parts of each triangle in each square that it touches.
fn each_square(mesh: &Mesh, mut visit: impl FnMut(usize, f64, f64)) {
    let raster = Raster {
        origin: Point2::origin(),
        pitch_m: PITCH_M,
        nx: SIDE,
        ny: SIDE,
    };
    for corners in mesh.corners() {
        rasterise(&corners, &raster, |x, y, lowest_m, highest_m| {
            visit(x * SIDE + y, lowest_m, highest_m);
        });
    }
}

/// The lowest of some random places, at random yaws.
fn placed(content: &Content, model: &Model, random: &mut ChaCha8Rng) -> Option<Isometry3<f64>> {
    let pose = random.random_range(0..model.resting_poses.len().min(4));
    let poses = (0..20).filter_map(|_| {
        let rotation = any_turn(random) * model.resting_poses[pose].rotation;
        let place = Point2::new(
            between(random, 0.01, CONTAINER.x_m - 0.01),
            between(random, 0.01, CONTAINER.y_m - 0.01),
        );
        let pose = content.lowered(model, &rotation, place)?;
        let top_m = model.mesh.transformed(&pose).bounds()?.highest.z;
        Some((top_m, pose))
    });
    let lowest = poses.min_by(|one, other| one.0.total_cmp(&other.0));
    lowest.map(|(_, pose)| pose)
}

/// A horizontal direction.
fn any_direction(random: &mut ChaCha8Rng) -> Vector3<f64> {
    any_turn(random) * Vector3::x()
}

fn middle(model: &Model, pose: &Isometry3<f64>) -> Point2<f64> {
    let bounds = model.mesh.transformed(pose).bounds().unwrap();
    nalgebra::center(&bounds.lowest, &bounds.highest).xy()
}

/// What becomes of a planned item; `None` where the case cannot be made.
fn outcome(
    case: usize,
    content: &Content,
    object: &LibraryObject,
    planned: &Isometry3<f64>,
    random: &mut ChaCha8Rng,
) -> Option<Isometry3<f64>> {
    let model = &object.model;
    if case == 0 {
        let axis = Unit::try_new(Vector3::from_fn(|_, _| between(random, -1.0, 1.0)), 1e-3)?;
        let angle = between(random, -2.0, 2.0).to_radians();
        let centre = planned * model.mass.centre_of_mass_m;
        let tilt =
            Isometry3::rotation_wrt_point(UnitQuaternion::from_axis_angle(&axis, angle), centre);
        let shift = any_direction(random) * between(random, 0.0, 0.002);
        return Some(Translation3::from(shift) * tilt * planned);
    }
    let start = middle(model, planned);
    let is_moved = case == 1;
    (0..60).find_map(|_| {
        let least_m = if is_moved { 0.01 } else { 0.0 };
        let shift = any_direction(random).xy() * between(random, least_m, 0.06);
        let rotation = if is_moved {
            turn(between(random, -0.5, 0.5)) * planned.rotation
        } else {
            let poses = &model.resting_poses;
            let other = &poses[random.random_range(0..poses.len())];
            any_turn(random) * other.rotation
        };
        let pose = content.lowered(model, &rotation, start + shift)?;
        let is_case = if is_moved {
            let moved = pose * object.centre_m - planned * object.centre_m;
            moved.xy().norm() > 0.01
        } else {
            is_toppled(object, planned, &pose)
        };
        is_case.then_some(pose)
    })
}

/// Whether the object is on another side, told apart by more than its near symmetry: no yaw brings it back.
fn is_toppled(object: &LibraryObject, planned: &Isometry3<f64>, pose: &Isometry3<f64>) -> bool {
    let symmetry = &object.near_symmetry;
    (0..72).all(|step| {
        let yaw = turn(f64::from(step) * 5.0_f64.to_radians());
        symmetry.angle_between(&(yaw * pose.rotation), &planned.rotation) > 0.45
    })
}

/// The container and the ground around it.
fn container() -> Vec<Mesh> {
    let wall_m = 0.004;
    let (x, y, z) = (CONTAINER.x_m, CONTAINER.y_m, CONTAINER.z_m);
    let mut meshes = simulated::container([x, y, z], wall_m, wall_m, 0.0);
    meshes.push(Mesh::cuboid([-0.5, -0.5, -0.02], [x + 0.5, y + 0.5, -0.01]));
    meshes
}

fn seen(
    items: &[Placed],
    eye_m: Point3<f64>,
    seed: u64,
    sensor: Sensor,
) -> Outcome<Vec<Point3<f64>>> {
    let walls = container();
    let walls = walls.iter().map(|mesh| body(mesh, Isometry3::identity()));
    let items = items.iter().map(|(model, pose)| body(&model.mesh, *pose));
    let bodies: Vec<_> = walls.chain(items).collect();
    let width = sensor.width;
    let focal = 600.0 * width as f64 / 640.0;
    let intrinsics = Intrinsics::centred(width, width * 3 / 4, focal).or_run()?;
    let noise = NoiseModel {
        deviation_m: sensor.noise_m,
        ..NoiseModel::default()
    };
    let target = Point3::new(0.16, 0.17, 0.0);
    let camera = DepthCamera::looking_at(intrinsics, eye_m, &target);
    let image = crate::scene::seen(&camera, &bodies, &noise, seed)?;
    Ok(image.in_world_m(&camera.world_from_camera).collect())
}

/// The greatest height in each square; what is unseen takes that of its neighbours, or is higher than the rim.
fn surface(points_m: &[Point3<f64>]) -> Surface {
    let mut heights_m = vec![f32::NAN; SIDE * SIDE];
    for point in points_m {
        let (x, y) = ((point.x / PITCH_M).floor(), (point.y / PITCH_M).floor());
        let is_inside = x >= 0.0 && y >= 0.0 && x < SIDE as f64 && y < SIDE as f64;
        if is_inside && point.z > -0.01 {
            let height_m = &mut heights_m[x as usize * SIDE + y as usize];
            *height_m = height_m.max(point.z.max(0.0) as f32);
        }
    }
    let filled = (0..SIDE * SIDE).map(|square| {
        if !heights_m[square].is_nan() {
            return heights_m[square];
        }
        let (x, y) = (square / SIDE, square % SIDE);
        let mut greatest_m = f32::NAN;
        for x in x.saturating_sub(2)..(x + 3).min(SIDE) {
            for y in y.saturating_sub(2)..(y + 3).min(SIDE) {
                greatest_m = greatest_m.max(heights_m[x * SIDE + y]);
            }
        }
        if greatest_m.is_nan() { 0.4 } else { greatest_m }
    });
    Surface::from_metres(SIDE, SIDE, PITCH_M, filled.collect()).unwrap()
}

/// Some of the items shifted by up to 3 mm.
fn shifted(items: &[Placed], random: &mut ChaCha8Rng) -> Vec<Placed> {
    let mut items = items.to_vec();
    for (_, pose) in &mut items {
        if random.random::<f64>() <= 0.3 {
            let shift = any_direction(random) * between(random, 0.0, 0.003);
            *pose = Translation3::from(shift) * *pose;
        }
    }
    items
}

/// Another object near the planned place, lowered to where it touches.
fn stranger(
    library: &Library,
    index: usize,
    content: &Content,
    planned: &Isometry3<f64>,
    random: &mut ChaCha8Rng,
) -> Option<Placed> {
    let start = middle(&library.objects[index].model, planned);
    (0..60).find_map(|_| {
        let other = random.random_range(0..library.objects.len());
        if library.are_alike(index, other) {
            return None;
        }
        let model = &library.objects[other].model;
        let rotation = any_turn(random) * model.resting_poses[0].rotation;
        let shift = Vector2::from_fn(|_, _| between(random, -0.03, 0.03));
        let pose = content.lowered(model, &rotation, start + shift)?;
        Some((model.clone(), pose))
    })
}

struct Trial {
    name: String,
    case: usize,
    inspection: Inspection,
    /// The error of the pose, modulo symmetry.
    error: Option<PoseError>,
    time_ms: f64,
}

impl Trial {
    fn told(&self) -> usize {
        match self.inspection {
            Inspection::AsPlanned(_) => 0,
            Inspection::Moved(_) => 1,
            Inspection::Toppled(_) => 2,
            Inspection::Missing(_) => 3,
            Inspection::Unclear(_) => 4,
        }
    }

    fn csv(&self) -> String {
        let (reason, best) = match &self.inspection {
            Inspection::Unclear(unclear) => (format!("{:?}", unclear.reason), unclear.best),
            other => (String::new(), other.lying().copied()),
        };
        let agreement = match best.map(|lying| lying.agreement) {
            Some(it) => format!(
                "{:.4},{:.4},{:.4}",
                it.fitness, it.unexplained, it.contradicted
            ),
            None => ",,".to_owned(),
        };
        format!(
            "{},{},{},{:.2},{},{agreement},{}",
            self.name,
            CASES[self.case],
            TOLD[self.told()],
            self.time_ms,
            columns_of(self.error),
            reason.replace(',', ";")
        )
    }
}

fn trial(
    library: &Library,
    index: usize,
    case: usize,
    random: &mut ChaCha8Rng,
    sensor: Sensor,
) -> Outcome<Option<Trial>> {
    let object = &library.objects[index];
    let mut content = Content {
        items: Vec::new(),
        heights_m: vec![0.0; SIDE * SIDE],
    };
    for _ in 0..random.random_range(0..8) {
        let model = &library.objects[random.random_range(0..library.objects.len())].model;
        if let Some(pose) = placed(&content, model, random) {
            content.add(model, pose);
        }
    }
    let Some(planned) = placed(&content, &object.model, random) else {
        return Ok(None);
    };
    let eye_m = Point3::new(
        between(random, 0.1, 0.22),
        between(random, 0.1, 0.22),
        between(random, 0.85, 1.0),
    );
    let truth = match case {
        0..3 => match outcome(case, &content, object, &planned, random) {
            None => return Ok(None),
            truth => truth,
        },
        _ => None,
    };
    let before = surface(&seen(&content.items, eye_m, random.random(), sensor)?);
    let mut items = shifted(&content.items, random);
    items.extend(truth.map(|pose| (object.model.clone(), pose)));
    if case == 4 {
        let Some(stranger) = stranger(library, index, &content, &planned, random) else {
            return Ok(None);
        };
        items.push(stranger);
    }
    let points_m = seen(&items, eye_m, random.random(), sensor)?;
    let after = ContainerCloud {
        points_m: &points_m,
        eye_m,
    };
    let settings = InspectionSettings {
        sensor_deviation_m: sensor.noise_m,
        least_rise_m: 5.0 * sensor.noise_m,
        ..InspectionSettings::default()
    };
    let (inspection, time_ms) =
        timed(|| inspect(object, &planned, &before, &after, CONTAINER, &settings));
    let error = truth.zip(inspection.lying()).and_then(|(truth, lying)| {
        library.pose_error(index, &truth, index, &lying.container_from_item)
    });
    Ok(Some(Trial {
        name: object.model.name.clone(),
        case,
        inspection,
        error,
        time_ms,
    }))
}

fn report(trials: &[Trial]) {
    println!(
        "| is | cases | told {} | right, unclear ones aside | pose within 5 mm and 5 degrees | within 10 mm and 10 degrees | median ms | 99 % ms |",
        TOLD.join(" | ")
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (case, name) in CASES.iter().enumerate() {
        let of_case: Vec<&Trial> = trials.iter().filter(|trial| trial.case == case).collect();
        let told = |told: usize| of_case.iter().filter(|trial| trial.told() == told).count();
        let share = |part: usize, whole: usize| format!("{:.1} %", percentage(part, whole.max(1)));
        let shares: Vec<String> = (0..TOLD.len())
            .map(|index| share(told(index), of_case.len()))
            .collect();
        // Where another object lies, the item is missing, whether or not that is told.
        let (right, clear) = if case < 4 {
            (told(case), of_case.len() - told(4))
        } else {
            (told(3) + told(4), of_case.len())
        };
        let errors: Vec<PoseError> = of_case.iter().filter_map(|trial| trial.error).collect();
        let within = |metres: f64, degrees: f64| {
            let is_good = |error: &&PoseError| error.is_within(metres, degrees.to_radians());
            let good = errors.iter().filter(is_good).count();
            format!("{} of {}", share(good, errors.len()), errors.len())
        };
        let times_ms = of_case.iter().map(|trial| trial.time_ms);
        let [median_ms, most_ms] = quantiles(times_ms, [0.5, 0.99]);
        println!(
            "| {name} | {} | {} | {} | {} | {} | {median_ms:.1} | {most_ms:.1} |",
            of_case.len(),
            shares.join(" | "),
            share(right, clear),
            within(0.005, 5.0),
            within(0.01, 10.0),
        );
    }
    let mut reasons: BTreeMap<(usize, String), usize> = BTreeMap::new();
    for trial in trials {
        if let Inspection::Unclear(unclear) = &trial.inspection {
            let reason = (trial.case, unclear.reason.to_string());
            *reasons.entry(reason).or_default() += 1;
        }
    }
    for ((case, reason), count) in &reasons {
        println!("  {}: {count} x {reason}", CASES[*case]);
    }
    let times_ms = trials.iter().map(|trial| trial.time_ms);
    let [median, most, greatest] = quantiles(times_ms, [0.5, 0.99, 1.0]);
    println!(
        "all {}: median {median:.1} ms, 99 % {most:.1} ms, greatest {greatest:.1} ms",
        trials.len()
    );
}

pub(crate) fn run(arguments: &InspectionArguments) -> Outcome {
    let models = models(&Source::Folder(arguments.folder.clone()))?;
    let library = Library::new(&models, LibrarySettings::default()).or_input()?;
    let mut trials = Vec::new();
    let mut impossible = 0;
    for (index, object) in library.objects.iter().enumerate().step_by(arguments.every) {
        let only = arguments.only.as_ref();
        if only.is_some_and(|only| !object.model.name.contains(only)) {
            continue;
        }
        for case in 0..CASES.len() {
            let mut random = ChaCha8Rng::seed_from_u64(arguments.seed);
            random.set_stream((index * CASES.len() + case) as u64);
            for _ in 0..arguments.views {
                match trial(&library, index, case, &mut random, arguments.sensor)? {
                    Some(trial) => trials.push(trial),
                    None => impossible += 1,
                }
            }
        }
    }
    let all = models.len();
    println!("{all} objects; {impossible} cases could not be made");
    report(&trials);
    let head =
        "name,case,told,time_ms,position_mm,angle_deg,fitness,unexplained,contradicted,reason";
    write_csv(arguments.csv.as_ref(), head, trials.iter().map(Trial::csv))
}
