//! What makes sure that what was found is a container of four plane walls that is empty.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

use super::levelled::Levelled;
use super::opening::Opening;
use super::plane::{Spread, normal_of};
use super::rectangle::Rectangle;
use super::sides::Side;
use super::{CalibrationError, CalibrationSettings, Found, Residuals};

/// Points within this of the floor's height belong to it, in metres.
const FLOOR_BAND_M: f64 = 0.008;

/// Points within this of the rim's height belong to it, in metres.
const RIM_BAND_M: f64 = 0.008;

/// The rim begins this far outside the walls' inner faces, and reaches no farther than this, in metres.
const RIM_M: std::ops::Range<f64> = 0.0005..0.02;

/// A strip of a side shows the rim where so many points lie on it, so far outside the inner face: farther than noise
/// takes those of the wall.
const LEAST_RIM_POINTS: usize = 2;
const SURE_RIM_M: std::ops::Range<f64> = 0.0012..0.02;

/// Of each side's strips, at least this share shows the rim.
const LEAST_RIM_SHARE: f64 = 0.6;

/// What is this far above the rim is not the rim, in metres, and no farther outside the walls' inner faces than this.
const ABOVE_RIM_M: f64 = 0.01;
const OUTSIDE_M: f64 = 0.004;

/// What is nearer to a wall is not looked at, in metres.
const WALL_MARGIN_M: f64 = 0.015;

/// What is not floor is counted in squares of this edge, in metres.
const SQUARE_M: f64 = 0.01;

/// A square with so many points that are not floor is not floor.
const LEAST_SQUARE_POINTS: u32 = 3;

/// What is not floor lies at least this far above or below it, in metres, and at least so many root mean squares.
const LEAST_OFF_M: f64 = 0.006;
const OFF_DEVIATIONS: f64 = 6.0;

/// The greatest area that is not floor, in square metres.
const LARGEST_OFF_M2: f64 = 0.0004;

/// Of the floor, at least this share is seen.
const LEAST_FLOOR_SHARE: f64 = 0.25;

/// The inner face of a wall and the rim's inner edge are this far apart at most, in metres and in cells.
const LARGEST_LIP_M: f64 = 0.004;
const LARGEST_LIP_CELLS: f64 = 1.0;

/// The planes of floor and rim.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surfaces {
    pub(super) floor: Spread,
    pub(super) rim: Spread,
}

impl Surfaces {
    pub(super) fn fit(
        levelled: &Levelled,
        opening: &Opening,
        rectangle: &Rectangle,
    ) -> Result<Self, CalibrationError> {
        let points = || levelled.points_m.iter();
        let floor = points().filter(|point| {
            (point.z - opening.floor_m).abs() <= FLOOR_BAND_M
                && rectangle.contains(&point.xy(), WALL_MARGIN_M)
        });
        let rim = points().filter(|point| {
            (point.z - opening.rim_m).abs() <= RIM_BAND_M
                && RIM_M.contains(&-rectangle.inside_m(&point.xy()))
        });
        Ok(Self {
            floor: Spread::of(floor).ok_or(CalibrationError::NoFloor { seen_share: 0.0 })?,
            rim: Spread::of(rim).ok_or(CalibrationError::NoRim)?,
        })
    }

    /// Up by both planes, in the sensor's frame.
    pub(super) fn up(&self, levelled: &Levelled) -> Unit<Vector3<f64>> {
        let up = normal_of(self.scatter(), &Vector3::z());
        levelled.levelled_from_sensor.rotation.inverse() * up
    }

    fn scatter(&self) -> Matrix3<f64> {
        self.floor.scatter + self.rim.scatter
    }

    /// The depth of the container, in metres.
    pub(super) fn depth_m(&self) -> f64 {
        self.rim.mean.z - self.floor.mean.z
    }

    fn parallelism_rad(&self) -> f64 {
        let up = Vector3::z();
        self.floor.normal(&up).angle(&self.rim.normal(&up))
    }
}

/// How well the points fit, where that is good enough.
pub(super) fn residuals(
    found: &Found,
    settings: &CalibrationSettings,
) -> Result<Residuals, CalibrationError> {
    let Found {
        surfaces,
        rectangle,
        opening,
        ..
    } = found;
    let walls = || rectangle.sides.iter().filter_map(|side| side.wall);
    let lines = || rectangle.sides.iter().filter_map(Side::line);
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let bow_m =
        most(&mut lines().map(|line| line.bow_m)).max(most(&mut walls().map(|wall| wall.lean_m)));
    let residuals = Residuals {
        floor_rms_m: surfaces.floor.rms(&Vector3::z()),
        rim_rms_m: surfaces.rim.rms(&Vector3::z()),
        walls_rms_m: most(&mut walls().map(|wall| wall.rms_m)),
        bow_m,
        squareness_rad: rectangle.skew_rad,
        parallelism_rad: surfaces.parallelism_rad(),
        walls_seen: walls().count(),
    };
    if bow_m > settings.largest_bow_m {
        return Err(CalibrationError::Bent {
            bow_m,
            limit_m: settings.largest_bow_m,
        });
    }
    for (what, rms_m) in [
        ("floor", residuals.floor_rms_m),
        ("rim", residuals.rim_rms_m),
        ("walls", residuals.walls_rms_m),
    ] {
        if rms_m > settings.largest_rms_m {
            return Err(CalibrationError::Rough {
                what,
                rms_m,
                limit_m: settings.largest_rms_m,
            });
        }
    }
    for (what, angle_rad) in [
        ("sides", residuals.squareness_rad),
        ("floor and rim", residuals.parallelism_rad),
    ] {
        if angle_rad > settings.largest_skew_rad {
            return Err(CalibrationError::Skew {
                what,
                angle_rad,
                limit_rad: settings.largest_skew_rad,
            });
        }
    }
    let lips = rectangle
        .sides
        .iter()
        .filter_map(|side| side.wall.zip(side.edge));
    let apart_m = most(&mut lips.map(|(wall, edge)| {
        (wall.line.straightened_m(wall.line.slope) - edge.straightened_m(wall.line.slope)).abs()
    }));
    let limit_m = LARGEST_LIP_M + LARGEST_LIP_CELLS * opening.pitch_m;
    if apart_m > limit_m {
        return Err(CalibrationError::Lip { apart_m, limit_m });
    }
    Ok(residuals)
}

/// Makes sure that the rim is one: level ground outside each wall's inner face, and nothing above. Walls that are cut by
/// the edge of the image are none.
pub(super) fn has_rim(found: &Found) -> Result<(), CalibrationError> {
    let rectangle = &found.rectangle;
    let rim_m = found.surfaces.rim.mean.z;
    let points_m = &found.levelled.points_m;
    for (side, across_m) in rectangle.sides.iter().zip(&rectangle.across_m) {
        let across_m = across_m.unwrap_or(side.frame.about_m);
        let mut counts = vec![0; side.frame.strips()];
        let level = points_m
            .iter()
            .filter(|point| (point.z - rim_m).abs() <= RIM_BAND_M);
        for point in level {
            let [along_m, point_across_m] = side.frame.along_and_across(&point.xy());
            let strip = side.frame.strip(along_m);
            if let Some(count) = strip.and_then(|strip| counts.get_mut(strip))
                && SURE_RIM_M.contains(&(point_across_m - across_m))
            {
                *count += 1;
            }
        }
        let seen = counts.iter().filter(|count| **count >= LEAST_RIM_POINTS);
        if (seen.count() as f64) < LEAST_RIM_SHARE * counts.len() as f64 {
            return Err(CalibrationError::RimUnseen);
        }
    }
    let mut above = Squares::default();
    let high = points_m
        .iter()
        .filter(|point| point.z > rim_m + ABOVE_RIM_M);
    for point in high.filter(|point| rectangle.contains(&point.xy(), -OUTSIDE_M)) {
        above.count(point);
    }
    let area_m2 = above.area_m2(LEAST_SQUARE_POINTS);
    if area_m2 > LARGEST_OFF_M2 {
        return Err(CalibrationError::AboveRim { area_m2 });
    }
    Ok(())
}

/// Makes sure that nothing is in the container, and that enough of its floor is seen.
pub(super) fn is_empty(found: &Found, floor_rms_m: f64) -> Result<(), CalibrationError> {
    let rectangle = &found.rectangle;
    let floor_m = found.surfaces.floor.mean.z;
    let off_m = (OFF_DEVIATIONS * floor_rms_m).max(LEAST_OFF_M);
    let inside = found
        .levelled
        .points_m
        .iter()
        .filter(|point| rectangle.contains(&point.xy(), WALL_MARGIN_M));
    let (mut floor, mut above, mut below) =
        (Squares::default(), Squares::default(), Squares::default());
    for point in inside {
        let from_floor_m = point.z - floor_m;
        if from_floor_m > off_m {
            above.count(point);
        } else if from_floor_m < -off_m {
            below.count(point);
        } else {
            floor.count(point);
        }
    }
    for (squares, is_above) in [(above, true), (below, false)] {
        let area_m2 = squares.area_m2(LEAST_SQUARE_POINTS);
        if area_m2 > LARGEST_OFF_M2 {
            return Err(CalibrationError::NotEmpty { area_m2, is_above });
        }
    }
    let seen_share = floor.area_m2(1) / rectangle.area_m2();
    if seen_share < LEAST_FLOOR_SHARE {
        return Err(CalibrationError::NoFloor { seen_share });
    }
    Ok(())
}

/// Points, counted in squares.
#[derive(Debug, Default)]
struct Squares(std::collections::BTreeMap<(i32, i32), u32>);

impl Squares {
    fn count(&mut self, point: &Point3<f64>) {
        let [x, y] = [point.x, point.y].map(|side_m| (side_m / SQUARE_M).floor() as i32);
        *self.0.entry((x, y)).or_default() += 1;
    }

    /// The area of the squares with at least so many points, in square metres.
    fn area_m2(&self, least_points: u32) -> f64 {
        let counted = self.0.values().filter(|points| **points >= least_points);
        counted.count() as f64 * SQUARE_M * SQUARE_M
    }
}
