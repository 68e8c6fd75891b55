//! `ppnpack experiment recognition`: how well objects of a folder are recognised in simulated views, and how many of
//! others are called unknown.
//!
//! Each object stands in each of its resting poses (of at least 2 %) at a random yaw and place, and a depth camera some
//! 0.9 m above takes one noisy view.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a measurement that cannot run should say so at once"
)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::catalogue::Source;
use ppnpack_catalogue::object::Model;
use ppnpack_cli::failure::{OrInput, OrRun, Outcome};
use ppnpack_files::write_whole;
use ppnpack_recognition::evaluation::PoseError;
use ppnpack_recognition::library::{Library, LibraryObject, LibrarySettings};
use ppnpack_recognition::recognise::{Candidate, Recogniser, Recognition, RecognitionSettings};
use ppnpack_recognition::segmentation::{Cluster, Region, SegmentationSettings, segment};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene::{between, body, models, seen, turn};
use crate::statistics::quantile;

const LEAST_PROBABILITY: f64 = 0.02;

/// Shows each object of a folder in each of its resting poses to a recogniser; or, as strangers, objects that it does
/// not know, to choose thresholds on.
#[derive(Debug, Args)]
pub(crate) struct RecognitionArguments {
    /// The folder of the objects that are known
    #[arg(value_name = "DIR")]
    known: PathBuf,

    /// Show those of this folder as strangers
    #[arg(long, value_name = "DIR")]
    strangers: Option<PathBuf>,

    /// Show each known object to a library without it and its twins, as a stranger
    #[arg(long)]
    left_out: bool,

    /// Show the built-in household set as strangers
    #[arg(long)]
    builtin: bool,

    /// Views of each resting pose
    #[arg(long, value_name = "COUNT", default_value_t = 2)]
    views: usize,

    /// The seed of everything that is random
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    seed: u64,

    /// Where each view is written as a line of a table
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    /// Show only objects with this in their name
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
}

fn folder(path: &Path) -> Outcome<Vec<Arc<Model>>> {
    models(&Source::Folder(path.to_owned()))
}

fn library(models: &[Arc<Model>]) -> Outcome<Library> {
    Library::new(models, LibrarySettings::default()).or_input()
}

/// What one view gave.
struct Trial {
    name: String,
    pose: usize,
    points: usize,
    recognition: Option<Recognition>,
    is_right: bool,
    error: Option<PoseError>,
    looks_same: bool,
    segment_ms: f64,
    recognise_ms: f64,
}

impl Trial {
    fn best(&self) -> Option<&Candidate> {
        match self.recognition.as_ref()? {
            Recognition::Known(known) => Some(&known.best),
            Recognition::Unknown(unknown) => unknown.candidates.first(),
        }
    }

    fn is_known(&self) -> bool {
        matches!(self.recognition, Some(Recognition::Known(_)))
    }

    fn is_placed(&self) -> bool {
        self.error
            .is_some_and(|error| error.is_within(0.003, 3.0_f64.to_radians()))
    }

    /// Whether the pose is quite another one that no camera above could tell from the true one.
    fn is_hidden_difference(&self) -> bool {
        self.looks_same && self.error.is_some_and(|error| error.angle_rad > 0.25)
    }

    fn csv(&self) -> String {
        let mut line = format!(
            "{},{},{},{},{}",
            self.name,
            self.pose,
            self.points,
            u8::from(self.is_known()),
            u8::from(self.is_right)
        );
        if let Some(best) = self.best() {
            let agreement = best.agreement;
            let margin = match &self.recognition {
                Some(Recognition::Known(known)) => known.margin,
                _ => f64::NAN,
            };
            write!(
                line,
                ",{},{:.4},{:.4},{:.4},{:.5},{:.4}",
                best.name,
                agreement.fitness,
                agreement.unexplained,
                agreement.contradicted,
                agreement.residual_m,
                margin
            )
            .unwrap();
        } else {
            line.push_str(",,,,,,");
        }
        let error = self.error.map_or((f64::NAN, f64::NAN), |error| {
            (error.position_m * 1e3, error.angle_rad.to_degrees())
        });
        write!(
            line,
            ",{:.2},{:.2},{:.1},{:.1}",
            error.0, error.1, self.segment_ms, self.recognise_ms
        )
        .unwrap();
        line
    }
}

/// One view of an object lying on a tray.
struct Shot {
    cluster: Option<Cluster>,
    world_from_item: Isometry3<f64>,
    segment_ms: f64,
}

fn shoot(model: &Model, rotation: &UnitQuaternion<f64>, random: &mut ChaCha8Rng) -> Outcome<Shot> {
    let mut between = |low: f64, high: f64| between(random, low, high);
    let turned = turn(between(0.0, std::f64::consts::TAU)) * rotation;
    let lowest_m = model
        .mesh
        .vertices
        .iter()
        .map(|vertex| (turned * vertex).z)
        .fold(f64::INFINITY, f64::min);
    let centre = turned * model.mass.centre_of_mass_m;
    let place = Vector3::new(
        between(-0.12, 0.12) - centre.x,
        between(-0.08, 0.08) - centre.y,
        -lowest_m,
    );
    let world_from_item = Translation3::from(place) * turned;
    let eye = Point3::new(
        between(-0.05, 0.05),
        between(-0.05, 0.05),
        between(0.8, 1.0),
    );
    let seed = random.random();
    let corner = |x, y| Point3::new(x, y, 0.0);
    let tray = [
        corner(-2.0, -2.0),
        corner(2.0, -2.0),
        corner(2.0, 2.0),
        corner(-2.0, 2.0),
    ];
    let bodies = [
        Body {
            vertices: &tray,
            triangles: &[[0, 1, 2], [0, 2, 3]],
            world_from_body: Isometry3::identity(),
        },
        body(&model.mesh, world_from_item),
    ];
    let intrinsics = Intrinsics::centred(640, 480, 600.0).or_run()?;
    let camera = DepthCamera::looking_at(intrinsics, eye, &Point3::new(0.0, 0.02, 0.0));
    let image = seen(&camera, &bodies, &NoiseModel::default(), seed)?;
    let region = Region {
        lowest_m: Point3::new(-0.4, -0.3, -0.05),
        highest_m: Point3::new(0.4, 0.3, 0.5),
    };
    let start = Instant::now();
    let found = segment(
        image.in_world_m(&camera.world_from_camera),
        &eye,
        &SegmentationSettings::of(region),
    );
    Ok(Shot {
        cluster: found.clusters.into_iter().next(),
        world_from_item,
        segment_ms: start.elapsed().as_secs_f64() * 1e3,
    })
}

fn down(rotation: &UnitQuaternion<f64>) -> Unit<Vector3<f64>> {
    Unit::new_unchecked(rotation.inverse() * -Vector3::z())
}

/// A resting pose among those that a template stands for, by their probabilities.
fn draw(
    object: &LibraryObject,
    template: usize,
    library: &Library,
    random: &mut ChaCha8Rng,
) -> UnitQuaternion<f64> {
    let direction = down(&object.poses[template].support_from_item.rotation);
    let within = library.settings.same_pose_rad;
    let same: Vec<_> = object
        .model
        .resting_poses
        .iter()
        .filter(|pose| {
            object
                .symmetry
                .joins(&direction, &down(&pose.rotation), within)
        })
        .collect();
    let total: f64 = same.iter().map(|pose| pose.probability).sum();
    let mut left = random.random::<f64>() * total;
    for pose in &same {
        left -= pose.probability;
        if left <= 0.0 {
            return pose.rotation;
        }
    }
    same.first().unwrap().rotation
}

/// Views of the objects of `shown`; `known_as` gives their index in the recogniser's library, if they are in it.
fn trials(
    shown: &Library,
    recogniser: &Recogniser,
    known_as: impl Fn(usize) -> Option<usize>,
    arguments: &RecognitionArguments,
) -> Outcome<Vec<Trial>> {
    let mut all = Vec::new();
    for (index, object) in shown.objects.iter().enumerate() {
        if arguments
            .only
            .as_ref()
            .is_some_and(|only| !object.model.name.contains(only))
        {
            continue;
        }
        let mut random = ChaCha8Rng::seed_from_u64(arguments.seed);
        random.set_stream(index as u64);
        for (pose, template) in object.poses.iter().enumerate() {
            if template.probability < LEAST_PROBABILITY && pose > 0 {
                continue;
            }
            for _ in 0..arguments.views {
                let rotation = draw(object, pose, shown, &mut random);
                let shot = shoot(&object.model, &rotation, &mut random)?;
                let start = Instant::now();
                let recognition = shot
                    .cluster
                    .as_ref()
                    .map(|cluster| recogniser.recognise(cluster));
                let recognise_ms = start.elapsed().as_secs_f64() * 1e3;
                let mut trial = Trial {
                    name: object.model.name.clone(),
                    pose,
                    points: shot
                        .cluster
                        .as_ref()
                        .map_or(0, |cluster| cluster.points_m.len()),
                    recognition,
                    is_right: false,
                    error: None,
                    looks_same: false,
                    segment_ms: shot.segment_ms,
                    recognise_ms,
                };
                if let (Some(known), Some(best)) = (known_as(index), trial.best().cloned()) {
                    let library = recogniser.library();
                    let (truth, estimate) = (&shot.world_from_item, &best.world_from_item);
                    trial.error = library.pose_error(known, truth, best.object, estimate);
                    trial.is_right = trial.error.is_some();
                    trial.looks_same =
                        library.looks_same_from_above(known, truth, best.object, estimate);
                }
                all.push(trial);
            }
        }
    }
    Ok(all)
}

fn percent(part: usize, whole: usize) -> String {
    format!(
        "{:.1} % ({part} of {whole})",
        100.0 * part as f64 / whole.max(1) as f64
    )
}

/// The same shares with every object counted once, however many poses it has: round ones have many.
fn report_by_object(right: &[&Trial]) {
    let mut objects: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for trial in right {
        let entry = objects.entry(&trial.name).or_default();
        entry.0 += 1.0;
        entry.1 += f64::from(u8::from(trial.is_placed()));
    }
    let shares: Vec<f64> = objects
        .values()
        .map(|(views, placed)| placed / views)
        .collect();
    println!(
        "mean over objects of the share within 3 mm and 3 degrees {:.1} %; all views of {} of {} objects",
        100.0 * shares.iter().sum::<f64>() / shares.len() as f64,
        shares.iter().filter(|share| **share == 1.0).count(),
        shares.len()
    );
}

fn report_known(trials: &[Trial]) {
    let count = trials.len();
    let right: Vec<&Trial> = trials
        .iter()
        .filter(|trial| trial.is_right && trial.is_known())
        .collect();
    let placed = right.iter().filter(|trial| trial.is_placed()).count();
    let hidden = right
        .iter()
        .filter(|trial| !trial.is_placed() && trial.is_hidden_difference())
        .count();
    let unknown = trials.iter().filter(|trial| !trial.is_known()).count();
    let best_right = trials.iter().filter(|trial| trial.is_right).count();
    println!(
        "right {}; called unknown {}; best candidate right {}",
        percent(right.len(), count),
        percent(unknown, count),
        percent(best_right, count)
    );
    println!(
        "of those right: within 3 mm and 3 degrees {}",
        percent(placed, right.len())
    );
    println!(
        "of those right: within, or another pose that looks the same from above {}",
        percent(placed + hidden, right.len())
    );
    let alike = right
        .iter()
        .filter(|trial| trial.is_placed() || trial.looks_same)
        .count();
    println!(
        "of those right: within, or what is seen lies within 1 mm (root mean square) of where it is {}",
        percent(alike, right.len())
    );
    report_by_object(&right);
    let within = |limit: (f64, f64)| {
        right
            .iter()
            .filter(|trial| {
                trial
                    .error
                    .unwrap()
                    .is_within(limit.0, limit.1.to_radians())
            })
            .count()
    };
    for limit in [(0.003, 180.0), (1.0, 3.0), (0.005, 5.0), (0.005, 10.0)] {
        println!(
            "  within {} mm and {} degrees: {}",
            limit.0 * 1e3,
            limit.1,
            percent(within(limit), right.len())
        );
    }
    let mut wrong: BTreeMap<(String, String), usize> = BTreeMap::new();
    for trial in trials
        .iter()
        .filter(|trial| !trial.is_right || !trial.is_known())
    {
        let taken = if trial.is_known() {
            trial.best().unwrap().name.clone()
        } else {
            format!(
                "unknown (best {})",
                trial.best().map_or("none", |best| &best.name)
            )
        };
        *wrong.entry((trial.name.clone(), taken)).or_default() += 1;
    }
    let mut wrong: Vec<_> = wrong.into_iter().collect();
    wrong.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    for ((name, taken), count) in wrong.iter().take(40) {
        println!("  {count} x {name} taken for {taken}");
    }
    let mut misplaced: BTreeMap<(&str, usize), Vec<String>> = BTreeMap::new();
    for trial in &right {
        let error = trial.error.unwrap();
        if !trial.is_placed() {
            misplaced
                .entry((&trial.name, trial.pose))
                .or_default()
                .push(format!(
                    "{:.1} mm {:.1} deg{}",
                    error.position_m * 1e3,
                    error.angle_rad.to_degrees(),
                    if trial.is_hidden_difference() {
                        " (looks the same)"
                    } else {
                        ""
                    }
                ));
        }
    }
    println!("misplaced:");
    for ((name, pose), errors) in &misplaced {
        println!("  {name} pose {pose}: {}", errors.join(", "));
    }
}

fn report_strangers(trials: &[Trial]) {
    let unknown = trials.iter().filter(|trial| !trial.is_known()).count();
    println!("called unknown: views {}", percent(unknown, trials.len()));
    let mut objects: BTreeMap<&str, (usize, usize, BTreeMap<&str, usize>)> = BTreeMap::new();
    for trial in trials {
        let entry = objects.entry(&trial.name).or_default();
        entry.0 += 1;
        if trial.is_known() {
            entry.1 += 1;
            *entry.2.entry(&trial.best().unwrap().name).or_default() += 1;
        }
    }
    let mostly = objects
        .values()
        .filter(|(views, mistaken, _)| 2 * mistaken < *views)
        .count();
    println!(
        "objects called unknown in most views: {}",
        percent(mostly, objects.len())
    );
    for (name, (views, mistaken, taken)) in
        objects.iter().filter(|(_, (_, mistaken, _))| *mistaken > 0)
    {
        println!("  {name}: {mistaken} of {views} views taken for {taken:?}");
    }
}

fn report_times(trials: &[Trial]) {
    for (what, times) in [
        (
            "segmentation",
            trials
                .iter()
                .map(|trial| trial.segment_ms)
                .collect::<Vec<_>>(),
        ),
        (
            "recognition",
            trials.iter().map(|trial| trial.recognise_ms).collect(),
        ),
    ] {
        println!(
            "{what}: median {:.1} ms, 95th percentile {:.1} ms, greatest {:.1} ms",
            quantile(times.clone(), 0.5),
            quantile(times.clone(), 0.95),
            quantile(times, 1.0)
        );
    }
}

fn write_csv(path: &Path, trials: &[Trial]) -> Outcome {
    let mut text = String::from(
        "name,pose,points,known,right,best,fitness,unexplained,contradicted,residual_m,margin,position_mm,angle_deg,segment_ms,recognise_ms\n",
    );
    for trial in trials {
        text.push_str(&trial.csv());
        text.push('\n');
    }
    Ok(write_whole(path, text.as_bytes())?)
}

pub(crate) fn run(arguments: &RecognitionArguments) -> Outcome {
    let known = folder(&arguments.known)?;
    let start = Instant::now();
    let library = Arc::new(library(&known)?);
    let templates: usize = library
        .objects
        .iter()
        .map(|object| object.poses.len())
        .sum();
    println!(
        "{} objects, {templates} resting poses, prepared in {:.2} s",
        known.len(),
        start.elapsed().as_secs_f64()
    );
    let name = |index: &usize| library.objects[*index].model.name.as_str();
    for group in library.twin_groups() {
        println!(
            "twins: {}",
            group.iter().map(name).collect::<Vec<_>>().join(", ")
        );
    }
    let recogniser = Recogniser::new(library.clone(), RecognitionSettings::default());
    let strangers = match &arguments.strangers {
        Some(strangers) => Some(folder(strangers)?),
        None if arguments.builtin => Some(models(&ppnpack_household::builtin())?),
        None => None,
    };
    let is_known = strangers.is_none() && !arguments.left_out;
    let all = if let Some(strangers) = strangers {
        let shown = self::library(&strangers)?;
        trials(&shown, &recogniser, |_| None, arguments)?
    } else if arguments.left_out {
        left_out(&library, arguments)?
    } else {
        describe(&library, arguments);
        trials(&library, &recogniser, Some, arguments)?
    };
    if is_known {
        report_known(&all);
    } else {
        report_strangers(&all);
    }
    report_times(&all);
    match &arguments.csv {
        Some(path) => write_csv(path, &all),
        None => Ok(()),
    }
}

/// Each object as a stranger, to a library without it and its twins.
fn left_out(library: &Library, arguments: &RecognitionArguments) -> Outcome<Vec<Trial>> {
    let mut all = Vec::new();
    for index in 0..library.objects.len() {
        let mut rest = library.clone();
        rest.objects = (0..library.objects.len())
            .filter(|other| !library.are_alike(index, *other))
            .map(|other| library.objects[other].clone())
            .collect();
        for object in &mut rest.objects {
            object.twins.clear();
        }
        let shown = Library {
            objects: vec![library.objects[index].clone()],
            settings: library.settings,
        };
        let recogniser = Recogniser::new(Arc::new(rest), RecognitionSettings::default());
        all.extend(trials(&shown, &recogniser, |_| None, arguments)?);
    }
    Ok(all)
}

/// The symmetries of the objects that are asked for.
fn describe(library: &Library, arguments: &RecognitionArguments) {
    let Some(only) = &arguments.only else {
        return;
    };
    for object in &library.objects {
        let name = &object.model.name;
        if name.contains(only) {
            println!("{name} {:?} {}", object.symmetry, object.poses.len());
        }
    }
}
