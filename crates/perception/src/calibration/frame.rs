//! The container's frame: which corner is its origin, and which side is x.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector2, Vector3};
use ppnpack_packing::kernel::grid::ContainerSize;

use super::error::CalibrationError;
use super::found::Found;
use super::rectangle::directions;
use super::settings::CalibrationSettings;

/// Twice the maximum difference of sides that are as good as equal, in metres.
const SAME_SIDES_M: f64 = 0.002;

/// The pose and the size of the container.
pub(super) struct Placed {
    pub(super) container_from_levelled: Isometry3<f64>,
    pub(super) size: ContainerSize,
    pub(super) measured_size: ContainerSize,
}

/// Chooses the axes and the corner.
pub(super) fn place(
    found: &Found,
    settings: &CalibrationSettings,
) -> Result<Placed, CalibrationError> {
    // The sensor's x axis is x here.
    let mut wanted = directions(&Vector2::x());
    wanted.rotate_left(usize::from(settings.quarter_turns) % 4);
    let [wanted, ..] = wanted;
    let mut turns: Vec<usize> = (0..4).collect();
    let towards = directions(&found.rectangle.outward);
    let nearness = |turn: &usize| towards.get(*turn).map_or(-1.0, |axis| axis.dot(&wanted));
    turns.sort_by(|one, two| nearness(two).total_cmp(&nearness(one)));
    if let Some(known) = settings.size {
        let mismatch_m = |turn: &usize| {
            let sides = Sides::new(found, *turn, settings.size);
            sides.map_or(f64::INFINITY, |sides| sides.mismatch_m(&known))
        };
        let least_m = turns.iter().map(mismatch_m).fold(f64::INFINITY, f64::min);
        turns.retain(|turn| mismatch_m(turn) <= least_m + SAME_SIDES_M);
    }
    let tried = turns.into_iter().map(|turn| {
        Sides::new(found, turn, settings.size).and_then(|sides| sides.placed(settings))
    });
    // The first that fits; where none does, the first error.
    let first = tried.reduce(|first, next| first.or_else(|error| next.map_err(|_| error)));
    first.unwrap_or_else(|| Err(CalibrationError::no_rim()))
}

/// The container's extents along axes of which x is chosen.
struct Sides {
    x: Vector2<f64>,
    y: Vector2<f64>,
    /// From where to where along x and y, at the rim.
    x_m: [f64; 2],
    y_m: [f64; 2],
    floor_m: f64,
    measured_size: ContainerSize,
}

impl Sides {
    fn new(
        found: &Found,
        turn: usize,
        known: Option<ContainerSize>,
    ) -> Result<Self, CalibrationError> {
        let mut towards = directions(&found.rectangle.outward);
        let mut across_m = found.rectangle.across_m;
        towards.rotate_left(turn);
        across_m.rotate_left(turn);
        let ([x, y, ..], [x_end, y_end, x_beginning, y_beginning]) = (towards, across_m);
        let x_m = ends_m(x_end, x_beginning, known.map(|size| size.x_m))?;
        let y_m = ends_m(y_end, y_beginning, known.map(|size| size.y_m))?;
        Ok(Self {
            x,
            y,
            x_m,
            y_m,
            floor_m: found.surfaces.floor.mean.z,
            measured_size: ContainerSize {
                draft_rad: found.opening.lean.atan(),
                corner_radius_m: known.map_or(0.0, |size| size.corner_radius_m),
                ..ContainerSize::cuboid(x_m[1] - x_m[0], y_m[1] - y_m[0], found.surfaces.depth_m())
            },
        })
    }

    /// Gives the distance of the sides from known ones, together, in metres.
    fn mismatch_m(&self, known: &ContainerSize) -> f64 {
        let measured = &self.measured_size;
        (measured.x_m - known.x_m).abs() + (measured.y_m - known.y_m).abs()
    }

    fn placed(&self, settings: &CalibrationSettings) -> Result<Placed, CalibrationError> {
        let measured = self.measured_size;
        let size = settings.size.unwrap_or(measured);
        for (side, measured_m, known_m) in [
            ("x", measured.x_m, size.x_m),
            ("y", measured.y_m, size.y_m),
            ("z", measured.z_m, size.z_m),
        ] {
            if (measured_m - known_m).abs() > settings.size_tolerance_m {
                return Err(CalibrationError::new(format_args!(
                    "the container's {side} side was measured as {measured_m:.4} m, but is {known_m} m"
                )));
            }
        }
        // Where the size is known, it lies about the middle of what was measured.
        let corner_x_m = (self.x_m[0] + self.x_m[1] - size.x_m) / 2.0;
        let corner_y_m = (self.y_m[0] + self.y_m[1] - size.y_m) / 2.0;
        let corner = self.x * corner_x_m + self.y * corner_y_m;
        let origin = Point3::new(corner.x, corner.y, self.floor_m);
        let rows = Matrix3::from_rows(&[
            Vector3::new(self.x.x, self.x.y, 0.0).transpose(),
            Vector3::new(self.y.x, self.y.y, 0.0).transpose(),
            Vector3::z().transpose(),
        ]);
        let rotation =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rows));
        let translation = -(rotation * origin.coords);
        Ok(Placed {
            container_from_levelled: Isometry3::from_parts(translation.into(), rotation),
            size,
            measured_size: measured,
        })
    }
}

/// Gives the beginning and the end of the container along an axis, by the sides there, which lie so
/// far outwards. One of them is enough where the length is known.
fn ends_m(
    end: Option<f64>,
    beginning: Option<f64>,
    known_m: Option<f64>,
) -> Result<[f64; 2], CalibrationError> {
    match (end, beginning, known_m) {
        (Some(end), Some(beginning), _) => Ok([-beginning, end]),
        (Some(end), None, Some(known_m)) => Ok([end - known_m, end]),
        (None, Some(beginning), Some(known_m)) => Ok([-beginning, known_m - beginning]),
        _ => Err(CalibrationError::side_unseen()),
    }
}
