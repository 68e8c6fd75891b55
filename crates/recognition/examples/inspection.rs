//! How often an inspection tells what became of a placed item, in simulated views.
//!
//! `inspection FOLDER [--views N] [--seed N] [--only NAME] [--every N] [--csv FILE] [--width PIXELS]
//! [--noise METRES]`
//!
//! The objects of a folder lie in a container, dropped without physics: each straight down to where it touches. One more
//! is planned, and then lies as planned, elsewhere, on another side, or not at all; or another object lies there. A depth
//! camera some 0.9 m above the floor sees the container before and after.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    missing_docs,
    reason = "an experiment stops where something is wrong"
)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use nalgebra::{Isometry3, Point2, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings, Source};
use ppnpack_catalogue::mesh::{Bounds, Mesh};
use ppnpack_catalogue::object::Model;
use ppnpack_catalogue::raster::{Raster, rasterise};
use ppnpack_packing::grid::{ContainerSize, Resolution};
use ppnpack_packing::heightmap::Surface;
use ppnpack_recognition::inspection::{ContainerCloud, Inspection, InspectionSettings, inspect};
use ppnpack_recognition::library::{Library, LibraryObject, LibrarySettings};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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

struct Arguments {
    folder: PathBuf,
    views: usize,
    seed: u64,
    only: Option<String>,
    every: usize,
    csv: Option<PathBuf>,
    sensor: Sensor,
}

#[derive(Clone, Copy)]
struct Sensor {
    /// Columns of the image.
    width: usize,
    /// The standard deviation of the noise, in metres.
    noise_m: f64,
}

impl Arguments {
    fn parse() -> Self {
        let mut words = std::env::args().skip(1);
        let mut arguments = Self {
            folder: PathBuf::from(words.next().expect("give the folder of objects")),
            views: 1,
            seed: 1,
            only: None,
            every: 1,
            csv: None,
            sensor: Sensor {
                width: 640,
                noise_m: 0.001,
            },
        };
        while let Some(word) = words.next() {
            let mut value = || words.next().expect("a value is missing");
            match word.as_str() {
                "--views" => arguments.views = value().parse().unwrap(),
                "--seed" => arguments.seed = value().parse().unwrap(),
                "--only" => arguments.only = Some(value()),
                "--every" => arguments.every = value().parse().unwrap(),
                "--width" => arguments.sensor.width = value().parse().unwrap(),
                "--noise" => arguments.sensor.noise_m = value().parse().unwrap(),
                "--csv" => arguments.csv = Some(value().into()),
                other => panic!("{other} is no option"),
            }
        }
        arguments
    }
}

fn models(folder: &Path) -> Vec<Arc<Model>> {
    let settings = Settings {
        cache: CacheDir::At(std::env::temp_dir().join("ppnpack-recognition-models")),
        ..Settings::default()
    };
    let source = Source::Folder(folder.to_owned());
    let catalogue =
        Catalogue::load(&source, &settings, &Resolution::reference(), &|_, _| ()).unwrap();
    catalogue
        .objects
        .iter()
        .map(|object| object.model.clone())
        .collect()
}

/// What lies in the container, and how high it reaches per sample.
#[derive(Clone)]
struct Content {
    items: Vec<(Arc<Model>, Isometry3<f64>)>,
    heights_m: Vec<f64>,
}

impl Content {
    fn empty() -> Self {
        Self {
            items: Vec::new(),
            heights_m: vec![0.0; SIDE * SIDE],
        }
    }

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

fn between(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.random::<f64>()
}

fn turn(yaw_rad: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad)
}

/// The lowest of some random places, at random yaws.
fn placed(content: &Content, model: &Model, random: &mut ChaCha8Rng) -> Option<Isometry3<f64>> {
    let pose = random.random_range(0..model.resting_poses.len().min(4));
    let mut best: Option<Isometry3<f64>> = None;
    let mut lowest_m = f64::INFINITY;
    for _ in 0..20 {
        let rotation =
            turn(between(random, 0.0, std::f64::consts::TAU)) * model.resting_poses[pose].rotation;
        let place = Point2::new(
            between(random, 0.01, CONTAINER.x_m - 0.01),
            between(random, 0.01, CONTAINER.y_m - 0.01),
        );
        if let Some(pose) = content.lowered(model, &rotation, place) {
            let top_m = model.mesh.transformed(&pose).bounds().unwrap().highest.z;
            if top_m < lowest_m {
                (lowest_m, best) = (top_m, Some(pose));
            }
        }
    }
    best
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
        let direction = turn(between(random, 0.0, std::f64::consts::TAU)) * Vector3::x();
        return Some(Translation3::from(direction * between(random, 0.0, 0.002)) * tilt * planned);
    }
    let start = middle(model, planned);
    for _ in 0..60 {
        let direction = turn(between(random, 0.0, std::f64::consts::TAU)) * Vector3::x();
        let least_m = if case == 1 { 0.01 } else { 0.0 };
        let shift = direction.xy() * between(random, least_m, 0.06);
        let rotation = if case == 1 {
            turn(between(random, -0.5, 0.5)) * planned.rotation
        } else {
            let poses = &model.resting_poses;
            let other = &poses[random.random_range(0..poses.len())];
            turn(between(random, 0.0, std::f64::consts::TAU)) * other.rotation
        };
        let Some(pose) = content.lowered(model, &rotation, start + shift) else {
            continue;
        };
        let is_case = if case == 1 {
            (pose * object.centre_m - planned * object.centre_m)
                .xy()
                .norm()
                > 0.01
        } else {
            is_toppled(object, planned, &pose)
        };
        if is_case {
            return Some(pose);
        }
    }
    None
}

/// Whether the object is on another side, told apart by more than its near symmetry: no yaw brings it back.
fn is_toppled(object: &LibraryObject, planned: &Isometry3<f64>, pose: &Isometry3<f64>) -> bool {
    (0..72).all(|step| {
        let yaw = turn(f64::from(step) * 5.0_f64.to_radians());
        let angle = object
            .near_symmetry
            .angle_between(&(yaw * pose.rotation), &planned.rotation);
        angle > 0.45
    })
}

fn container() -> Mesh {
    let wall_m = 0.004;
    let (x, y, z) = (CONTAINER.x_m, CONTAINER.y_m, CONTAINER.z_m);
    let boxes = [
        ([-0.5, -0.5, -0.02], [x + 0.5, y + 0.5, -0.01]),
        ([0.0, 0.0, -0.004], [x, y, 0.0]),
        ([-wall_m, -wall_m, -0.004], [0.0, y + wall_m, z]),
        ([x, -wall_m, -0.004], [x + wall_m, y + wall_m, z]),
        ([-wall_m, -wall_m, -0.004], [x + wall_m, 0.0, z]),
        ([-wall_m, y, -0.004], [x + wall_m, y + wall_m, z]),
    ];
    let mut mesh = Mesh {
        vertices: Vec::new(),
        triangles: Vec::new(),
    };
    for (lowest, highest) in boxes {
        let bounds = Bounds {
            lowest: Point3::from(lowest),
            highest: Point3::from(highest),
        };
        mesh.append(&bounds.mesh());
    }
    mesh
}

fn seen(
    items: &[(Arc<Model>, Isometry3<f64>)],
    eye_m: Point3<f64>,
    seed: u64,
    sensor: Sensor,
) -> Vec<Point3<f64>> {
    let container = container();
    let mut bodies = vec![Body {
        vertices: &container.vertices,
        triangles: &container.triangles,
        world_from_body: Isometry3::identity(),
    }];
    bodies.extend(items.iter().map(|(model, pose)| Body {
        vertices: &model.mesh.vertices,
        triangles: &model.mesh.triangles,
        world_from_body: *pose,
    }));
    let intrinsics = Intrinsics::centred(
        sensor.width,
        sensor.width * 3 / 4,
        600.0 * sensor.width as f64 / 640.0,
    )
    .unwrap();
    let noise = NoiseModel {
        deviation_m: sensor.noise_m,
        ..NoiseModel::default()
    };
    let target = Point3::new(0.16, 0.17, 0.0);
    let camera = DepthCamera::looking_at(intrinsics, eye_m, &target);
    let view = camera.see(&bodies).unwrap();
    let image = view.noisy_points(&noise, seed).unwrap();
    image.in_world_m(&camera.world_from_camera).collect()
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
fn shifted(
    items: &[(Arc<Model>, Isometry3<f64>)],
    random: &mut ChaCha8Rng,
) -> Vec<(Arc<Model>, Isometry3<f64>)> {
    let shift = |pose: &Isometry3<f64>, random: &mut ChaCha8Rng| {
        if random.random::<f64>() > 0.3 {
            return *pose;
        }
        let direction = turn(between(random, 0.0, std::f64::consts::TAU)) * Vector3::x();
        Translation3::from(direction * between(random, 0.0, 0.003)) * pose
    };
    items
        .iter()
        .map(|(model, pose)| (model.clone(), shift(pose, random)))
        .collect()
}

/// Another object near the planned place, lowered to where it touches.
fn stranger(
    library: &Library,
    index: usize,
    content: &Content,
    planned: &Isometry3<f64>,
    random: &mut ChaCha8Rng,
) -> Option<(Arc<Model>, Isometry3<f64>)> {
    let start = middle(&library.objects[index].model, planned);
    (0..60).find_map(|_| {
        let other = random.random_range(0..library.objects.len());
        if library.are_alike(index, other) {
            return None;
        }
        let model = &library.objects[other].model;
        let rotation =
            turn(between(random, 0.0, std::f64::consts::TAU)) * model.resting_poses[0].rotation;
        let shift = Vector3::new(
            between(random, -0.03, 0.03),
            between(random, -0.03, 0.03),
            0.0,
        );
        let pose = content.lowered(model, &rotation, start + shift.xy())?;
        Some((model.clone(), pose))
    })
}

struct Trial {
    name: String,
    case: usize,
    inspection: Inspection,
    /// The error of the pose, in metres and radians, modulo symmetry.
    error: Option<(f64, f64)>,
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
        let (case, told) = (CASES[self.case], TOLD[self.told()]);
        let mut line = format!("{},{case},{told},{:.2}", self.name, self.time_ms);
        let (metres, radians) = self.error.unwrap_or((f64::NAN, f64::NAN));
        write!(line, ",{:.2},{:.2}", metres * 1e3, radians.to_degrees()).unwrap();
        let (reason, best) = match &self.inspection {
            Inspection::Unclear(unclear) => (format!("{:?}", unclear.reason), unclear.best),
            other => (String::new(), other.lying().copied()),
        };
        if let Some(best) = best {
            let agreement = best.agreement;
            write!(
                line,
                ",{:.4},{:.4},{:.4}",
                agreement.fitness, agreement.unexplained, agreement.contradicted
            )
            .unwrap();
        } else {
            line.push_str(",,,");
        }
        line.push(',');
        line.push_str(&reason.replace(',', ";"));
        line
    }
}

fn trial(
    library: &Library,
    index: usize,
    case: usize,
    random: &mut ChaCha8Rng,
    sensor: Sensor,
) -> Option<Trial> {
    let object = &library.objects[index];
    let mut content = Content::empty();
    for _ in 0..random.random_range(0..8) {
        let model = &library.objects[random.random_range(0..library.objects.len())].model;
        if let Some(pose) = placed(&content, model, random) {
            content.add(model, pose);
        }
    }
    let planned = placed(&content, &object.model, random)?;
    let eye_m = Point3::new(
        between(random, 0.1, 0.22),
        between(random, 0.1, 0.22),
        between(random, 0.85, 1.0),
    );
    let truth = if case >= 3 {
        None
    } else {
        Some(outcome(case, &content, object, &planned, random)?)
    };
    let before = surface(&seen(&content.items, eye_m, random.random(), sensor));
    let mut items = shifted(&content.items, random);
    items.extend(truth.map(|pose| (object.model.clone(), pose)));
    if case == 4 {
        items.push(stranger(library, index, &content, &planned, random)?);
    }
    let points_m = seen(&items, eye_m, random.random(), sensor);
    let after = ContainerCloud {
        points_m: &points_m,
        eye_m,
    };
    let settings = InspectionSettings {
        sensor_deviation_m: sensor.noise_m,
        least_rise_m: 5.0 * sensor.noise_m,
        ..InspectionSettings::default()
    };
    let start = Instant::now();
    let inspection = inspect(object, &planned, &before, &after, CONTAINER, &settings);
    let time_ms = start.elapsed().as_secs_f64() * 1e3;
    let error = truth.zip(inspection.lying()).and_then(|(truth, lying)| {
        let error = library.pose_error(index, &truth, index, &lying.container_from_item)?;
        Some((error.position_m, error.angle_rad))
    });
    Some(Trial {
        name: object.model.name.clone(),
        case,
        inspection,
        error,
        time_ms,
    })
}

fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = ((values.len() as f64 * share) as usize).min(values.len().saturating_sub(1));
    values.get(rank).copied().unwrap_or(f64::NAN)
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
        let count = of_case.len().max(1) as f64;
        let shares: Vec<String> = (0..TOLD.len())
            .map(|index| format!("{:.1} %", 100.0 * told(index) as f64 / count))
            .collect();
        // Where another object lies, the item is missing, whether or not that is told.
        let (right, clear) = if case < 4 {
            (told(case), of_case.len() - told(4))
        } else {
            (told(3) + told(4), of_case.len())
        };
        let errors: Vec<(f64, f64)> = of_case.iter().filter_map(|trial| trial.error).collect();
        let within = |metres: f64, degrees: f64| {
            let good = errors
                .iter()
                .filter(|(position, angle)| *position <= metres && angle.to_degrees() <= degrees)
                .count();
            format!(
                "{:.1} % of {}",
                100.0 * good as f64 / errors.len().max(1) as f64,
                errors.len()
            )
        };
        let times: Vec<f64> = of_case.iter().map(|trial| trial.time_ms).collect();
        println!(
            "| {name} | {} | {} | {:.1} % | {} | {} | {:.1} | {:.1} |",
            of_case.len(),
            shares.join(" | "),
            100.0 * right as f64 / clear.max(1) as f64,
            within(0.005, 5.0),
            within(0.01, 10.0),
            quantile(times.clone(), 0.5),
            quantile(times, 0.99),
        );
    }
    let mut reasons: BTreeMap<(usize, String), usize> = BTreeMap::new();
    for trial in trials {
        if let Inspection::Unclear(unclear) = &trial.inspection {
            *reasons
                .entry((trial.case, unclear.reason.to_string()))
                .or_default() += 1;
        }
    }
    for ((case, reason), count) in &reasons {
        println!("  {}: {count} x {reason}", CASES[*case]);
    }
    let times: Vec<f64> = trials.iter().map(|trial| trial.time_ms).collect();
    println!(
        "all {}: median {:.1} ms, 99 % {:.1} ms, greatest {:.1} ms",
        times.len(),
        quantile(times.clone(), 0.5),
        quantile(times.clone(), 0.99),
        quantile(times, 1.0)
    );
}

fn main() {
    let arguments = Arguments::parse();
    let models = models(&arguments.folder);
    let library = Library::new(&models, LibrarySettings::default()).unwrap();
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
                match trial(&library, index, case, &mut random, arguments.sensor) {
                    Some(trial) => trials.push(trial),
                    None => impossible += 1,
                }
            }
        }
    }
    println!(
        "{} objects; {impossible} cases could not be made",
        models.len()
    );
    report(&trials);
    if let Some(path) = &arguments.csv {
        let head = "name,case,told,time_ms,position_mm,angle_deg,fitness,unexplained,contradicted,reason\n";
        let lines: Vec<String> = trials.iter().map(Trial::csv).collect();
        std::fs::write(path, format!("{head}{}\n", lines.join("\n"))).unwrap();
    }
}
