//! Poses of one object at new points.

use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::align::{AlignSettings, align, centroid};
use crate::expected::{Agreement, Observation, Sketch};
use crate::inspection::changes::Changes;
use crate::library::LibraryObject;
use crate::recognise::spread;
use crate::samples::SurfacePoint;
use crate::segmentation::Cluster;
use crate::spacing::spacing_m;
use crate::symmetry::Symmetry;

/// Directions of the sphere that are tried to be down, besides those in which the object rests.
const DIRECTIONS: usize = 32;

/// The most resting poses that are tried.
const MOST_POSES: usize = 24;

/// Yaws that each direction is tried at.
const YAWS: usize = 20;

/// New points, and points of the surface, that a hypothesis is judged by.
const JUDGED_POINTS: usize = 48;
const JUDGED_SURFACE: usize = 96;

/// A point farther than this from a hypothesis is as bad as any other, in metres.
const FAR_M: f64 = 0.012;

/// A surface this much higher than any point there should be seen, in metres.
const SEEN_THROUGH_M: f64 = 0.006;

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
    centre: Point3<f64>,
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
            centre,
            sketch: Sketch::default(),
        })
    }

    /// The fit that alignment leads to from the planned pose.
    pub(crate) fn near_planned(&mut self, planned: &Isometry3<f64>) -> Fit {
        self.aligned(planned, &PLANNED)
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
        let starts = distinct(self.hypotheses(planned, changes), QUICK_FITS, |start| {
            *start
        });
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
        fits
    }

    /// Poses in all orientations whose visible side is where the new points are, the most alike first.
    fn hypotheses(&self, planned: &Isometry3<f64>, changes: &Changes<'_>) -> Vec<Isometry3<f64>> {
        let to_eye = Unit::new_normalize(self.cluster.eye_m - self.centre);
        let points = spread(&self.cluster.points_m, JUDGED_POINTS);
        let stride = self.object.points.len().div_ceil(JUDGED_SURFACE).max(1);
        let surface: Vec<SurfacePoint> =
            self.object.points.iter().step_by(stride).copied().collect();
        let mut judged: Vec<(f64, Isometry3<f64>)> = Vec::new();
        for upright in self.orientations(planned) {
            for step in 0..self.yaws() {
                let yaw_rad = std::f64::consts::TAU * step as f64 / YAWS as f64;
                let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
                let rotation = yaw * upright;
                let faces_eye = rotation.inverse() * *to_eye;
                let Some(middle) = visible_middle(&surface, &faces_eye) else {
                    continue;
                };
                let shift = self.centre - rotation * middle;
                let pose = Translation3::from(shift) * rotation;
                let visible = surface
                    .iter()
                    .filter(|point| point.normal.dot(&faces_eye) > LEAST_FACING);
                let cost =
                    self.distance_cost(&points, &pose) + seen_through(visible, &pose, changes);
                judged.push((cost, pose));
            }
        }
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        judged.into_iter().map(|(_, pose)| pose).collect()
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
            UnitQuaternion::rotation_between(&direction(number), &down).unwrap_or_else(|| {
                UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
            })
        }));
        all
    }

    /// The mean square distance of points from a pose, cut off and scaled to at most 1.
    fn distance_cost(&self, points: &[Point3<f64>], pose: &Isometry3<f64>) -> f64 {
        let inverse = pose.inverse();
        let rotation = inverse.rotation.to_rotation_matrix();
        let shift = inverse.translation.vector;
        let costs = points.iter().map(|point| {
            let nearest = self.object.nearest.nearest(&(rotation * point + shift));
            (nearest.distance_m / FAR_M).min(1.0).powi(2)
        });
        costs.sum::<f64>() / points.len().max(1) as f64
    }
}

/// A surface whose normal is this far from the direction to the eye, as a cosine, is seen.
const LEAST_FACING: f64 = 0.15;

/// The middle of what faces a direction, as it looks from there.
fn visible_middle(surface: &[SurfacePoint], faces_eye: &Vector3<f64>) -> Option<Point3<f64>> {
    let (mut sum, mut weights) = (Vector3::zeros(), 0.0);
    for point in surface {
        let weight = point.normal.dot(faces_eye);
        if weight > LEAST_FACING {
            sum += point.point.coords * weight;
            weights += weight;
        }
    }
    (weights > 0.0).then(|| Point3::from(sum / weights))
}

/// The share of points of a posed surface that the camera looks through.
fn seen_through<'points>(
    surface: impl Iterator<Item = &'points SurfacePoint>,
    pose: &Isometry3<f64>,
    changes: &Changes<'_>,
) -> f64 {
    let (mut all, mut through) = (0_u32, 0_u32);
    let rotation = pose.rotation.to_rotation_matrix();
    for point in surface {
        let place = rotation * point.point + pose.translation.vector;
        let height_m = changes.after_at(place.x, place.y);
        all += 1;
        through += u32::from(height_m.is_some_and(|height_m| place.z > height_m + SEEN_THROUGH_M));
    }
    f64::from(through) / f64::from(all.max(1))
}

/// One of the directions spread evenly over the sphere along a spiral.
fn direction(number: usize) -> Vector3<f64> {
    let z = 1.0 - 2.0 * (number as f64 + 0.5) / DIRECTIONS as f64;
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
