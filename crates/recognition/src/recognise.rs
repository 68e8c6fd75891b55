//! A cluster to an object and its pose.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use ppnpack_numbers::{SettingError, require};
use serde::{Deserialize, Serialize};

use crate::align::{AlignSettings, Hold, align};
use crate::coarse::{Cut, Hypothesis, hypotheses};
use crate::expected::{Agreement, Observation, Sketch, expected_loss};
use crate::library::{Library, LibraryObject};
use crate::outline::UpperSurface;
use crate::polish::Polish;
use crate::rest::laid_at_rest;
use crate::segmentation::Cluster;
use crate::spacing::spacing_m;

/// How clusters are recognised.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RecognitionSettings {
    /// Clusters of fewer points are not looked at.
    pub least_points: usize,
    /// How many objects in resting poses go on from the comparison of outlines.
    pub templates: usize,
    /// How many poses go on from the comparison of heights.
    pub hypotheses: usize,
    /// How many poses go on from the quick alignment.
    pub finalists: usize,
    /// The standard deviation of the sensor's noise, in metres: what a good fit is expected to be off by.
    pub sensor_deviation_m: f64,
    /// Below this fitness, an item is unknown; as a sensor without noise would give it.
    pub least_fitness: f64,
    /// Where more than this share of an item's points is not explained, it is unknown.
    pub most_unexplained: f64,
    /// Where the camera looks through more than this share of what should be seen, an item is unknown.
    pub most_contradicted: f64,
}

impl Default for RecognitionSettings {
    fn default() -> Self {
        Self {
            least_points: 30,
            templates: 90,
            hypotheses: 24,
            finalists: 4,
            sensor_deviation_m: 0.001,
            least_fitness: 0.9725,
            most_unexplained: 0.03,
            most_contradicted: 0.02,
        }
    }
}

impl RecognitionSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`SettingError`] names the first that is not possible.
    pub fn validate(&self) -> Result<(), SettingError> {
        let counts = [
            ("templates", self.templates),
            ("hypotheses", self.hypotheses),
            ("finalists", self.finalists),
        ];
        for (name, count) in counts {
            require(name, count as f64, "1 to 10,000", |count| {
                (1.0..=1e4).contains(&count)
            })?;
        }
        let shares = [
            ("least_fitness", self.least_fitness),
            ("most_unexplained", self.most_unexplained),
            ("most_contradicted", self.most_contradicted),
        ];
        for (name, share) in shares {
            require(name, share, "0 to 1", |share| (0.0..=1.0).contains(&share))?;
        }
        let deviation_m = self.sensor_deviation_m;
        require("sensor_deviation_m", deviation_m, "0 to 0.1 m", |value| {
            (0.0..=0.1).contains(&value)
        })
    }
}

/// An object in a pose that agrees more or less with a cluster.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The object's index in the library.
    pub object: usize,
    /// Its name.
    pub name: String,
    /// Its item frame in the world.
    pub world_from_item: Isometry3<f64>,
    /// How well it agrees.
    pub agreement: Agreement,
}

/// A recognised item.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// What it is and how it lies.
    pub best: Candidate,
    /// The best other object, twins aside; `None` where no other was worth a closer look.
    pub runner_up: Option<Candidate>,
    /// By how much the fitness is above the runner-up's; the whole fitness without one.
    pub margin: f64,
}

/// Why an item is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnknownReason {
    /// It has too few points to tell.
    FewPoints,
    /// No object has about its size.
    NoCandidate,
    /// Its best candidate does not agree well enough. Items that touch end here, too.
    PoorFit,
}

/// An item that is not in the library, or not seen well enough.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// Why.
    pub reason: UnknownReason,
    /// The best candidates, best first.
    pub candidates: Vec<Candidate>,
}

/// What a cluster shows.
#[derive(Debug, Clone, PartialEq)]
pub enum Recognition {
    /// An object of the library.
    Known(Box<Known>),
    /// None of them.
    Unknown(Unknown),
}

/// Recognises clusters as objects of a library.
#[derive(Debug, Clone)]
pub struct Recogniser {
    library: Arc<Library>,
    settings: RecognitionSettings,
}

/// Points that quick and thorough alignments take.
const QUICK_POINTS: usize = 120;
const THOROUGH_POINTS: usize = 400;

/// The square root of the area that the smallest item covers, in metres.
const LEAST_WIDTH_M: f64 = 0.008;

/// The most points of a cluster that are looked at.
const MAX_POINTS: usize = 40_000;

/// Points that quick and thorough comparisons take.
const QUICK_COMPARED: usize = 250;
const THOROUGH_COMPARED: usize = 2500;

/// How an item may lie other than at rest: meshes and supports are not perfect.
const HOLD: Hold = Hold {
    tilt_rad: 0.05,
    height_m: 0.0015,
};

const QUICK: AlignSettings = AlignSettings {
    rounds: 8,
    scale_m: (0.012, 0.003),
    hold: Some(HOLD),
};

const THOROUGH: AlignSettings = AlignSettings {
    rounds: 10,
    scale_m: (0.004, 0.0015),
    hold: Some(HOLD),
};

const AT_REST: AlignSettings = AlignSettings {
    rounds: 8,
    scale_m: (0.003, 0.0015),
    hold: Some(Hold {
        tilt_rad: 0.0005,
        height_m: 0.0001,
    }),
};

/// How many of the best fits are laid at rest.
const RESTING_FITS: usize = 2;

/// A pose exactly at rest is preferred where its fitness is at most this much lower.
const AS_GOOD: f64 = 0.001;

impl Recogniser {
    /// A recogniser of the objects of a library.
    pub fn new(library: Arc<Library>, settings: RecognitionSettings) -> Self {
        Self { library, settings }
    }

    /// The objects that it knows.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// What a cluster shows. Points that are not finite are left out.
    ///
    /// The first cut compares outlines and heights over the support; iterative closest points refine what is left; and
    /// the views that the camera should have of the refined poses are compared with what it sees.
    pub fn recognise(&self, cluster: &Cluster) -> Recognition {
        let cluster = &thinned(cluster);
        if cluster.points_m.len() < self.settings.least_points {
            return unknown(UnknownReason::FewPoints, Vec::new());
        }
        let ranked = self.ranked(cluster);
        let candidates = ranked
            .into_iter()
            .filter_map(|fit| self.candidate(cluster, &fit));
        self.decided(candidates.collect())
    }

    /// Poses with their agreement, best first.
    fn ranked(&self, cluster: &Cluster) -> Vec<Fit> {
        let least_height_m = self.library.settings.least_height_m;
        let surface = UpperSurface::of_points(&cluster.points_m, least_height_m);
        let outline = surface.as_ref().and_then(UpperSurface::outline);
        let (Some(surface), Some(outline)) = (surface, outline) else {
            return Vec::new();
        };
        // However many points: what covers less is no item.
        if outline.width_m < LEAST_WIDTH_M {
            return Vec::new();
        }
        let cut = Cut {
            templates: self.settings.templates,
            hypotheses: self.settings.hypotheses,
        };
        let pixel_m = spacing_m(cluster);
        let quick = Pass::new(cluster, 2.0 * pixel_m, QUICK_COMPARED, QUICK_POINTS, QUICK);
        let thorough = Pass::new(
            cluster,
            pixel_m,
            THOROUGH_COMPARED,
            THOROUGH_POINTS,
            THOROUGH,
        );
        let (Some(mut quick), Some(mut thorough)) = (quick, thorough) else {
            return Vec::new();
        };
        let first = hypotheses(&self.library, &surface, &outline, cut);
        let refined = self.refined(first.iter().map(Fit::of), &mut quick);
        let finalists = distinct(refined, self.settings.finalists);
        let mut ranked = self.refined(finalists.into_iter(), &mut thorough);
        for fit in ranked.iter_mut().take(RESTING_FITS) {
            if let Some(object) = self.library.objects.get(fit.object) {
                *fit = thorough.at_rest(object, fit);
            }
        }
        sort(&mut ranked);
        if let Some(best) = ranked.first_mut()
            && let Some(object) = self.library.objects.get(best.object)
            && let Some(mut polish) = Polish::new(cluster, pixel_m)
        {
            let polished = polish.polished(object, &best.support_from_item);
            *best = thorough.compared(object, best.object, &polished);
        }
        ranked
    }

    /// Fits after a pass, best first.
    fn refined(&self, fits: impl Iterator<Item = Fit>, pass: &mut Pass) -> Vec<Fit> {
        let mut refined: Vec<Fit> = fits
            .filter_map(|fit| Some(pass.refined(self.library.objects.get(fit.object)?, &fit)))
            .collect();
        sort(&mut refined);
        refined
    }

    fn candidate(&self, cluster: &Cluster, fit: &Fit) -> Option<Candidate> {
        let object = self.library.objects.get(fit.object)?;
        Some(Candidate {
            object: fit.object,
            name: object.model.name.clone(),
            world_from_item: cluster.world_from_support * fit.support_from_item,
            agreement: fit.agreement,
        })
    }

    /// Known or unknown, of candidates from the best down.
    fn decided(&self, mut candidates: Vec<Candidate>) -> Recognition {
        let Some(best) = candidates.first() else {
            return unknown(UnknownReason::NoCandidate, candidates);
        };
        let agreement = best.agreement;
        let settings = &self.settings;
        let least_fitness = settings.least_fitness - expected_loss(settings.sensor_deviation_m);
        if agreement.fitness < least_fitness
            || agreement.unexplained > settings.most_unexplained
            || agreement.contradicted > settings.most_contradicted
        {
            return unknown(UnknownReason::PoorFit, candidates);
        }
        let best = candidates.remove(0);
        let is_other =
            |candidate: &Candidate| !self.library.are_alike(best.object, candidate.object);
        let runner_up = candidates.into_iter().find(is_other);
        let below = runner_up
            .as_ref()
            .map_or(0.0, |other| other.agreement.fitness);
        Recognition::Known(Box::new(Known {
            margin: best.agreement.fitness - below,
            best,
            runner_up,
        }))
    }
}

fn unknown(reason: UnknownReason, candidates: Vec<Candidate>) -> Recognition {
    Recognition::Unknown(Unknown { reason, candidates })
}

/// A pose under refinement.
#[derive(Debug, Clone, Copy)]
struct Fit {
    object: usize,
    support_from_item: Isometry3<f64>,
    agreement: Agreement,
}

impl Fit {
    fn of(hypothesis: &Hypothesis) -> Self {
        Self {
            object: hypothesis.object,
            support_from_item: hypothesis.support_from_item,
            agreement: Agreement::default(),
        }
    }
}

/// One round of alignment and comparison over all that is left.
struct Pass {
    observation: Observation,
    points: Vec<Point3<f64>>,
    settings: AlignSettings,
    sketch: Sketch,
}

impl Pass {
    fn new(
        cluster: &Cluster,
        pixel_m: f64,
        compared: usize,
        aligned: usize,
        settings: AlignSettings,
    ) -> Option<Self> {
        Some(Self {
            observation: Observation::new(cluster, pixel_m, compared)?,
            points: spread(&cluster.points_m, aligned),
            settings,
            sketch: Sketch::default(),
        })
    }

    fn refined(&mut self, object: &LibraryObject, fit: &Fit) -> Fit {
        let pose = align(
            &object.nearest,
            &self.points,
            &fit.support_from_item,
            &self.settings,
        );
        self.compared(object, fit.object, &pose)
    }

    fn compared(&mut self, object: &LibraryObject, index: usize, pose: &Isometry3<f64>) -> Fit {
        Fit {
            object: index,
            support_from_item: *pose,
            agreement: self.observation.compare(object, pose, &mut self.sketch),
        }
    }

    /// The fit laid exactly at rest, where a resting pose is near and agrees about as well.
    fn at_rest(&mut self, object: &LibraryObject, fit: &Fit) -> Fit {
        let Some(resting) = laid_at_rest(object, &fit.support_from_item) else {
            return *fit;
        };
        let pose = align(&object.nearest, &self.points, &resting, &AT_REST);
        let rested = self.compared(object, fit.object, &pose);
        if rested.agreement.fitness + AS_GOOD >= fit.agreement.fitness {
            rested
        } else {
            *fit
        }
    }
}

fn sort(fits: &mut [Fit]) {
    fits.sort_by(|a, b| b.agreement.fitness.total_cmp(&a.agreement.fitness));
}

/// Some of the points, evenly spaced in their order.
pub(crate) fn spread(points: &[Point3<f64>], count: usize) -> Vec<Point3<f64>> {
    if points.len() <= count {
        return points.to_vec();
    }
    let step = points.len() as f64 / count as f64;
    (0..count)
        .filter_map(|number| points.get((number as f64 * step) as usize).copied())
        .collect()
}

/// The best fits; of those that say the same, the best.
fn distinct(fits: Vec<Fit>, count: usize) -> Vec<Fit> {
    let mut chosen: Vec<Fit> = Vec::with_capacity(count);
    for fit in fits {
        let is_same = |other: &Fit| {
            let apart = other.support_from_item.inverse() * fit.support_from_item;
            other.object == fit.object
                && apart.rotation.angle() < 0.05
                && apart.translation.vector.norm() < 0.004
        };
        if chosen.len() >= count {
            break;
        }
        if !chosen.iter().any(is_same) {
            chosen.push(fit);
        }
    }
    chosen
}

/// The cluster with its finite points only, and of very many evenly spaced ones.
fn thinned(cluster: &Cluster) -> Cluster {
    let some = |points: &[Point3<f64>]| {
        let sound = |point: &Point3<f64>| point.iter().all(|value| value.abs() < 1e3);
        let points: Vec<Point3<f64>> = points
            .iter()
            .filter(|point| sound(point))
            .copied()
            .collect();
        spread(&points, MAX_POINTS)
    };
    Cluster {
        points_m: some(&cluster.points_m),
        surroundings_m: some(&cluster.surroundings_m),
        ..cluster.clone()
    }
}
