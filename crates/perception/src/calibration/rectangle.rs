//! The rectangle of the container's inner faces, seen from above.

use nalgebra::{Point2, Rotation2, Vector2};

use super::error::CalibrationError;
use super::levelled::Levelled;
use super::opening::Opening;
use super::settings::CalibrationSettings;
use super::sides::{CORNER_M, Frame, Side};

/// Number of looks at the sides, each in the rectangle of the last.
const ROUNDS: usize = 3;

/// Share of the hole's cells that the rectangle around it leaves out at each side.
const BEYOND_SHARE: f64 = 0.01;

/// Maximum distance of a side from where it is about, in metres, less a cell: bent walls are seen
/// as such.
const REACH_M: f64 = 0.02;

/// A rectangle. Its sides are numbered counter-clockwise from that towards `outward`.
#[derive(Debug, Clone)]
pub(super) struct Rectangle {
    pub(super) sides: [Side; 4],
    /// Distance of each side from the origin, outwards, in metres; `None` where it is not seen.
    pub(super) across_m: [Option<f64>; 4],
    /// Direction of the first side.
    pub(super) outward: Vector2<f64>,
    /// The greatest angle between a side and that of the rectangle, in radians.
    pub(super) skew_rad: f64,
    /// Distance of the floor's edges from those of the rim, about, in metres.
    foot_m: f64,
}

impl Rectangle {
    /// Says whether a place is inside all sides that were seen, by a margin that may be negative.
    pub(super) fn contains(&self, place: &Point2<f64>, margin_m: f64) -> bool {
        self.inside_m(place) >= margin_m
    }

    /// Gives the distance of a place from the nearest side, in metres; negative outside.
    pub(super) fn inside_m(&self, place: &Point2<f64>) -> f64 {
        let sides = self.sides.iter().zip(&self.across_m);
        let inside = sides.map(|(side, across_m)| {
            across_m.unwrap_or(side.frame.about_m) - side.frame.outward.dot(&place.coords)
        });
        inside.fold(f64::INFINITY, f64::min)
    }

    /// Says whether a place is inside the floor, by a margin.
    pub(super) fn floor_contains(&self, place: &Point2<f64>, margin_m: f64) -> bool {
        self.contains(place, self.foot_m + margin_m)
    }

    /// Gives the area of the floor, in square metres.
    pub(super) fn floor_m2(&self) -> f64 {
        let [a, b, c, d] = self.about_m();
        (a + c - 2.0 * self.foot_m) * (b + d - 2.0 * self.foot_m)
    }

    /// Gives the distance of each side from the origin, in metres, seen or not.
    fn about_m(&self) -> [f64; 4] {
        let mut about_m = self.sides.map(|side| side.frame.about_m);
        for (about_m, across_m) in about_m.iter_mut().zip(&self.across_m) {
            *about_m = across_m.unwrap_or(*about_m);
        }
        about_m
    }
}

/// Gives the directions of a rectangle's sides, counter-clockwise.
pub(super) fn directions(outward: &Vector2<f64>) -> [Vector2<f64>; 4] {
    let next = Vector2::new(-outward.y, outward.x);
    [*outward, next, -outward, -next]
}

/// Adjusts a rectangle to the sides of the opening.
pub(super) fn find(
    levelled: &Levelled,
    opening: &Opening,
    settings: &CalibrationSettings,
) -> Result<Rectangle, CalibrationError> {
    let reach_m = REACH_M + opening.pitch_m;
    let round_m = settings.size.map_or(0.0, |size| size.corner_radius_m);
    let corner_m = CORNER_M.max(round_m);
    let look = |(outward, about_m)| {
        let rectangle = adjust(levelled, opening, corner_m, outward, about_m, reach_m);
        let [a, b, c, d] = rectangle.across_m.map(|across_m| across_m.is_some());
        // One of two opposite sides is enough where the distance between them is known.
        let is_known =
            |one: bool, other: bool| (one && other) || (settings.size.is_some() && (one || other));
        match is_known(a, c) && is_known(b, d) {
            true => Ok(rectangle),
            false => Err(CalibrationError::side_unseen()),
        }
    };
    let first = look(around(opening))?;
    (1..ROUNDS).try_fold(first, |last, _| look((last.outward, last.about_m())))
}

/// Gives the rectangle whose sides are nearest to those that are seen, all turned together.
fn adjust(
    levelled: &Levelled,
    opening: &Opening,
    corner_m: f64,
    outward: Vector2<f64>,
    about_m: [f64; 4],
    reach_m: f64,
) -> Rectangle {
    let [a, b, c, d] = about_m;
    let look = |outward, about_m, ends_m| {
        let frame = Frame {
            outward,
            ends_m,
            about_m,
            corner_m,
        };
        Side::look(levelled, opening, frame, reach_m)
    };
    let [one, two, three, four] = directions(&outward);
    // Along a side, counter-clockwise: from the side before it to the one after.
    let sides = [
        look(one, a, [-d, b]),
        look(two, b, [-a, c]),
        look(three, c, [-b, d]),
        look(four, d, [-c, a]),
    ];
    let lines = || sides.iter().filter_map(Side::line);
    let weight_m2: f64 = lines().map(|line| line.weight_m2).sum();
    let weighted: f64 = lines().map(|line| line.weight_m2 * line.slope).sum();
    let is_seen = weight_m2 > 0.0;
    let slope = if is_seen { weighted / weight_m2 } else { 0.0 };
    let off = lines().map(|line| (line.slope - slope).abs());
    Rectangle {
        sides,
        across_m: sides.map(|side| side.line().map(|line| line.straightened_m(slope))),
        // Turned counter-clockwise, a side falls back along its direction.
        outward: Rotation2::new(-slope.atan()) * outward,
        skew_rad: off.fold(0.0, f64::max).atan(),
        foot_m: opening.lean * (opening.rim_m - opening.floor_m),
    }
}

/// Finds the smallest rectangle around the opening's cells but for a few at each side: the
/// direction of its first side, and the distances of its sides. As some cells are left out, it need
/// not lie along an edge of their hull, as the least rectangle around points does
/// (`ppnpack_packing::kernel::rectangle`), and all yaws are tried.
fn around(opening: &Opening) -> (Vector2<f64>, [f64; 4]) {
    let step_rad = 1.0_f64.to_radians();
    let mut coarse = (0..90).map(|step| f64::from(step) * step_rad);
    let best = |angles: &mut dyn Iterator<Item = f64>| {
        let areas = angles.map(|angle_rad| {
            let outward = Rotation2::new(angle_rad) * Vector2::x();
            let sides_m = extents_m(&opening.cells_m, &outward);
            let [a, b, c, d] = sides_m;
            ((a + c) * (b + d), angle_rad, sides_m)
        });
        areas.min_by(|one, two| one.0.total_cmp(&two.0))
    };
    let coarse_rad = best(&mut coarse).map_or(0.0, |(_, angle_rad, _)| angle_rad);
    let mut fine = (-10..=10).map(|step| coarse_rad + f64::from(step) * 0.1 * step_rad);
    let (_, angle_rad, sides_m) = best(&mut fine).unwrap_or((0.0, 0.0, [0.0; 4]));
    // The hole lost a cell and a half at each side to the grown rim, and half of one to its cells'
    // middles.
    let lost_m = 1.5 * opening.pitch_m;
    (
        Rotation2::new(angle_rad) * Vector2::x(),
        sides_m.map(|side_m| side_m + lost_m),
    )
}

/// Gives the reach of cells towards four sides, but for a few.
fn extents_m(cells_m: &[Point2<f64>], outward: &Vector2<f64>) -> [f64; 4] {
    let [first, second, ..] = directions(outward);
    let [a, c] = ends_m(cells_m, &first);
    let [b, d] = ends_m(cells_m, &second);
    [a, b, c, d]
}

fn ends_m(cells_m: &[Point2<f64>], direction: &Vector2<f64>) -> [f64; 2] {
    let places = cells_m.iter().map(|cell| direction.dot(&cell.coords));
    let mut places: Vec<f64> = places.collect();
    let beyond = (BEYOND_SHARE * places.len() as f64) as usize;
    let last = places.len().saturating_sub(1 + beyond);
    if places.len() <= 2 * beyond + 1 {
        return [0.0; 2];
    }
    let highest = *places.select_nth_unstable_by(last, f64::total_cmp).1;
    let lowest = *places.select_nth_unstable_by(beyond, f64::total_cmp).1;
    [highest, -lowest]
}
