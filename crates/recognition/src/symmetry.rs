//! Symmetries: turns after which an object looks the same, found numerically.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};

use crate::align::{AlignSettings, align};
use crate::moments::{centroid, scatter};
use crate::nearest::NearestSurface;
use crate::samples::{SurfacePoint, yaws_rad};
use ppnpack_numbers::settings;

settings! {
    /// Limits within which two surfaces count as the same.
    ///
    /// A sensor with 1 mm of noise hardly tells these apart, and 3 mm are those within which a pose
    /// counts as right.
    #[derive(Copy)]
    pub struct SameSurface {
        /// The root of the mean square of distances is at most this, in metres.
        pub root_mean_square_m: f64 = 0.001,
        /// 98 % of the distances are at most this, in metres.
        pub nearly_all_m: f64 = 0.003,
    }
}

/// The turns about its centre after which an object looks the same.
#[derive(Debug, Clone, PartialEq)]
pub enum Symmetry {
    /// Any turn.
    Ball,
    /// Any turn about an axis of the item frame.
    Axis {
        /// The axis.
        axis: Unit<Vector3<f64>>,
        /// Whether turning the axis upside down changes nothing either.
        is_reversible: bool,
    },
    /// These turns, the identity among them.
    Turns(Vec<UnitQuaternion<f64>>),
}

/// Number of yaws that are tried about each axis and between two resting poses.
const YAWS: usize = 24;
/// Maximum number of guesses that are fitted; the best are first.
const MOST_FITS: usize = 48;
/// Minimum angle between guesses that are fitted, in radians.
const TRIED_RAD: f64 = 0.3;
/// Minimum angle between turns that are not one, in radians.
const SAME_RAD: f64 = 0.1;
/// Turns that show whether an object is round about an axis: no fractions of a full turn, then as
/// many evenly spaced.
const ODD_RAD: [f64; 2] = [0.31, 1.37];
const EVEN: usize = 7;

/// Number of surface points that a first look at a guess takes.
const LOOKED_AT: usize = 40;
/// Maximum mean distance of a guess that is worth fitting, in units of the greatest root mean
/// square of a fit.
const WORTH_FITTING: f64 = 5.0;
/// Settings by which a surface is fitted to another.
const FIT: AlignSettings = AlignSettings::new(12, (0.01, 0.003), None);

/// Gives the distances of points, moved by a transform, from a surface, in metres.
fn distances_m<'point>(
    surface: &NearestSurface,
    points: impl Iterator<Item = &'point SurfacePoint>,
    surface_from_points: &Isometry3<f64>,
) -> impl Iterator<Item = f64> {
    points.map(move |point| {
        let moved = surface_from_points * point.point;
        surface.nearest(&moved).distance_m
    })
}

/// Gives the mean distance of some points, moved by a transform, from a surface, in metres.
pub(crate) fn mean_distance_m(
    surface: &NearestSurface,
    points: &[SurfacePoint],
    surface_from_points: &Isometry3<f64>,
) -> f64 {
    let some = points.iter().step_by((points.len() / LOOKED_AT).max(1));
    let distances_m = distances_m(surface, some, surface_from_points);
    let (sum_m, count) = distances_m.fold((0.0, 0), |all, next| (all.0 + next, all.1 + 1));
    sum_m / f64::from(count.max(1))
}

impl SameSurface {
    /// Says whether points moved by a transform lie on a surface; no points lie on none.
    pub fn holds<'point>(
        &self,
        surface: &NearestSurface,
        points: impl IntoIterator<Item = &'point SurfacePoint>,
        surface_from_points: &Isometry3<f64>,
    ) -> bool {
        let mut distances_m: Vec<f64> =
            distances_m(surface, points.into_iter(), surface_from_points).collect();
        if distances_m.is_empty() {
            return false;
        }
        let squares = distances_m.iter().map(|distance_m| distance_m.powi(2));
        let squares: f64 = squares.sum();
        let count = distances_m.len();
        let rank = (distances_m.len() * 98 / 100).min(distances_m.len() - 1);
        let (_, nearly_all_m, _) = distances_m.select_nth_unstable_by(rank, f64::total_cmp);
        (squares / count as f64).sqrt() <= self.root_mean_square_m
            && *nearly_all_m <= self.nearly_all_m
    }

    /// Finds the transform near a first guess after which points lie on a surface; `None` where
    /// they do not.
    pub(crate) fn fitted(
        &self,
        surface: &NearestSurface,
        points: &[SurfacePoint],
        guess: &Isometry3<f64>,
    ) -> Option<Isometry3<f64>> {
        if mean_distance_m(surface, points, guess) > WORTH_FITTING * self.root_mean_square_m {
            return None;
        }
        let cloud: Vec<Point3<f64>> = points.iter().map(|point| point.point).collect();
        // `align` moves the surface to the points: the inverse of what is asked for.
        let fitted = align(surface, &cloud, &guess.inverse(), &FIT).inverse();
        self.holds(surface, points, &fitted).then_some(fitted)
    }
}

impl Symmetry {
    /// Finds the symmetry of a surface, and the point that all its turns leave in place.
    ///
    /// `downs` are the directions of the item frame that point down in its resting poses: an object
    /// that looks the same after a turn also rests in the turned pose, so that turns between
    /// resting poses, by any yaw, are all there are to try. Turns about the principal axes are
    /// tried too. All turns are about `middle`, near which the centre is taken to be, and may shift
    /// as they are fitted.
    pub(crate) fn of(
        surface: &NearestSurface,
        points: &[SurfacePoint],
        middle: &Point3<f64>,
        downs: &[Unit<Vector3<f64>>],
        same: &SameSurface,
    ) -> (Self, Point3<f64>) {
        let search = Search {
            surface,
            points,
            middle: *middle,
            same,
        };
        let axes = [&principal_axes(points)[..], downs].concat();
        let mut round = axes.iter().filter_map(|axis| search.round_about(axis));
        if let Some((axis, centre)) = round.next() {
            if round.any(|(other, _)| other.dot(&axis).abs() < 0.8) {
                return (Self::Ball, centre);
            }
            let half_turn = UnitQuaternion::from_axis_angle(&across(&axis), PI);
            let is_reversible = search.near(&half_turn).is_some();
            return (
                Self::Axis {
                    axis,
                    is_reversible,
                },
                centre,
            );
        }
        search.turns(guesses(&axes, downs))
    }

    /// Gives the least angle between two orientations of the object, over all that look the same,
    /// in radians.
    pub fn angle_between(&self, one: &UnitQuaternion<f64>, other: &UnitQuaternion<f64>) -> f64 {
        match self {
            Self::Ball => 0.0,
            Self::Axis {
                axis,
                is_reversible,
            } => {
                let angle = (one * axis).angle(&(other * axis));
                let reversed = is_reversible.then_some(PI - angle);
                reversed.map_or(angle, |reversed| angle.min(reversed))
            }
            Self::Turns(turns) => {
                let angles = turns.iter().map(|turn| one.angle_to(&(other * turn)));
                angles.fold(PI, f64::min)
            }
        }
    }

    /// Says whether some turn brings one direction of the item frame to within an angle of another.
    pub fn joins(
        &self,
        one: &Unit<Vector3<f64>>,
        other: &Unit<Vector3<f64>>,
        within_rad: f64,
    ) -> bool {
        match self {
            Self::Ball => true,
            Self::Axis {
                axis,
                is_reversible,
            } => {
                let (angle, other_angle) = (axis.angle(one), axis.angle(other));
                let reversed = PI - other_angle;
                (angle - other_angle).abs() < within_rad
                    || (*is_reversible && (angle - reversed).abs() < within_rad)
            }
            Self::Turns(turns) => {
                let mut turns = turns.iter();
                turns.any(|turn| (turn * one).angle(other) < within_rad)
            }
        }
    }
}

struct Search<'surface> {
    surface: &'surface NearestSurface,
    points: &'surface [SurfacePoint],
    middle: Point3<f64>,
    same: &'surface SameSurface,
}

impl Search<'_> {
    fn about_middle(&self, turn: &UnitQuaternion<f64>) -> Isometry3<f64> {
        Isometry3::rotation_wrt_point(*turn, self.middle)
    }

    /// Finds the transform near a turn after which the object looks the same; `None` where it does
    /// not.
    fn near(&self, turn: &UnitQuaternion<f64>) -> Option<Isometry3<f64>> {
        let guess = self.about_middle(turn);
        let (same, surface, points) = (self.same, self.surface, self.points);
        let fitted = same.fitted(surface, points, &guess);
        let fitted = fitted.filter(|fitted| fitted.rotation.angle_to(turn) < SAME_RAD);
        // The points of a ball let a fit slip away, where the turn itself is as good.
        fitted.or_else(|| same.holds(surface, points, &guess).then_some(guess))
    }

    /// Finds the centre of an object that is round about an axis through it, and that axis.
    fn round_about(&self, axis: &Unit<Vector3<f64>>) -> Option<(Unit<Vector3<f64>>, Point3<f64>)> {
        for angle_rad in ODD_RAD {
            self.near(&UnitQuaternion::from_axis_angle(axis, angle_rad))?;
        }
        // The mean of what evenly spaced turns make of a point lies on the axis.
        let mut sum = self.middle.coords;
        let mut direction = Vector3::zeros();
        for angle_rad in yaws_rad(EVEN).skip(1) {
            let fitted = self.near(&UnitQuaternion::from_axis_angle(axis, angle_rad))?;
            sum += (fitted * self.middle).coords;
            if let Some(found) = fitted.rotation.axis() {
                direction += found.into_inner() * found.dot(axis).signum();
            }
        }
        let found = Unit::try_new(direction, 1e-9)?;
        Some((found, Point3::from(sum / EVEN as f64)))
    }

    /// Finds the turns among guesses after which the object looks the same.
    fn turns(&self, guesses: Vec<UnitQuaternion<f64>>) -> (Symmetry, Point3<f64>) {
        let mut turns = vec![UnitQuaternion::identity()];
        let mut sum = self.middle.coords;
        let mut tried = turns.clone();
        let ranked = guesses.into_iter().map(|guess| {
            let moved = self.about_middle(&guess);
            (mean_distance_m(self.surface, self.points, &moved), guess)
        });
        let mut ranked: Vec<(f64, UnitQuaternion<f64>)> = ranked.collect();
        ranked.retain(|(mean_m, _)| *mean_m <= WORTH_FITTING * self.same.root_mean_square_m);
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, guess) in ranked {
            if tried.len() > MOST_FITS {
                break;
            }
            let is_near = |turn: &UnitQuaternion<f64>| turn.angle_to(&guess) < TRIED_RAD;
            if tried.iter().any(is_near) || turns.iter().any(is_near) {
                continue;
            }
            tried.push(guess);
            let guess = self.about_middle(&guess);
            let is_new = |fitted: &Isometry3<f64>| {
                let mut turns = turns.iter();
                turns.all(|turn| turn.angle_to(&fitted.rotation) >= SAME_RAD)
            };
            let fitted = self.same.fitted(self.surface, self.points, &guess);
            if let Some(fitted) = fitted.filter(is_new) {
                turns.push(fitted.rotation);
                sum += (fitted * self.middle).coords;
            }
        }
        let centre = Point3::from(sum / turns.len() as f64);
        (Symmetry::Turns(turns), centre)
    }
}

fn principal_axes(points: &[SurfacePoint]) -> Vec<Unit<Vector3<f64>>> {
    let points: Vec<Point3<f64>> = points.iter().map(|point| point.point).collect();
    let axes = centroid(&points).map(|middle| scatter(&points, &middle).eigenvectors);
    let axes = axes.iter().flat_map(|axes| axes.column_iter());
    axes.map(|axis| Unit::new_normalize(axis.into_owned()))
        .collect()
}

/// Gives some direction at a right angle.
fn across(axis: &Unit<Vector3<f64>>) -> Unit<Vector3<f64>> {
    let is_far = axis.x.abs() < 0.6;
    let least = if is_far { Vector3::x() } else { Vector3::y() };
    Unit::new_normalize(axis.cross(&least))
}

/// Gives turns worth trying: about the axes, and from each resting pose to each other.
fn guesses(axes: &[Unit<Vector3<f64>>], downs: &[Unit<Vector3<f64>>]) -> Vec<UnitQuaternion<f64>> {
    let about_axes = axes.iter().flat_map(|axis| {
        let yaws_rad = yaws_rad(YAWS).skip(1);
        yaws_rad.map(move |yaw_rad| UnitQuaternion::from_axis_angle(axis, yaw_rad))
    });
    let pairs = downs
        .iter()
        .flat_map(|from| downs.iter().map(move |to| (from, to)));
    let between = pairs
        .filter(|(from, to)| from != to)
        .flat_map(|(from, to)| {
            let half_turn = || UnitQuaternion::from_axis_angle(&across(from), PI);
            let tilt = UnitQuaternion::rotation_between(from, to).unwrap_or_else(half_turn);
            yaws_rad(YAWS).map(move |yaw_rad| UnitQuaternion::from_axis_angle(to, yaw_rad) * tilt)
        });
    about_axes.chain(between).collect()
}
