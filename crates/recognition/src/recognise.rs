//! A cluster to an object and its pose.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use ppnpack_numbers::{settings, within};

use crate::align::{AlignSettings, Hold};
use crate::coarse::hypotheses;
use crate::expected::{Agreement, expected_loss};
use crate::library::Library;
use crate::outline::UpperSurface;
use crate::pattern::{Move, Pattern};
use crate::refinement::{
    Fit, Pass, PassSettings, PolishSettings, Refinement, RefinementSettings, SamePose, sort,
};
use crate::rest::laid_at_rest;
use crate::samples::spread;
use crate::segmentation::Cluster;

settings! {
    /// Settings of the recognition of clusters.
    #[derive(Copy)]
    pub struct RecognitionSettings with validate {
        /// Minimum number of points of clusters that are looked at.
        pub least_points: usize = 30,
        /// Number of objects in resting poses that go on from the comparison of outlines.
        pub templates: usize = 90 => within("1 to 10,000", 1.0..=1e4),
        /// Number of poses that go on from the comparison of heights.
        pub hypotheses: usize = 24 => within("1 to 10,000", 1.0..=1e4),
        /// Number of poses that go on from the quick alignment.
        pub finalists: usize = 4 => within("1 to 10,000", 1.0..=1e4),
        /// The standard deviation of the sensor's noise, in metres: what a good fit is expected to
        /// be off by.
        pub sensor_deviation_m: f64 = 0.001 => within("0 to 0.1 m", 0.0..=0.1),
        /// Minimum fitness of a known item, as a sensor without noise would give it.
        pub least_fitness: f64 = 0.9725 => within("0 to 1", 0.0..=1.0),
        /// Maximum share of a known item's points that is not explained.
        pub most_unexplained: f64 = 0.03 => within("0 to 1", 0.0..=1.0),
        /// Maximum share of what should be seen of a known item that the camera looks through.
        pub most_contradicted: f64 = 0.02 => within("0 to 1", 0.0..=1.0),
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
    /// Its agreement with what is seen.
    pub agreement: Agreement,
}

/// A recognised item.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// The object and its pose.
    pub best: Candidate,
    /// The best other object, twins aside; `None` where no other was worth a closer look.
    pub runner_up: Option<Candidate>,
    /// Excess of the fitness over the runner-up's; the whole fitness without one.
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

/// The result of recognising a cluster.
#[derive(Debug, Clone, PartialEq)]
pub enum Recognition {
    /// An object of the library.
    Known(Box<Known>),
    /// None of them.
    Unknown(Unknown),
}

/// Square root of the area that the smallest item covers, in metres.
const LEAST_WIDTH_M: f64 = 0.008;

/// Maximum number of points of a cluster that are looked at.
const MAX_POINTS: usize = 40_000;

/// Deviations of an item from rest: meshes and supports are not perfect.
const NEARLY_AT_REST: Hold = Hold {
    tilt_rad: 0.05,
    height_m: 0.0015,
};

/// Settings by which hypotheses are refined. Clusters of many points are of large items, whose
/// poses alignment alone finds.
const REFINEMENT: RefinementSettings = RefinementSettings {
    quick: PassSettings {
        pixel_spacings: 2.0,
        compared: 250,
        aligned: 120,
        align: AlignSettings::new(8, (0.012, 0.003), Some(NEARLY_AT_REST)),
    },
    thorough: PassSettings {
        pixel_spacings: 1.0,
        compared: 2500,
        aligned: 400,
        align: AlignSettings::new(10, (0.004, 0.0015), Some(NEARLY_AT_REST)),
    },
    same: SamePose {
        angle_rad: 0.05,
        distance_m: 0.004,
    },
    polish: PolishSettings {
        pixel_spacings: 0.5,
        compared: 1500,
        most_points: 4000,
        pattern: Pattern {
            first_step_m: 0.0012,
            moves: [Move::Turn, Move::X, Move::Y],
            sweeps: 1,
        },
    },
};

/// Number of the best fits that are laid exactly at rest.
const LAID_AT_REST: usize = 2;
/// Maximum lean from a resting pose of a fit that is laid at rest, in radians.
const MOST_LEAN_RAD: f64 = 0.2;
/// Maximum loss of fitness for which the pose at rest is preferred.
const MOST_LOST: f64 = 0.001;
/// Settings by which the pose at rest is aligned.
const EXACTLY_AT_REST: Hold = Hold {
    tilt_rad: 0.0005,
    height_m: 0.0001,
};
const AT_REST: AlignSettings = AlignSettings::new(8, (0.003, 0.0015), Some(EXACTLY_AT_REST));

/// Recognises clusters as objects of a library.
#[derive(Debug, Clone)]
pub struct Recogniser {
    library: Arc<Library>,
    settings: RecognitionSettings,
}

impl Recogniser {
    /// Makes a recogniser of the objects of a library.
    pub fn new(library: Arc<Library>, settings: RecognitionSettings) -> Self {
        Self { library, settings }
    }

    /// Gives the objects that it knows.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// Recognises a cluster. Points that are not finite are left out.
    ///
    /// The first cut compares outlines and heights over the support; iterative closest points
    /// refine what is left; and the views that the camera should have of the refined poses are
    /// compared with what it sees.
    pub fn recognise(&self, cluster: &Cluster) -> Recognition {
        let cluster = &thinned(cluster);
        if cluster.points_m.len() < self.settings.least_points {
            return unknown(UnknownReason::FewPoints, Vec::new());
        }
        let ranked = self.ranked(cluster).unwrap_or_default();
        let candidates = ranked.iter().filter_map(|fit| self.candidate(cluster, fit));
        self.decided(candidates.collect())
    }

    /// Gives poses with their agreement, best first; `None` where the cluster cannot be compared
    /// with any.
    fn ranked(&self, cluster: &Cluster) -> Option<Vec<Fit<'_>>> {
        let least_height_m = self.library.settings.least_height_m;
        let surface = UpperSurface::of_points(&cluster.points_m, least_height_m)?;
        let outline = surface.outline()?;
        // However many points: what covers less is no item.
        if outline.width_m < LEAST_WIDTH_M {
            return None;
        }
        let mut refinement = Refinement::new(cluster, &REFINEMENT)?;
        let objects = &self.library.objects;
        let mut starts = hypotheses(objects, &surface, &outline, self.settings.templates);
        starts.truncate(self.settings.hypotheses);
        let mut ranked = refinement.refined(starts, self.settings.finalists);
        for fit in ranked.iter_mut().take(LAID_AT_REST) {
            *fit = at_rest(&mut refinement.thorough, fit);
        }
        sort(&mut ranked);
        if let Some(best) = ranked.first_mut()
            && let Some(pose) = refinement.polished(best.object, &best.pose)
        {
            *best = refinement.thorough.compared(best.object, &pose);
        }
        Some(ranked)
    }

    fn candidate(&self, cluster: &Cluster, fit: &Fit<'_>) -> Option<Candidate> {
        Some(Candidate {
            object: self.library.index_of(fit.object)?,
            name: fit.object.model.name.clone(),
            world_from_item: cluster.world_from_support * fit.pose,
            agreement: fit.agreement,
        })
    }

    /// Decides whether the cluster is known, by candidates from the best down.
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
        let is_other = |other: &Candidate| !self.library.are_alike(best.object, other.object);
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

/// Lays a fit exactly at rest, where a resting pose is near and agrees about as well.
fn at_rest<'library>(pass: &mut Pass, fit: &Fit<'library>) -> Fit<'library> {
    let Some(resting) = laid_at_rest(fit.object, &fit.pose, MOST_LEAN_RAD) else {
        return *fit;
    };
    let rested = pass.aligned(fit.object, &resting, &AT_REST);
    let is_as_good = rested.agreement.fitness + MOST_LOST >= fit.agreement.fitness;
    if is_as_good { rested } else { *fit }
}

fn unknown(reason: UnknownReason, candidates: Vec<Candidate>) -> Recognition {
    Recognition::Unknown(Unknown { reason, candidates })
}

/// Gives the cluster with its finite points only, and of very many evenly spaced ones.
fn thinned(cluster: &Cluster) -> Cluster {
    let some = |points: &[Point3<f64>]| {
        let is_sound = |point: &&Point3<f64>| point.iter().all(|value| value.abs() < 1e3);
        let sound: Vec<Point3<f64>> = points.iter().filter(is_sound).copied().collect();
        spread(&sound, MAX_POINTS)
    };
    Cluster {
        points_m: some(&cluster.points_m),
        surroundings_m: some(&cluster.surroundings_m),
        ..cluster.clone()
    }
}
