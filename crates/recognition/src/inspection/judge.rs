//! A quick look at a pose: how far new points are from it, and how much of it the camera looks
//! through.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::inspection::changes::Changes;
use crate::object::LibraryObject;
use crate::pattern::{Move, Pattern};
use crate::samples::{SurfacePoint, spread};

/// Number of new points that a hypothesis is judged by.
const POINTS: usize = 48;
/// Number of points of the surface that it is judged by.
const SURFACE: usize = 96;
/// Distance of a point from a hypothesis beyond which none is worse, in metres.
const FAR_M: f64 = 0.012;
/// Minimum height above any point there of a surface that should be seen, in metres.
const SEEN_THROUGH_M: f64 = 0.006;
/// Share of new points beyond the box that they are taken to fill, at each side: some are not the
/// item's.
const BEYOND: f64 = 0.01;
/// Shifts of a hypothesis to the place where it is judged best; twice, as one direction may open
/// another.
const PATTERN: Pattern = Pattern {
    first_step_m: 0.008,
    moves: [Move::X, Move::Y, Move::Z],
    sweeps: 2,
};

/// Judges poses of an object at new points.
pub(crate) struct Judge<'scene> {
    object: &'scene LibraryObject,
    changes: &'scene Changes<'scene>,
    points: Vec<Point3<f64>>,
    surface: Vec<SurfacePoint>,
    /// The middle of the new points seen from above, at the height of their top.
    top: Point3<f64>,
}

impl<'scene> Judge<'scene> {
    pub(crate) fn new(
        object: &'scene LibraryObject,
        new_m: &[Point3<f64>],
        changes: &'scene Changes<'scene>,
    ) -> Self {
        let stride = object.points.len().div_ceil(SURFACE).max(1);
        let range = |axis: usize| {
            let mut values: Vec<f64> = new_m.iter().map(|point| point[axis]).collect();
            values.sort_by(f64::total_cmp);
            let beyond = (BEYOND * values.len() as f64) as usize;
            let low = values.get(beyond).copied().unwrap_or_default();
            let high = values.iter().rev().nth(beyond).copied().unwrap_or_default();
            (low, high)
        };
        let middle = |(low, high): (f64, f64)| f64::midpoint(low, high);
        Self {
            object,
            changes,
            points: spread(new_m, POINTS),
            surface: object.points.iter().step_by(stride).copied().collect(),
            top: Point3::new(middle(range(0)), middle(range(1)), range(2).1),
        }
    }

    /// Gives the turned object with its outline in the middle of the points, and as high.
    pub(crate) fn at_points(&self, rotation: &UnitQuaternion<f64>) -> Isometry3<f64> {
        let matrix = rotation.to_rotation_matrix();
        let (mut lowest, mut highest) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
        for point in &self.object.points {
            let turned = matrix * point.point.coords;
            (lowest, highest) = (lowest.inf(&turned), highest.sup(&turned));
        }
        let middle = (lowest + highest) / 2.0;
        let shift = self.top.coords - Vector3::new(middle.x, middle.y, highest.z);
        Translation3::from(shift) * *rotation
    }

    /// Gives the cost of a pose, from 0, where nothing speaks against it, to 2.
    pub(crate) fn cost(&self, pose: &Isometry3<f64>) -> f64 {
        self.distance_cost(pose) + self.seen_through(pose)
    }

    /// Shifts a pose to where its cost is least nearby; gives it with that cost.
    pub(crate) fn shifted(&self, cost: f64, pose: &Isometry3<f64>) -> (f64, Isometry3<f64>) {
        let start = (cost, *pose);
        PATTERN.least(self.object, start, |pose| self.cost(pose))
    }

    /// Gives the mean square distance of points from a pose, cut off and scaled to at most 1.
    fn distance_cost(&self, pose: &Isometry3<f64>) -> f64 {
        let inverse = pose.inverse();
        let rotation = inverse.rotation.to_rotation_matrix();
        let shift = inverse.translation.vector;
        let costs = self.points.iter().map(|point| {
            let nearest = self.object.nearest.nearest(&(rotation * point + shift));
            (nearest.distance_m / FAR_M).min(1.0).powi(2)
        });
        costs.sum::<f64>() / self.points.len().max(1) as f64
    }

    /// Gives the share of points of the posed surface's upper side that the camera looks through.
    fn seen_through(&self, pose: &Isometry3<f64>) -> f64 {
        let (mut all, mut through) = (0_u32, 0_u32);
        let rotation = pose.rotation.to_rotation_matrix();
        let surface = self.surface.iter();
        for point in surface.filter(|point| (rotation * point.normal).z >= 0.0) {
            let place = rotation * point.point + pose.translation.vector;
            let height_m = self.changes.after_at(place.x, place.y);
            let is_through = height_m.is_some_and(|height_m| place.z > height_m + SEEN_THROUGH_M);
            all += 1;
            through += u32::from(is_through);
        }
        f64::from(through) / f64::from(all.max(1))
    }
}
