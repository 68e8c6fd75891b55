//! `ppnpack experiment recognition`: how well objects of a folder are recognised in simulated views, and how many of
//! others are called unknown.
//!
//! Each object stands in each of its resting poses (of at least 2 %) at a random yaw and place, and a depth camera some
//! 0.9 m above takes one noisy view.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use ppnpack_camera::{Body, DepthCamera, Intrinsics, NoiseModel};
use ppnpack_catalogue::catalogue::Source;
use ppnpack_catalogue::object::Model;
use ppnpack_cli::failure::{OrInput, OrRun, Outcome};
use ppnpack_recognition::evaluation::PoseError;
use ppnpack_recognition::library::{Library, LibraryObject, LibrarySettings};
use ppnpack_recognition::recognise::{Candidate, Recogniser, Recognition, RecognitionSettings};
use ppnpack_recognition::segmentation::{Cluster, Region, SegmentationSettings, segment};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{columns_of, timed, write_csv};
use crate::scene::{any_turn, between, body, models, seen};
use crate::statistics::{percentage, quantiles};

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
    /// The error of the best candidate, where it is the right object.
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

    fn is_right(&self) -> bool {
        self.error.is_some()
    }

    fn is_within(&self, position_m: f64, angle_deg: f64) -> bool {
        self.error
            .is_some_and(|error| error.is_within(position_m, angle_deg.to_radians()))
    }

    fn is_placed(&self) -> bool {
        self.is_within(0.003, 3.0)
    }

    /// Whether the pose is quite another one that no camera above could tell from the true one.
    fn is_hidden_difference(&self) -> bool {
        self.looks_same && self.error.is_some_and(|error| error.angle_rad > 0.25)
    }

    fn csv(&self) -> String {
        let margin = match &self.recognition {
            Some(Recognition::Known(known)) => known.margin,
            _ => f64::NAN,
        };
        let best = match self.best() {
            Some(best) => {
                let it = &best.agreement;
                format!(
                    "{},{:.4},{:.4},{:.4},{:.5},{margin:.4}",
                    best.name, it.fitness, it.unexplained, it.contradicted, it.residual_m
                )
            }
            None => ",,,,,".to_owned(),
        };
        format!(
            "{},{},{},{},{},{best},{},{:.1},{:.1}",
            self.name,
            self.pose,
            self.points,
            u8::from(self.is_known()),
            u8::from(self.is_right()),
            columns_of(self.error),
            self.segment_ms,
            self.recognise_ms
        )
    }
}

/// One view of an object lying on a tray.
struct Shot {
    cluster: Option<Cluster>,
    world_from_item: Isometry3<f64>,
    segment_ms: f64,
}

fn shoot(model: &Model, rotation: &UnitQuaternion<f64>, random: &mut ChaCha8Rng) -> Outcome<Shot> {
    let turned = any_turn(random) * rotation;
    let heights_m = model.mesh.vertices.iter().map(|vertex| (turned * vertex).z);
    let lowest_m = heights_m.fold(f64::INFINITY, f64::min);
    let centre = turned * model.mass.centre_of_mass_m;
    let mut between = |low: f64, high: f64| between(random, low, high);
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
    let tray = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)];
    let bodies = [
        Body {
            vertices: &tray.map(|(x, y)| Point3::new(x, y, 0.0)),
            triangles: &[[0, 1, 2], [0, 2, 3]],
            world_from_body: Isometry3::identity(),
        },
        body(&model.mesh, world_from_item),
    ];
    let intrinsics = Intrinsics::centred(640, 480, 600.0).or_run()?;
    let camera = DepthCamera::looking_at(intrinsics, eye, &Point3::new(0.0, 0.02, 0.0));
    let image = seen(&camera, &bodies, &NoiseModel::default(), random.random())?;
    let settings = SegmentationSettings::of(Region {
        lowest_m: Point3::new(-0.4, -0.3, -0.05),
        highest_m: Point3::new(0.4, 0.3, 0.5),
    });
    let points_m = image.in_world_m(&camera.world_from_camera);
    let (found, segment_ms) = timed(|| segment(points_m, &eye, &settings));
    Ok(Shot {
        cluster: found.clusters.into_iter().next(),
        world_from_item,
        segment_ms,
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
    let symmetry = &object.symmetry;
    let mut same = object.model.resting_poses.clone();
    same.retain(|pose| symmetry.joins(&direction, &down(&pose.rotation), within));
    let total: f64 = same.iter().map(|pose| pose.probability).sum();
    let mut left = random.random::<f64>() * total;
    let drawn = same.iter().find(|pose| {
        left -= pose.probability;
        left <= 0.0
    });
    drawn.or(same.first()).unwrap().rotation
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
        let only = arguments.only.as_ref();
        if only.is_some_and(|only| !object.model.name.contains(only)) {
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
                let known = known_as(index);
                all.push(trial(recogniser, known, object, pose, &shot));
            }
        }
    }
    Ok(all)
}

/// What the recogniser says of a view of an object, which is its library's `known` if any.
fn trial(
    recogniser: &Recogniser,
    known: Option<usize>,
    object: &LibraryObject,
    pose: usize,
    shot: &Shot,
) -> Trial {
    let cluster = shot.cluster.as_ref();
    let (recognition, recognise_ms) =
        timed(|| cluster.map(|cluster| recogniser.recognise(cluster)));
    let mut trial = Trial {
        name: object.model.name.clone(),
        pose,
        points: cluster.map_or(0, |cluster| cluster.points_m.len()),
        recognition,
        error: None,
        looks_same: false,
        segment_ms: shot.segment_ms,
        recognise_ms,
    };
    if let (Some(known), Some(best)) = (known, trial.best().cloned()) {
        let library = recogniser.library();
        let (truth, estimate) = (&shot.world_from_item, &best.world_from_item);
        trial.error = library.pose_error(known, truth, best.object, estimate);
        trial.looks_same = library.looks_same_from_above(known, truth, best.object, estimate);
    }
    trial
}

/// For how many of all something holds.
fn share<T>(all: &[T], holds: impl Fn(&T) -> bool) -> String {
    let part = all.iter().filter(|one| holds(one)).count();
    let percent = percentage(part, all.len().max(1));
    format!("{percent:.1} % ({part} of {})", all.len())
}

/// The same shares with every object counted once, however many poses it has: round ones have many.
fn report_by_object(right: &[&Trial]) {
    let mut objects: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for trial in right {
        let (views, placed) = objects.entry(&trial.name).or_default();
        *views += 1.0;
        *placed += f64::from(u8::from(trial.is_placed()));
    }
    let shares = objects.values().map(|(views, placed)| placed / views);
    let shares: Vec<f64> = shares.collect();
    println!(
        "mean over objects of the share within 3 mm and 3 degrees {:.1} %; all views of {} of {} objects",
        100.0 * shares.iter().sum::<f64>() / shares.len() as f64,
        shares.iter().filter(|share| **share == 1.0).count(),
        shares.len()
    );
}

fn report_known(trials: &[Trial]) {
    let is_recognised = |trial: &Trial| trial.is_right() && trial.is_known();
    let right: Vec<&Trial> = trials.iter().filter(|it| is_recognised(it)).collect();
    println!(
        "right {}; called unknown {}; best candidate right {}",
        share(trials, is_recognised),
        share(trials, |trial| !trial.is_known()),
        share(trials, Trial::is_right)
    );
    let report = |what: &str, holds: &dyn Fn(&&Trial) -> bool| {
        println!("of those right: {what} {}", share(&right, holds));
    };
    report("within 3 mm and 3 degrees", &|trial| trial.is_placed());
    report(
        "within, or another pose that looks the same from above",
        &|trial| trial.is_placed() || trial.is_hidden_difference(),
    );
    report(
        "within, or what is seen lies within 1 mm (root mean square) of where it is",
        &|trial| trial.is_placed() || trial.looks_same,
    );
    report_by_object(&right);
    for (position_m, angle_deg) in [(0.003, 180.0), (1.0, 3.0), (0.005, 5.0), (0.005, 10.0)] {
        println!(
            "  within {} mm and {angle_deg} degrees: {}",
            position_m * 1e3,
            share(&right, |trial| trial.is_within(position_m, angle_deg))
        );
    }
    report_wrong(trials);
    report_misplaced(&right);
}

/// What objects are taken for that are not recognised, the most frequent first.
fn report_wrong(trials: &[Trial]) {
    let mut wrong: BTreeMap<(&str, String), usize> = BTreeMap::new();
    for trial in trials.iter().filter(|it| !it.is_right() || !it.is_known()) {
        let best = trial.best().map_or("none", |best| &best.name);
        let taken = match trial.is_known() {
            true => best.to_owned(),
            false => format!("unknown (best {best})"),
        };
        *wrong.entry((&trial.name, taken)).or_default() += 1;
    }
    let mut wrong: Vec<_> = wrong.into_iter().collect();
    wrong.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    for ((name, taken), count) in wrong.iter().take(40) {
        println!("  {count} x {name} taken for {taken}");
    }
}

fn report_misplaced(right: &[&Trial]) {
    let mut misplaced: BTreeMap<(&str, usize), Vec<String>> = BTreeMap::new();
    for trial in right.iter().filter(|trial| !trial.is_placed()) {
        let error = trial.error.unwrap();
        let hidden = match trial.is_hidden_difference() {
            true => " (looks the same)",
            false => "",
        };
        let (mm, degrees) = (error.position_m * 1e3, error.angle_rad.to_degrees());
        let errors = misplaced.entry((&trial.name, trial.pose)).or_default();
        errors.push(format!("{mm:.1} mm {degrees:.1} deg{hidden}"));
    }
    println!("misplaced:");
    for ((name, pose), errors) in &misplaced {
        println!("  {name} pose {pose}: {}", errors.join(", "));
    }
}

fn report_strangers(trials: &[Trial]) {
    let unknown = share(trials, |trial| !trial.is_known());
    println!("called unknown: views {unknown}");
    // Views of each object, and how often it is taken for which.
    let mut objects: BTreeMap<&str, (usize, BTreeMap<&str, usize>)> = BTreeMap::new();
    for trial in trials {
        let (views, taken) = objects.entry(&trial.name).or_default();
        *views += 1;
        if let Some(Recognition::Known(known)) = &trial.recognition {
            *taken.entry(&known.best.name).or_default() += 1;
        }
    }
    let objects: Vec<_> = objects
        .iter()
        .map(|(name, (views, taken))| (name, *views, taken.values().sum::<usize>(), taken))
        .collect();
    println!(
        "objects called unknown in most views: {}",
        share(&objects, |(_, views, mistaken, _)| 2 * mistaken < *views)
    );
    for (name, views, mistaken, taken) in objects.iter().filter(|(_, _, mistaken, _)| *mistaken > 0)
    {
        println!("  {name}: {mistaken} of {views} views taken for {taken:?}");
    }
}

fn report_times(trials: &[Trial]) {
    let report = |what: &str, time_ms: fn(&Trial) -> f64| {
        let [median, most, greatest] = quantiles(trials.iter().map(time_ms), [0.5, 0.95, 1.0]);
        println!(
            "{what}: median {median:.1} ms, 95th percentile {most:.1} ms, greatest {greatest:.1} ms"
        );
    };
    report("segmentation", |trial| trial.segment_ms);
    report("recognition", |trial| trial.recognise_ms);
}

pub(crate) fn run(arguments: &RecognitionArguments) -> Outcome {
    let known = folder(&arguments.known)?;
    let start = Instant::now();
    let library = Arc::new(library(&known)?);
    let templates = library.objects.iter().map(|object| object.poses.len());
    println!(
        "{} objects, {} resting poses, prepared in {:.2} s",
        known.len(),
        templates.sum::<usize>(),
        start.elapsed().as_secs_f64()
    );
    let name = |index: &usize| library.objects[*index].model.name.as_str();
    for group in library.twin_groups() {
        let names: Vec<_> = group.iter().map(name).collect();
        println!("twins: {}", names.join(", "));
    }
    let recogniser = Recogniser::new(library.clone(), RecognitionSettings::default());
    let strangers = match &arguments.strangers {
        Some(strangers) => Some(folder(strangers)?),
        None if arguments.builtin => Some(models(&ppnpack_household::builtin())?),
        None => None,
    };
    let (all, report): (_, fn(&[Trial])) = if let Some(strangers) = strangers {
        let shown = self::library(&strangers)?;
        let all = trials(&shown, &recogniser, |_| None, arguments)?;
        (all, report_strangers)
    } else if arguments.left_out {
        (left_out(&library, arguments)?, report_strangers)
    } else {
        describe(&library, arguments);
        let all = trials(&library, &recogniser, Some, arguments)?;
        (all, report_known)
    };
    report(&all);
    report_times(&all);
    let head = "name,pose,points,known,right,best,fitness,unexplained,contradicted,residual_m,margin,position_mm,angle_deg,segment_ms,recognise_ms";
    write_csv(arguments.csv.as_ref(), head, all.iter().map(Trial::csv))
}

/// Each object as a stranger, to a library without it and its twins.
fn left_out(library: &Library, arguments: &RecognitionArguments) -> Outcome<Vec<Trial>> {
    let mut all = Vec::new();
    for (index, object) in library.objects.iter().enumerate() {
        let of = |objects| Library {
            objects,
            settings: library.settings,
        };
        let others = (0..).zip(&library.objects);
        let others = others.filter(|(other, _)| !library.are_alike(index, *other));
        let mut rest: Vec<LibraryObject> = others.map(|(_, other)| other.clone()).collect();
        rest.iter_mut().for_each(|other| other.twins.clear());
        let recogniser = Recogniser::new(Arc::new(of(rest)), RecognitionSettings::default());
        let shown = of(vec![object.clone()]);
        all.extend(trials(&shown, &recogniser, |_| None, arguments)?);
    }
    Ok(all)
}

/// The symmetries of the objects that are asked for.
fn describe(library: &Library, arguments: &RecognitionArguments) {
    let only = arguments.only.as_ref();
    for object in &library.objects {
        let name = &object.model.name;
        if only.is_some_and(|only| name.contains(only)) {
            println!("{name} {:?} {}", object.symmetry, object.poses.len());
        }
    }
}
