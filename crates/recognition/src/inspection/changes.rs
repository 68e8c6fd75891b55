//! Changes of a container, and places where something new would go unnoticed.

use nalgebra::{Isometry3, Point3};
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_packing::kernel::heightmap::Surface;

use crate::inspection::outcome::ContainerCloud;
use crate::inspection::settings::InspectionSettings;
use crate::inspection::squares::{NOTHING_M, Squares};
use crate::inspection::stances::Stance;
use crate::object::LibraryObject;

/// Maximum height of measurements above or below the container's origin, in metres.
const FARTHEST_M: f64 = 100.0;
/// Maximum distance of points around the container that are kept, in metres: its walls, and what
/// hangs over its rim.
const AROUND_M: f64 = 0.1;
/// Maximum number of points that are looked at; of more, evenly spaced ones.
const MOST_POINTS: usize = 1_000_000;
/// Maximum distance of a point from a sample that counts as seen, in spacings of the points.
const SEEN_SPACINGS: f64 = 1.5;

/// Share of an item's height by which it rises above what was there, and is noticed at the latest.
const NOTICED_SHARE: f64 = 0.8;

/// Minimum share of an item's length and of its width that is out of sight where it can hide.
const HIDING_SHARE: f64 = 0.75;

/// Maximum depth of a surface in the floor, in what was there, and in the walls, in metres.
const SUNK_M: f64 = 0.008;
/// Maximum share of the surface that may lie deeper.
const MOST_SUNK: f64 = 0.08;
/// Maximum distance of an item from everything below it that it rests on, in metres.
const FLOATING_M: f64 = 0.015;

/// A cloud of a container compared with what was there before; everything in the container frame,
/// in metres.
#[derive(Debug)]
pub(crate) struct Changes<'settings> {
    pub(crate) squares: Squares,
    /// Maximum height of the content before: where not seen, that of what hid it, or above the rim
    /// if that is unknown.
    most_m: Vec<f32>,
    /// Minimum height of the content before.
    least_m: Vec<f32>,
    /// Maximum height of the content before, wider by the blur.
    blurred_m: Vec<f32>,
    /// Height of the content before, narrower by the blur.
    certain_m: Vec<f32>,
    /// The greatest height of points around each square; [`NOTHING_M`] where none is.
    after_m: Vec<f32>,
    container: ContainerSize,
    eye_m: Point3<f64>,
    settings: &'settings InspectionSettings,
    pub(crate) new_m: Vec<Point3<f64>>,
    pub(crate) others_m: Vec<Point3<f64>>,
    /// The share of the container that is seen.
    pub(crate) seen_share: f64,
}

impl<'settings> Changes<'settings> {
    /// Compares a cloud; `None` where the surface or the container is none. What rises above
    /// `highest_m` is no item of interest.
    pub(crate) fn new(
        before: &Surface,
        after: &ContainerCloud<'_>,
        container: ContainerSize,
        highest_m: f64,
        settings: &'settings InspectionSettings,
    ) -> Option<Self> {
        let squares = Squares::of(before)?;
        let rim_m = container.z_m as f32;
        let heights_m = before.heights_m();
        let is_known = |height_m: f32| height_m < rim_m;
        let known_m = |height_m: &f32| {
            if is_known(*height_m) {
                *height_m
            } else {
                NOTHING_M
            }
        };
        let known_m: Vec<f32> = heights_m.iter().map(known_m).collect();
        let highest_known_m = greatest(&known_m);
        let most_m = |(square, height_m): (usize, &f32)| {
            let shadow_m = || squares.shadow_m(&known_m, highest_known_m, &after.eye_m, square);
            let hidden_m = (!is_known(*height_m)).then(shadow_m);
            let hidden_m = hidden_m.filter(|hidden_m| *hidden_m > 0.0);
            hidden_m.unwrap_or(*height_m)
        };
        let most_m: Vec<f32> = heights_m.iter().enumerate().map(most_m).collect();
        let reach = squares.reach(settings.blur_m);
        // What was only possible there is not certain.
        let negated = |heights_m: &[f32]| -> Vec<f32> { heights_m.iter().map(|m| -m).collect() };
        let certain_m = negated(&squares.greatest(&negated(before.support_m()), reach));
        let mut changes = Self {
            squares,
            blurred_m: squares.greatest(&most_m, reach),
            most_m,
            least_m: known_m
                .iter()
                .zip(before.support_m())
                .map(|(height_m, held_m)| height_m.min(*held_m).max(0.0))
                .collect(),
            certain_m,
            after_m: Vec::new(),
            container,
            eye_m: after.eye_m,
            settings,
            new_m: Vec::new(),
            others_m: Vec::new(),
            seen_share: 0.0,
        };
        changes.sort(after.points_m, highest_m);
        Some(changes)
    }

    fn sort(&mut self, points_m: &[Point3<f64>], highest_m: f64) {
        let mut after_m = vec![NOTHING_M; self.most_m.len()];
        let mut inside = 0_u32;
        let stride = points_m.len().div_ceil(MOST_POINTS).max(1);
        for point in points_m.iter().step_by(stride) {
            if !self.is_around(point) {
                continue;
            }
            let is_within = self.is_within_walls(point);
            let square = self.squares.at(point.x, point.y).filter(|_| is_within);
            let blurred_m = square.and_then(|square| self.blurred_m.get(square));
            let rise_m = blurred_m.map(|height_m| point.z - f64::from(*height_m));
            let has_risen = rise_m.is_some_and(|rise_m| rise_m > self.settings.least_rise_m);
            match has_risen && point.z < highest_m {
                true => self.new_m.push(*point),
                false => self.others_m.push(*point),
            }
            if let Some(height_m) = square.and_then(|square| after_m.get_mut(square)) {
                inside += 1;
                *height_m = height_m.max(point.z as f32);
            }
        }
        let area_m2 = self.container.x_m * self.container.y_m;
        let spacing_m = (area_m2 / f64::from(inside.max(1))).sqrt();
        // With few points, most of the container is unseen, whatever their spacing.
        let (squares, seen_m) = (self.squares, SEEN_SPACINGS * spacing_m);
        let reach = squares.reach(seen_m - 0.5 * squares.pitch_m).clamp(1, 4);
        self.after_m = squares.greatest(&after_m, reach);
        let within = (0..self.most_m.len()).filter(|square| !self.is_margin(*square));
        let (mut all, mut seen) = (0_u32, 0_u32);
        for square in within {
            all += 1;
            seen += u32::from(self.is_seen(square));
        }
        self.seen_share = f64::from(seen) / f64::from(all.max(1));
    }

    fn is_around(&self, point: &Point3<f64>) -> bool {
        let size = self.container;
        let is_near = |value: f64, side_m: f64| (-AROUND_M..=side_m + AROUND_M).contains(&value);
        // No comparison holds for what is not a number.
        is_near(point.x, size.x_m) && is_near(point.y, size.y_m) && point.z.abs() < FARTHEST_M
    }

    fn is_within_walls(&self, point: &Point3<f64>) -> bool {
        self.container.holds(point, self.settings.wall_margin_m)
    }

    /// Says whether a square lies beside a wall, or over one that leans.
    fn is_margin(&self, square: usize) -> bool {
        let middle = self.squares.middle(square);
        !self.is_within_walls(&Point3::new(middle.x, middle.y, 0.0))
    }

    fn is_seen(&self, square: usize) -> bool {
        let after_m = self.after_m.get(square);
        after_m.is_some_and(|height_m| *height_m > NOTHING_M)
    }

    /// Gives the height of the content before at the highest place nearby; `None` beyond the walls
    /// and where it was not known.
    pub(crate) fn blurred_at(&self, x_m: f64, y_m: f64) -> Option<f64> {
        self.known(&self.blurred_m, x_m, y_m)
    }

    fn known(&self, heights_m: &[f32], x_m: f64, y_m: f64) -> Option<f64> {
        let height_m = f64::from(*heights_m.get(self.squares.at(x_m, y_m)?)?);
        // What was not seen counts as higher than the rim.
        (height_m < self.container.z_m).then_some(height_m)
    }

    /// Gives the height of the points around a place now; `None` where there are none.
    pub(crate) fn after_at(&self, x_m: f64, y_m: f64) -> Option<f64> {
        let height_m = *self.after_m.get(self.squares.at(x_m, y_m)?)?;
        (height_m > NOTHING_M).then_some(f64::from(height_m))
    }

    /// Gives the area of the squares that hold new points, in square metres.
    pub(crate) fn new_area_m2(&self) -> f64 {
        let mut is_new = vec![false; self.most_m.len()];
        for point in &self.new_m {
            let square = self.squares.at(point.x, point.y);
            if let Some(is_new) = square.and_then(|square| is_new.get_mut(square)) {
                *is_new = true;
            }
        }
        let count = is_new.iter().filter(|is_new| **is_new).count();
        count as f64 * self.squares.pitch_m * self.squares.pitch_m
    }

    /// Says whether an object could be in the container in one of some stances without anything new
    /// being seen: in what is not seen, and where what was there is about as high.
    pub(crate) fn could_hide(&self, stances: &[Stance]) -> bool {
        let highest_m = greatest(&self.after_m);
        let (after_m, eye_m) = (&self.after_m, &self.eye_m);
        let shadow_m = |square| self.squares.shadow_m(after_m, highest_m, eye_m, square);
        let shadows_m: Vec<f32> = (0..self.most_m.len()).map(shadow_m).collect();
        stances.iter().any(|stance| {
            let rise_m = NOTICED_SHARE * stance.height_m;
            let squares = shadows_m.iter().enumerate();
            let are_blind =
                squares.map(|(square, shadow_m)| self.is_blind(square, rise_m, (*shadow_m).into()));
            let are_blind: Vec<bool> = are_blind.collect();
            let [length_m, width_m] = [stance.length_m, stance.width_m].map(|m| HIDING_SHARE * m);
            self.squares.holds_stretch(&are_blind, length_m, width_m)
        })
    }

    /// Says whether something `rise_m` high on the content of a square could go unnoticed.
    fn is_blind(&self, square: usize, rise_m: f64, shadow_m: f64) -> bool {
        let height_m = |heights_m: &[f32]| heights_m.get(square).copied().map_or(0.0, f64::from);
        let top_m = height_m(&self.least_m) + rise_m;
        let is_in_shadow = shadow_m > height_m(&self.least_m);
        self.is_margin(square)
            || height_m(&self.most_m) >= self.container.z_m
            || top_m <= height_m(&self.blurred_m) + self.settings.least_rise_m
            || top_m <= shadow_m
            || !(self.is_seen(square) || is_in_shadow)
    }

    /// Says whether a pose is possible among what was there: neither in the floor, the walls or the
    /// content, nor in the air.
    pub(crate) fn admit(
        &self,
        object: &LibraryObject,
        container_from_item: &Isometry3<f64>,
    ) -> bool {
        let container = self.container;
        let rotation = container_from_item.rotation.to_rotation_matrix();
        let shift = container_from_item.translation.vector;
        let (mut sunk, mut gap_m) = (0_u32, f64::INFINITY);
        for point in &object.points {
            let place = rotation * point.point + shift;
            let beyond_m = container.beyond_walls_m(&place);
            let is_in_wall = beyond_m > SUNK_M && place.z < container.z_m - SUNK_M;
            let content_m = self.known(&self.certain_m, place.x, place.y).unwrap_or(0.0);
            sunk += u32::from(is_in_wall || place.z < content_m - SUNK_M);
            // On what is unknown, and on the rim, anything may rest.
            let below_m = self.blurred_at(place.x, place.y);
            gap_m = gap_m.min(below_m.map_or(0.0, |below_m| place.z - below_m));
        }
        f64::from(sunk) <= MOST_SUNK * object.points.len() as f64 && gap_m <= FLOATING_M
    }
}

/// Gives the greatest of some heights, in metres; at least that of the floor.
fn greatest(heights_m: &[f32]) -> f64 {
    f64::from(heights_m.iter().copied().fold(0.0, f32::max))
}
