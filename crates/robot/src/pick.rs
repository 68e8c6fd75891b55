//! The place where the suction cup holds an item: a flat patch of its upper surface, as near above
//! its centre of mass as there is.

use nalgebra::{Matrix2, Point2, Point3, Vector2};
use ppnpack_numbers::{settings, within};

use crate::gripper::GripperPart;
use crate::parameters::GripperParameters;
use crate::surface::UpperSurface;

settings! {
    /// Conditions of what a cup can hold.
    ///
    /// A small bellows cup; the deviation lets the rounding of a heightmap's cells to 2 mm pass.
    #[derive(Copy)]
    pub struct PickSettings with validate as "pick." {
        /// Maximum deviation of a patch from a plane, in metres: what the lip's bellows even out.
        pub max_deviation_m: f64 = 0.002 => within("0 to 0.1 m", 0.0..=0.1),
        /// Maximum tilt of a patch, in degrees.
        pub max_tilt_deg: f64 = 15.0 => within("0 to 80", 0.0..=80.0),
        /// Patches tilted by no more than this are preferred to all others, in degrees.
        pub level_tilt_deg: f64 = 3.0 => within("0 to 80", 0.0..=80.0),
        /// Maximum distance of the cup from the centre of mass's vertical axis, in metres.
        pub max_offset_m: f64 = 0.05 => within("0 to 10 m", 0.0..=10.0),
    }
}

/// Reason why an item cannot be held: the later, the more tests a patch passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum NoPickPoint {
    /// There is no surface.
    #[error("its upper surface is empty")]
    Empty,
    /// The cup overhangs the item wherever it is near enough to the centre of mass.
    #[error("it is smaller than the cup near its centre of mass")]
    TooSmall,
    /// No patch near the centre of mass is flat enough.
    #[error("it is not flat enough near its centre of mass")]
    NotFlat,
    /// The gripper would hit higher parts of the item.
    #[error("higher parts of it are in the gripper's way")]
    GripperBlocked,
    /// No patch near the centre of mass is level enough.
    #[error("it is too steep near its centre of mass")]
    TooSteep,
}

/// The place at which an item is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PickPoint {
    /// The middle of the cup's lip in the item frame, in metres.
    pub in_item: Point3<f64>,
    /// The patch's tilt, in radians.
    pub tilt_rad: f64,
    /// The patch's deviation from a plane, in metres.
    pub deviation_m: f64,
    /// The distance from the centre of mass's vertical axis, in metres.
    pub offset_m: f64,
}

/// A plane through the squares under the cup.
struct Patch {
    height_m: f64,
    tilt_rad: f64,
    deviation_m: f64,
}

/// Finds the patch nearest to the centre of mass's vertical axis that the cup can hold: level ones
/// first, then tilted ones.
///
/// # Errors
/// [`NoPickPoint`]: of the patches tried, why the one that came furthest was refused.
pub fn find(
    surface: &UpperSurface,
    gripper: &GripperParameters,
    settings: &PickSettings,
) -> Result<PickPoint, NoPickPoint> {
    let axis_m = surface.centre_of_mass_m;
    let mut middles: Vec<_> = surface
        .middles_m()
        .map(|middle| ((middle - axis_m).norm(), middle))
        .filter(|(offset_m, _)| *offset_m <= settings.max_offset_m)
        .collect();
    middles.sort_by(|a, b| a.0.total_cmp(&b.0));
    let level_rad = settings.level_tilt_deg.to_radians();
    let steepest_rad = settings.max_tilt_deg.to_radians();
    let mut reason = NoPickPoint::Empty;
    let mut tilted = None;
    for (offset_m, middle_m) in middles {
        let patch = match usable_patch(surface, gripper, settings, middle_m) {
            Ok(patch) => patch,
            Err(refused) => {
                reason = reason.max(refused);
                continue;
            }
        };
        let in_surface = Point3::new(middle_m.x, middle_m.y, patch.height_m);
        let found = PickPoint {
            in_item: surface.item_from_surface * in_surface,
            tilt_rad: patch.tilt_rad,
            deviation_m: patch.deviation_m,
            offset_m,
        };
        if patch.tilt_rad <= level_rad {
            return Ok(found);
        }
        if patch.tilt_rad > steepest_rad {
            reason = reason.max(NoPickPoint::TooSteep);
        } else if tilted.is_none() {
            tilted = Some(found);
        }
    }
    tilted.ok_or(reason)
}

/// Fits the plane under the cup at a point, where it is flat and the gripper has room above the
/// item.
fn usable_patch(
    surface: &UpperSurface,
    gripper: &GripperParameters,
    settings: &PickSettings,
    middle_m: Point2<f64>,
) -> Result<Patch, NoPickPoint> {
    let patch = fit(surface, gripper.cup_radius_m + surface.edge_m, middle_m)?;
    if patch.deviation_m > settings.max_deviation_m {
        return Err(NoPickPoint::NotFlat);
    }
    let is_free = gripper.parts().into_iter().all(|(part, shape)| {
        let lowest_m = patch.height_m + shape.lowest_m;
        let mut around = surface.around(middle_m, shape.radius_m);
        part == GripperPart::Cup
            || around.all(|(_, height)| height.is_none_or(|height_m| height_m <= lowest_m))
    });
    is_free.then_some(patch).ok_or(NoPickPoint::GripperBlocked)
}

/// Fits the plane of least squares through the squares that a disc touches.
fn fit(surface: &UpperSurface, radius_m: f64, middle_m: Point2<f64>) -> Result<Patch, NoPickPoint> {
    let (mut count, mut offsets, mut heights_m) = (0.0, Vector2::zeros(), 0.0);
    for (offset, height) in surface.around(middle_m, radius_m) {
        count += 1.0;
        offsets += offset;
        heights_m += height.ok_or(NoPickPoint::TooSmall)?;
    }
    if count == 0.0 {
        return Err(NoPickPoint::Empty);
    }
    let (mean_offset, mean_m) = (offsets / count, heights_m / count);
    let (mut spread, mut moment) = (Matrix2::zeros(), Vector2::zeros());
    for (offset, height) in surface.around(middle_m, radius_m) {
        let from_mean = offset - mean_offset;
        spread += from_mean * from_mean.transpose();
        moment += from_mean * (height.unwrap_or(mean_m) - mean_m);
    }
    // Squares in one row show no slope across it.
    let inverse = spread.try_inverse();
    let slope = inverse.map_or(Vector2::zeros(), |inverse| inverse * moment);
    let height_at = |offset: Vector2<f64>| mean_m + slope.dot(&(offset - mean_offset));
    let around = surface.around(middle_m, radius_m);
    let off_m = around.filter_map(|(offset, height)| Some((height? - height_at(offset)).abs()));
    Ok(Patch {
        height_m: height_at(Vector2::zeros()),
        tilt_rad: slope.norm().atan(),
        deviation_m: off_m.fold(0.0, f64::max),
    })
}
