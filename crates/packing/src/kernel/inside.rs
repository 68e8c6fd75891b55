//! The inside of a container in closed form: walls that lean outwards, and round vertical edges.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::fmt::{self, Display, Formatter};

use nalgebra::{Point2, Point3};
use ppnpack_numbers::{SettingError, require, within};

use crate::kernel::grid::{ContainerSize, Grid};

/// Faces of a round edge where it is drawn or simulated: 0.2 mm off one of 3 cm at most.
const EDGE_FACES: u32 = 6;

/// Points this close to a wall count as inside, in metres: their coordinates are rounded.
const ROUNDING_M: f64 = 1e-7;

impl ContainerSize {
    /// A box with these inner lengths, in metres.
    pub const fn cuboid(x_m: f64, y_m: f64, z_m: f64) -> Self {
        Self {
            x_m,
            y_m,
            z_m,
            draft_rad: 0.0,
            corner_radius_m: 0.0,
        }
    }

    /// Whether the walls are upright and the corners sharp.
    pub fn is_box(&self) -> bool {
        self.draft_rad == 0.0 && self.corner_radius_m == 0.0
    }

    /// Checks that the walls neither meet nor lean inwards, and that the corners fit between them.
    pub fn validate_shape(&self) -> Result<(), SettingError> {
        let leaning = within("at least 0 and below pi/4 (45 degrees)", 0.0..FRAC_PI_4);
        leaning("container.draft_rad", self.draft_rad)?;
        let floor_m = self.x_m.min(self.y_m) - 2.0 * self.setback_m(0.0);
        let expected = "so small that the walls do not meet above the floor";
        require("container.draft_rad", self.draft_rad, expected, |_| {
            floor_m > 0.0
        })?;
        let half_m = 0.5 * floor_m + ROUNDING_M;
        let expected = "at least 0 and at most half the floor's shorter side";
        let round = within(expected, 0.0..=half_m);
        round("container.corner_radius_m", self.corner_radius_m)
    }

    /// How far a wall at a height stands inside its place at the rim, in metres.
    pub fn setback_m(&self, z_m: f64) -> f64 {
        (self.z_m - z_m) * self.draft_rad.tan()
    }

    /// The corners of the walls where they stand so far inside their place at the rim, in metres,
    /// counter-clockwise from above. A round edge is a polygon around it.
    pub fn outline_m(&self, setback_m: f64) -> impl Iterator<Item = Point2<f64>> + use<> {
        let Self {
            x_m,
            y_m,
            corner_radius_m,
            ..
        } = *self;
        let faces = if corner_radius_m > 0.0 { EDGE_FACES } else { 1 };
        let turn_rad = FRAC_PI_2 / f64::from(faces);
        let inset_m = setback_m + corner_radius_m;
        let reach_m = corner_radius_m / (0.5 * turn_rad).cos();
        (0..4 * faces).map(move |corner| {
            let angle_rad = turn_rad * (f64::from(corner) + 0.5);
            let along = |side_m: f64, towards: f64| {
                let far_m = 0.5 * side_m - inset_m;
                0.5 * side_m + far_m * towards.signum() + reach_m * towards
            };
            Point2::new(along(x_m, angle_rad.cos()), along(y_m, angle_rad.sin()))
        })
    }

    /// The inner volume, in cubic metres.
    pub fn volume_m3(&self) -> f64 {
        self.volume_below_m3(self.z_m)
    }

    /// The inner volume below a height between floor and rim, in cubic metres.
    pub fn volume_below_m3(&self, z_m: f64) -> f64 {
        if self.is_box() {
            return self.x_m * self.y_m * z_m;
        }
        self.below_rim_m3(self.z_m) - self.below_rim_m3(self.z_m - z_m)
    }

    /// The inner volume from a depth below the rim up to it, in cubic metres.
    fn below_rim_m3(&self, depth_m: f64) -> f64 {
        let slope = self.draft_rad.tan();
        let sides_m = self.x_m + self.y_m;
        let corners_m2 = (4.0 - PI) * self.corner_radius_m.powi(2);
        let walls_m2 = depth_m * slope * (sides_m - 4.0 / 3.0 * slope * depth_m);
        depth_m * (self.x_m * self.y_m - walls_m2 - corners_m2)
    }

    /// The lowest height at which a point of the opening is inside, in metres: 0 above the floor,
    /// the rim where it is inside at no height.
    pub fn lowest_m(&self, x_m: f64, y_m: f64) -> f64 {
        self.lowest_beside(x_m.min(self.x_m - x_m), y_m.min(self.y_m - y_m))
    }

    /// Whether a point is at least so far from all walls, on their inner side; floor and rim do not
    /// count.
    pub fn holds(&self, point: &Point3<f64>, margin_m: f64) -> bool {
        if self.is_box() {
            let within = |at_m: f64, side_m: f64| (margin_m..=side_m - margin_m).contains(&at_m);
            return within(point.x, self.x_m) && within(point.y, self.y_m);
        }
        self.beyond_walls_m(point) <= ROUNDING_M - margin_m
    }

    /// How far a point is beyond the nearest wall, horizontally, in metres; below 0 on its inner
    /// side.
    pub fn beyond_walls_m(&self, point: &Point3<f64>) -> f64 {
        if self.is_box() {
            let (x_m, y_m) = (point.x - self.x_m, point.y - self.y_m);
            return (-point.x).max(-point.y).max(x_m).max(y_m);
        }
        let (x_m, y_m) = (self.x_m - point.x, self.y_m - point.y);
        self.setback_m(point.z) - self.room_m(point.x.min(x_m), point.y.min(y_m))
    }

    /// The lowest height at which a point is inside by its distances from the nearest walls at the
    /// rim along x and y, in metres. It falls with both.
    fn lowest_beside(&self, x_m: f64, y_m: f64) -> f64 {
        let room_m = self.room_m(x_m, y_m) + ROUNDING_M;
        if self.is_box() || room_m >= self.setback_m(0.0) {
            0.0
        } else if room_m <= 0.0 {
            self.z_m
        } else {
            self.z_m - room_m / self.draft_rad.tan()
        }
    }

    /// The setback of walls that pass through a point with these distances from the rim's, in
    /// metres.
    fn room_m(&self, x_m: f64, y_m: f64) -> f64 {
        let radius_m = self.corner_radius_m;
        let apart_m = x_m - y_m;
        if apart_m.abs() > radius_m {
            return x_m.min(y_m);
        }
        let root_m = (2.0 * radius_m.powi(2) - apart_m.powi(2)).sqrt();
        0.5 * (x_m + y_m + root_m) - radius_m
    }
}

impl Display for ContainerSize {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {} x {} m", self.x_m, self.y_m, self.z_m)?;
        if !self.is_box() {
            let draft = self.draft_rad.to_degrees();
            write!(f, " (draft {draft:.2} degrees, ")?;
            write!(f, "corner radius {} m)", self.corner_radius_m)?;
        }
        Ok(())
    }
}

impl Grid {
    /// The greatest height of the inside surface in each of so many squares along x and y, which
    /// begin at the origin, in metres, at most that of the rim in whole units; row-major.
    pub(crate) fn inside_m(&self, edge_m: f64, [nx, ny]: [usize; 2]) -> impl Iterator<Item = f32> {
        let size = self.container();
        let rim_m = f64::from(self.rim()) * self.resolution().height_unit_m();
        let beside = move |square: usize, side_m: f64| {
            let from_m = square as f64 * edge_m;
            from_m.min(side_m - from_m - edge_m)
        };
        let of_square = move |x, y| {
            let lowest_m = size.lowest_beside(beside(x, size.x_m), beside(y, size.y_m));
            rounded_down(lowest_m.min(rim_m))
        };
        (0..nx).flat_map(move |x| (0..ny).map(move |y| of_square(x, y)))
    }
}

/// Rounds down, so that a whole number of units stays one.
fn rounded_down(height_m: f64) -> f32 {
    let nearest_m = height_m as f32;
    if f64::from(nearest_m) > height_m {
        nearest_m.next_down()
    } else {
        nearest_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tote() -> ContainerSize {
        ContainerSize {
            draft_rad: 0.1_f64.atan(),
            corner_radius_m: 0.03,
            ..ContainerSize::cuboid(0.4, 0.3, 0.2)
        }
    }

    #[test]
    fn heights_beside_leaning_walls_and_round_corners_are_those_of_the_drawing() {
        let lowest = |x_m, y_m| tote().lowest_m(x_m, y_m);
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-5, "{found}");
        near(lowest(0.2, 0.15), 0.0);
        near(lowest(0.02, 0.15), 0.0);
        near(lowest(0.01, 0.15), 0.1);
        near(lowest(0.39, 0.15), 0.1);
        near(lowest(0.2, 0.295), 0.15);
        near(lowest(0.0, 0.15), 0.2);
        // At the corner, a point that is on the arc half-way up: 1 cm of setback, radius 3 cm.
        let on_arc_m = 0.01 + 0.03 - 0.03 / 2.0_f64.sqrt();
        near(lowest(on_arc_m, on_arc_m), 0.1);
        near(lowest(0.4 - on_arc_m, 0.3 - on_arc_m), 0.1);
        let (x_m, y_m) = (0.04 - 0.03 * 0.6, 0.04 - 0.03 * 0.8);
        near(lowest(x_m, y_m), 0.1);
        near(lowest(0.001, 0.001), 0.2);
        let on_wall = Point3::new(0.01, 0.15, 0.1);
        near(tote().beyond_walls_m(&on_wall), 0.0);
        near(
            tote().beyond_walls_m(&Point3::new(0.013, 0.15, 0.11)),
            -0.004,
        );
        assert!(tote().holds(&on_wall, 0.0) && !tote().holds(&on_wall, 0.001));
    }

    #[test]
    fn upright_walls_with_round_corners_leave_the_corners_out() {
        let size = ContainerSize {
            draft_rad: 0.0,
            ..tote()
        };
        assert_eq!(size.lowest_m(0.0, 0.15), 0.0);
        assert_eq!(size.lowest_m(0.008, 0.008), 0.2);
        assert_eq!(size.lowest_m(0.009, 0.009), 0.0);
    }

    #[test]
    fn the_volume_is_that_of_the_sum_of_thin_layers() {
        let size = tote();
        for top_m in [0.05, 0.2] {
            let layers = 1000;
            let thick_m = top_m / f64::from(layers);
            let layer = |layer: i32| {
                let setback_m = size.setback_m((f64::from(layer) + 0.5) * thick_m);
                let sides_m2 = (size.x_m - 2.0 * setback_m) * (size.y_m - 2.0 * setback_m);
                sides_m2 - (4.0 - PI) * 0.03 * 0.03
            };
            let expected = (0..layers).map(layer).sum::<f64>() * thick_m;
            let found = size.volume_below_m3(top_m);
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
        let reference = ContainerSize::REFERENCE;
        assert_eq!(reference.volume_m3(), 0.32 * 0.32 * 0.30);
    }

    #[test]
    fn the_outline_goes_around_the_inside_and_touches_it() {
        let size = tote();
        let outline_m: Vec<Point2<f64>> = size.outline_m(size.setback_m(0.1)).collect();
        assert_eq!(outline_m.len(), 24);
        for (corner, point) in outline_m.iter().enumerate() {
            let next = outline_m[(corner + 1) % outline_m.len()];
            let middle = nalgebra::center(point, &next);
            let lowest_m = |at: &Point2<f64>| size.lowest_m(at.x, at.y);
            assert!((lowest_m(&middle) - 0.1).abs() < 1e-5, "{middle}");
            assert!((0.1..0.104).contains(&lowest_m(point)), "{point}");
        }
        let sharp = ContainerSize::cuboid(0.4, 0.3, 0.2).outline_m(0.01);
        let expected = [[0.39, 0.29], [0.01, 0.29], [0.01, 0.01], [0.39, 0.01]];
        for (found, expected) in sharp.zip(expected) {
            assert!((found - Point2::from(expected)).norm() < 1e-12, "{found}");
        }
    }

    #[test]
    fn impossible_shapes_are_named() {
        let refused = |draft_rad, corner_radius_m| {
            let size = ContainerSize {
                draft_rad,
                corner_radius_m,
                ..tote()
            };
            size.validate_shape().unwrap_err().to_string()
        };
        for draft_rad in [-0.1, FRAC_PI_4, f64::NAN] {
            assert!(refused(draft_rad, 0.0).contains("draft_rad must be at least 0"));
        }
        assert!(refused(0.76_f64.atan(), 0.0).contains("walls do not meet"));
        for radius_m in [-0.01, 0.131, f64::NAN] {
            let expected = "corner_radius_m must be at least 0 and at most half the floor's";
            assert!(refused(0.1_f64.atan(), radius_m).contains(expected));
        }
        tote().validate_shape().unwrap();
    }
}
