//! Poses of one object at new points.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::align::{AlignSettings, Hold, align, centroid};
use crate::expected::{Agreement, Observation, Sketch};
use crate::inspection::changes::Changes;
use crate::inspection::judge::Judge;
use crate::library::LibraryObject;
use crate::recognise::spread;
use crate::segmentation::Cluster;
use crate::spacing::spacing_m;
use crate::symmetry::Symmetry;

/// Directions of the sphere that are tried to be down, besides those in which the object rests.
const DIRECTIONS: usize = 32;

/// The most resting poses that are tried.
const MOST_POSES: usize = 24;

/// Yaws that each direction is tried at.
const YAWS: usize = 20;

/// Hypotheses that are shifted.
const SHIFTED: usize = 60;

/// Shifts, in metres, by which fits are laid where the outline fits too; the turns that go with them are as wide at the
/// object's border.
const OUTLINE_STEPS_M: [f64; 3] = [0.004, 0.002, 0.001];

/// How many of the best fits are laid so, and the points of the comparison.
const OUTLINED_FITS: usize = 2;
const OUTLINE_COMPARED: usize = 600;

/// Hypotheses that are aligned quickly, and thoroughly.
const QUICK_FITS: usize = 24;
const THOROUGH_FITS: usize = 5;

/// Hypotheses nearer to each other than this are one.
const SAME_RAD: f64 = 0.3;
const SAME_M: f64 = 0.01;

/// Points that alignments and comparisons take.
const QUICK_ALIGNED: usize = 100;
const QUICK_COMPARED: usize = 300;
const THOROUGH_ALIGNED: usize = 400;
const THOROUGH_COMPARED: usize = 2500;

const PLANNED: AlignSettings = AlignSettings {
    rounds: 16,
    scale_m: (0.012, 0.0015),
    hold: None,
};

const QUICK: AlignSettings = AlignSettings {
    rounds: 10,
    scale_m: (0.015, 0.004),
    hold: None,
};

const THOROUGH: AlignSettings = AlignSettings {
    rounds: 14,
    scale_m: (0.006, 0.0015),
    hold: None,
};

const UPRIGHT: AlignSettings = AlignSettings {
    rounds: 10,
    scale_m: (0.006, 0.0015),
    hold: Some(Hold {
        tilt_rad: 0.01,
        height_m: 0.1,
    }),
};

/// A fit that turned by more than this is compared with an upright one, in radians.
const UPRIGHT_RAD: f64 = 0.1;

/// Where the outline is off by more than this, as shares of points, it is fitted.
const OUTLINE_FROM: f64 = 0.008;

const LAST: AlignSettings = AlignSettings {
    rounds: 6,
    scale_m: (0.003, 0.0015),
    hold: None,
};

/// A pose and how well it agrees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fit {
    pub(crate) container_from_item: Isometry3<f64>,
    pub(crate) agreement: Agreement,
}

/// Looks for poses of an object that agree with new points.
pub(crate) struct Search<'object> {
    object: &'object LibraryObject,
    cluster: Cluster,
    pixel_m: f64,
    thorough: Observation,
    sketch: Sketch,
}

impl<'object> Search<'object> {
    /// `own_m` are new points, `others_m` all that is seen besides. `None` where nothing can be compared.
    pub(crate) fn new(
        object: &'object LibraryObject,
        own_m: &[Point3<f64>],
        others_m: &[Point3<f64>],
        eye_m: Point3<f64>,
        diameter_m: f64,
    ) -> Option<Self> {
        let centre = centroid(own_m)?;
        let (mut lowest, mut highest) = (centre, centre);
        for point in own_m {
            (lowest, highest) = (lowest.inf(point), highest.sup(point));
        }
        // Wherever the object has some of the new points, all of it is within its diameter of them.
        let is_near = |point: &&Point3<f64>| {
            point.x > lowest.x - diameter_m
                && point.x < highest.x + diameter_m
                && point.y > lowest.y - diameter_m
                && point.y < highest.y + diameter_m
        };
        let cluster = Cluster {
            points_m: own_m.to_vec(),
            surroundings_m: others_m.iter().filter(is_near).copied().collect(),
            eye_m,
            world_from_support: Isometry3::identity(),
        };
        let pixel_m = spacing_m(&cluster);
        Some(Self {
            object,
            thorough: Observation::new(&cluster, pixel_m, THOROUGH_COMPARED)?,
            cluster,
            pixel_m,
            sketch: Sketch::default(),
        })
    }

    /// The fit that alignment leads to from the planned pose; one that is as upright as planned where it agrees about as
    /// well, by `margin`. What is nearly round turns freely under alignment.
    pub(crate) fn near_planned(&mut self, planned: &Isometry3<f64>, margin: f64) -> Fit {
        let mut fit = self.aligned(planned, &PLANNED);
        let apart = fit.container_from_item.rotation.angle_to(&planned.rotation);
        if apart > UPRIGHT_RAD {
            let centre = fit.container_from_item * self.object.centre_m;
            let shift = centre - planned * self.object.centre_m;
            let upright = self.aligned(&(Translation3::from(shift) * planned), &UPRIGHT);
            if upright.agreement.fitness >= fit.agreement.fitness - margin {
                fit = upright;
            }
        }
        let agreement = fit.agreement;
        if agreement.unexplained + agreement.contradicted > OUTLINE_FROM {
            self.outline(std::slice::from_mut(&mut fit));
        }
        fit
    }

    fn aligned(&mut self, start: &Isometry3<f64>, settings: &AlignSettings) -> Fit {
        let points = spread(&self.cluster.points_m, THOROUGH_ALIGNED);
        let pose = align(&self.object.nearest, &points, start, settings);
        Fit {
            container_from_item: pose,
            agreement: self.thorough.compare(self.object, &pose, &mut self.sketch),
        }
    }

    /// The share of what should be seen of a pose that is seen, about.
    pub(crate) fn seen_share(&mut self, container_from_item: &Isometry3<f64>) -> f64 {
        let sight = self
            .thorough
            .sight(self.object, container_from_item, &mut self.sketch);
        let compared = self.thorough.points() as f64;
        let all = (self.cluster.points_m.len() + self.cluster.surroundings_m.len()) as f64;
        let free = sight.free as f64 * (all / compared.max(1.0)).max(1.0);
        (free / sight.pixels.max(1) as f64).min(1.0)
    }

    /// Fits from all orientations, best first.
    pub(crate) fn anywhere(
        &mut self,
        planned: &Isometry3<f64>,
        changes: &Changes<'_>,
        is_possible: impl Fn(&Isometry3<f64>) -> bool,
    ) -> Vec<Fit> {
        let Some(quick) = Observation::new(&self.cluster, 2.0 * self.pixel_m, QUICK_COMPARED)
        else {
            return Vec::new();
        };
        let points = spread(&self.cluster.points_m, QUICK_ALIGNED);
        let starts = self.hypotheses(planned, changes);
        let mut fits: Vec<Fit> = Vec::with_capacity(starts.len());
        for start in starts {
            let pose = align(&self.object.nearest, &points, &start, &QUICK);
            fits.push(Fit {
                container_from_item: pose,
                agreement: quick.compare(self.object, &pose, &mut self.sketch),
            });
        }
        sort(&mut fits);
        let finalists = distinct(fits, THOROUGH_FITS, |fit| fit.container_from_item);
        let mut fits: Vec<Fit> = finalists
            .iter()
            .map(|fit| self.aligned(&fit.container_from_item, &THOROUGH))
            .filter(|fit| is_possible(&fit.container_from_item))
            .collect();
        sort(&mut fits);
        self.outline(&mut fits);
        fits.retain(|fit| is_possible(&fit.container_from_item));
        sort(&mut fits);
        fits
    }

    /// Lays the best fits where the outline fits: alignment pulls a surface to points, but does not push it away from
    /// where there are none.
    fn outline(&mut self, fits: &mut [Fit]) {
        let Some(rough) = Observation::new(&self.cluster, self.pixel_m, OUTLINE_COMPARED) else {
            return;
        };
        for fit in fits.iter_mut().take(OUTLINED_FITS) {
            let pose = self.outlined(&rough, &fit.container_from_item);
            let outlined = self.aligned(&pose, &LAST);
            if outlined.agreement.fitness > fit.agreement.fitness {
                *fit = outlined;
            }
        }
    }

    /// A pose near another at which the expected view fits better, by pattern search over shifts and yaws.
    fn outlined(&mut self, rough: &Observation, pose: &Isometry3<f64>) -> Isometry3<f64> {
        let arm_m = self.object.points.iter().map(|point| {
            let arm = pose * point.point - pose * self.object.centre_m;
            arm.xy().norm()
        });
        let arm_m = arm_m.fold(0.003, f64::max);
        let mut best = *pose;
        let mut least = rough.strict_cost(self.object, &best, &mut self.sketch);
        for step_m in OUTLINE_STEPS_M {
            for (shift, yaw) in STEPS {
                let turn =
                    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw * step_m / arm_m);
                let about = Isometry3::rotation_wrt_point(turn, best * self.object.centre_m);
                let moved = Translation3::from(shift * step_m) * about * best;
                let cost = rough.strict_cost(self.object, &moved, &mut self.sketch);
                if cost < least {
                    (best, least) = (moved, cost);
                }
            }
        }
        best
    }

    /// Poses in all orientations whose outline is where the new points are, the most alike first.
    fn hypotheses(&self, planned: &Isometry3<f64>, changes: &Changes<'_>) -> Vec<Isometry3<f64>> {
        let judge = Judge::new(self.object, &self.cluster, changes);
        let mut judged: Vec<(f64, Isometry3<f64>)> = Vec::new();
        for upright in self.orientations(planned) {
            for step in 0..self.yaws() {
                let yaw_rad = std::f64::consts::TAU * step as f64 / YAWS as f64;
                let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
                let pose = judge.at_points(&(yaw * upright));
                judged.push((judge.cost(&pose), pose));
            }
        }
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut judged = distinct(judged, SHIFTED, |(_, pose)| *pose);
        for (cost, pose) in &mut judged {
            (*cost, *pose) = judge.shifted(*cost, pose);
        }
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        let chosen = distinct(judged, QUICK_FITS, |(_, pose)| *pose);
        chosen.into_iter().map(|(_, pose)| pose).collect()
    }

    fn yaws(&self) -> usize {
        if matches!(self.object.near_symmetry, Symmetry::Ball) {
            1
        } else {
            YAWS
        }
    }

    /// Orientations that differ in what is down: the planned one, those at rest, and others spread over the sphere.
    fn orientations(&self, planned: &Isometry3<f64>) -> Vec<UnitQuaternion<f64>> {
        let mut all = vec![planned.rotation];
        if matches!(self.object.near_symmetry, Symmetry::Ball) {
            return all;
        }
        let poses = self.object.poses.iter().take(MOST_POSES);
        all.extend(poses.map(|pose| pose.support_from_item.rotation));
        let down = -Vector3::z();
        all.extend((0..DIRECTIONS).map(|number| {
            UnitQuaternion::rotation_between(&direction(number, DIRECTIONS), &down).unwrap_or_else(
                || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI),
            )
        }));
        all
    }
}

/// Steps of the search for the outline: shifts, and turns about the vertical.
const STEPS: [(Vector3<f64>, f64); 6] = [
    (Vector3::new(1.0, 0.0, 0.0), 0.0),
    (Vector3::new(-1.0, 0.0, 0.0), 0.0),
    (Vector3::new(0.0, 1.0, 0.0), 0.0),
    (Vector3::new(0.0, -1.0, 0.0), 0.0),
    (Vector3::new(0.0, 0.0, 0.0), 1.0),
    (Vector3::new(0.0, 0.0, 0.0), -1.0),
];

/// One of `count` directions spread evenly over the sphere along a spiral.
pub(crate) fn direction(number: usize, count: usize) -> Vector3<f64> {
    let z = 1.0 - 2.0 * (number as f64 + 0.5) / count as f64;
    let turn_rad = number as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vector3::new(radius * turn_rad.cos(), radius * turn_rad.sin(), z)
}

fn sort(fits: &mut [Fit]) {
    fits.sort_by(|a, b| b.agreement.fitness.total_cmp(&a.agreement.fitness));
}

/// The first of those that are about the same, in their order, as many as asked for.
fn distinct<T>(all: Vec<T>, count: usize, pose_of: impl Fn(&T) -> Isometry3<f64>) -> Vec<T> {
    let mut chosen: Vec<T> = Vec::with_capacity(count);
    for one in all {
        let pose = pose_of(&one);
        let is_same = |other: &T| {
            let other = pose_of(other);
            other.rotation.angle_to(&pose.rotation) < SAME_RAD
                && (other.translation.vector - pose.translation.vector).norm() < SAME_M
        };
        if chosen.len() >= count {
            break;
        }
        if !chosen.iter().any(is_same) {
            chosen.push(one);
        }
    }
    chosen
}
