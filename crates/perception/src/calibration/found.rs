//! A look at a cloud for a container, with a direction that is taken to be up.

use nalgebra::{Point3, Unit, Vector3};

use super::error::CalibrationError;
use super::levelled::Levelled;
use super::opening::{self, Opening};
use super::plane::{Spread, median, normal_of};
use super::rectangle::{self, Rectangle};
use super::settings::CalibrationSettings;

/// Maximum distance of the floor's points from its height, in metres.
const FLOOR_BAND_M: f64 = 0.008;

/// Maximum distance of the rim's points from its height, in metres.
pub(super) const RIM_BAND_M: f64 = 0.008;

/// Range of the rim's distances outside the walls' inner faces, in metres.
const RIM_M: std::ops::Range<f64> = 0.0005..0.02;

/// Minimum distance from a wall of points of the floor and of content, in metres.
pub(super) const WALL_MARGIN_M: f64 = 0.015;

/// Things that one look finds.
pub(super) struct Found {
    pub(super) levelled: Levelled,
    pub(super) opening: Opening,
    pub(super) rectangle: Rectangle,
    pub(super) surfaces: Surfaces,
}

impl Found {
    /// Looks for the container's opening, sides, floor and rim.
    ///
    /// Walls are taken to lean outwards by `lean`, per metre of height.
    pub(super) fn look(
        points_m: &[Point3<f64>],
        up: &Unit<Vector3<f64>>,
        lean: f64,
        settings: &CalibrationSettings,
    ) -> Result<Self, CalibrationError> {
        let levelled = Levelled::new(points_m, up);
        let opening = Opening {
            lean,
            ..opening::find(&levelled, settings)?
        };
        let rectangle = rectangle::find(&levelled, &opening, settings)?;
        let surfaces = Surfaces::fit(&levelled, &opening, &rectangle)?;
        Ok(Self {
            levelled,
            opening,
            rectangle,
            surfaces,
        })
    }

    /// Gives how far the walls lean outwards, per metre of height: the median of those seen.
    pub(super) fn lean(&self) -> f64 {
        let walls = self.rectangle.sides.iter().filter_map(|side| side.wall);
        let mut leans: Vec<f64> = walls.map(|wall| wall.lean).collect();
        match leans.is_empty() {
            true => self.opening.lean,
            false => median(&mut leans),
        }
    }
}

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
                && rectangle.floor_contains(&point.xy(), WALL_MARGIN_M)
        });
        let rim = points().filter(|point| {
            (point.z - opening.rim_m).abs() <= RIM_BAND_M
                && RIM_M.contains(&-rectangle.inside_m(&point.xy()))
        });
        Ok(Self {
            floor: Spread::of(floor).ok_or_else(|| CalibrationError::no_floor(0.0))?,
            rim: Spread::of(rim).ok_or_else(CalibrationError::no_rim)?,
        })
    }

    /// Gives up by both planes, in the sensor's frame.
    pub(super) fn up(&self, levelled: &Levelled) -> Unit<Vector3<f64>> {
        let up = normal_of(self.floor.scatter + self.rim.scatter, &Vector3::z());
        levelled.levelled_from_sensor.rotation.inverse() * up
    }

    /// Gives the depth of the container, in metres.
    pub(super) fn depth_m(&self) -> f64 {
        self.rim.mean.z - self.floor.mean.z
    }

    pub(super) fn parallelism_rad(&self) -> f64 {
        let up = Vector3::z();
        self.floor.normal(&up).angle(&self.rim.normal(&up))
    }
}
