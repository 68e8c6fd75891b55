//! Checks that a container of four plane walls was found, and that it is empty.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::error::CalibrationError;
use super::found::{Found, RIM_BAND_M, WALL_MARGIN_M};
use super::settings::CalibrationSettings;
use super::sides::Side;

/// Minimum number of points, in a range of distances outside the inner face, by which a strip of a
/// side shows the rim; noise does not go so far.
const LEAST_RIM_POINTS: usize = 2;
const SURE_RIM_M: std::ops::Range<f64> = 0.0012..0.02;

/// Minimum share of each side's strips that shows the rim.
const LEAST_RIM_SHARE: f64 = 0.6;

/// Minimum height of things above the rim, and their maximum distance outside the walls' inner
/// faces, in metres.
const ABOVE_RIM_M: f64 = 0.01;
const OUTSIDE_M: f64 = 0.004;

/// Edge of the squares in which things that are not floor are counted, in metres.
const SQUARE_M: f64 = 0.01;

/// Minimum number of points by which a square is not floor.
const LEAST_SQUARE_POINTS: u32 = 3;

/// Minimum distance from the floor of things that are not floor, in metres and in root mean
/// squares.
const LEAST_OFF_M: f64 = 0.006;
const OFF_DEVIATIONS: f64 = 6.0;

/// Maximum area that is not floor, in square metres.
const LARGEST_OFF_M2: f64 = 0.0004;

/// Minimum share of the floor that is seen.
const LEAST_FLOOR_SHARE: f64 = 0.25;

/// Maximum distance of a wall's inner face from the rim's inner edge, in metres and in cells.
const LARGEST_LIP_M: f64 = 0.004;
const LARGEST_LIP_CELLS: f64 = 1.0;

/// Residuals of points from a container of four plane walls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Residuals {
    /// Root mean square distance of the floor's points from its plane, in metres.
    pub floor_rms_m: f64,
    /// Root mean square distance of the rim's points from its plane, in metres.
    pub rim_rms_m: f64,
    /// Root mean square distance of the walls' points from their planes, in metres; 0 where no wall
    /// is seen.
    pub walls_rms_m: f64,
    /// Distance of the walls from plane: 90 % of each lie within this of its plane, in metres.
    pub bow_m: f64,
    /// The greatest angle between a side and that of the rectangle, in radians.
    pub squareness_rad: f64,
    /// The angle between floor and rim, in radians.
    pub parallelism_rad: f64,
    /// Number of the four walls whose inner faces were seen. The others are taken from the rim's
    /// inner edge.
    pub walls_seen: usize,
}

/// Gives the residuals, where they are small enough.
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
    let bow_m = most(&mut lines().map(|line| line.bow_m))
        .max(most(&mut walls().map(|wall| wall.lean_m.abs())));
    let residuals = Residuals {
        floor_rms_m: surfaces.floor.rms(&Vector3::z()),
        rim_rms_m: surfaces.rim.rms(&Vector3::z()),
        walls_rms_m: most(&mut walls().map(|wall| wall.rms_m)),
        bow_m,
        squareness_rad: rectangle.skew_rad,
        parallelism_rad: surfaces.parallelism_rad(),
        walls_seen: walls().count(),
    };
    let limit_m = settings.largest_bow_m;
    if bow_m > limit_m {
        return Err(CalibrationError::new(format_args!(
            "a wall is bent or leans by {bow_m:.4} m where {limit_m} m is possible; the walls lean outwards by {:.1} \
             degrees: of a tote, tell `size`, `draft` and `corner_radius`",
            found.lean().atan().to_degrees()
        )));
    }
    let limit_m = settings.largest_rms_m;
    for (what, rms_m) in [
        ("floor", residuals.floor_rms_m),
        ("rim", residuals.rim_rms_m),
        ("walls", residuals.walls_rms_m),
    ] {
        if rms_m > limit_m {
            return Err(CalibrationError::new(format_args!(
                "the points of the {what} are {rms_m:.4} m from a plane (root mean square) where {limit_m} m is possible"
            )));
        }
    }
    let limit_rad = settings.largest_skew_rad;
    for (what, angle_rad) in [
        ("sides", residuals.squareness_rad),
        ("floor and rim", residuals.parallelism_rad),
    ] {
        if angle_rad > limit_rad {
            let [angle, limit] = [angle_rad, limit_rad].map(f64::to_degrees);
            return Err(CalibrationError::new(format_args!(
                "{what} are {angle:.2} degrees off where {limit:.2} is possible"
            )));
        }
    }
    let sides = rectangle.sides.iter();
    let lips = sides.filter_map(|side| side.wall.map(|wall| wall.line).zip(side.edge));
    let apart_m = most(&mut lips.map(|(wall, edge)| {
        (wall.straightened_m(wall.slope) - edge.straightened_m(wall.slope)).abs()
    }));
    let limit_m = LARGEST_LIP_M + LARGEST_LIP_CELLS * opening.pitch_m;
    if apart_m > limit_m {
        return Err(CalibrationError::new(format_args!(
            "a wall's inner face and its rim's inner edge are {apart_m:.4} m apart where {limit_m:.4} m is possible"
        )));
    }
    Ok(residuals)
}

/// Makes sure that the rim is one: level outside each wall's face, nothing above, and no wall cut
/// by the image's edge.
pub(super) fn has_rim(found: &Found) -> Result<(), CalibrationError> {
    let rectangle = &found.rectangle;
    let rim_m = found.surfaces.rim.mean.z;
    let points_m = &found.levelled.points_m;
    for (side, across_m) in rectangle.sides.iter().zip(&rectangle.across_m) {
        let across_m = across_m.unwrap_or(side.frame.about_m);
        let mut counts = vec![0; side.frame.strips()];
        let is_level = |point: &&Point3<f64>| (point.z - rim_m).abs() <= RIM_BAND_M;
        for point in points_m.iter().filter(is_level) {
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
            return Err(CalibrationError::new(
                "the rim is not seen along a side: is the whole rim in view?",
            ));
        }
    }
    let mut above = Squares::default();
    for point in points_m {
        if point.z > rim_m + ABOVE_RIM_M && rectangle.contains(&point.xy(), -OUTSIDE_M) {
            above.count(point);
        }
    }
    let area_m2 = above.area_m2(LEAST_SQUARE_POINTS);
    if area_m2 > LARGEST_OFF_M2 {
        return Err(CalibrationError::new(format_args!(
            "{area_m2:.4} m^2 within the walls are higher than what seems the rim: is the whole rim in view, and nothing \
             above it?"
        )));
    }
    Ok(())
}

/// Makes sure that nothing is in the container, and that enough of its floor is seen.
pub(super) fn is_empty(found: &Found, floor_rms_m: f64) -> Result<(), CalibrationError> {
    let rectangle = &found.rectangle;
    let floor_m = found.surfaces.floor.mean.z;
    let off_m = (OFF_DEVIATIONS * floor_rms_m).max(LEAST_OFF_M);
    let points = found.levelled.points_m.iter();
    let inside = points.filter(|point| rectangle.floor_contains(&point.xy(), WALL_MARGIN_M));
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
    for (squares, side) in [(above, "above"), (below, "below what seems")] {
        let area_m2 = squares.area_m2(LEAST_SQUARE_POINTS);
        if area_m2 > LARGEST_OFF_M2 {
            return Err(CalibrationError::new(format_args!(
                "the container is not empty: {area_m2:.4} m^2 lie {side} its floor"
            )));
        }
    }
    let seen_share = floor.area_m2(1) / rectangle.floor_m2();
    if seen_share < LEAST_FLOOR_SHARE {
        return Err(CalibrationError::no_floor(seen_share));
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

    /// Gives the area of the squares with at least so many points, in square metres.
    fn area_m2(&self, least_points: u32) -> f64 {
        let counted = self.0.values().filter(|points| **points >= least_points);
        counted.count() as f64 * SQUARE_M * SQUARE_M
    }
}
